//! glTF 2.0, as text and as GLB, by the crate `gltf`: the triangles of its scene in metres, along the axes of the file, as published robots mean
//! them, and not turned from glTF's y up.

use std::path::Path;
use std::sync::Arc;

use gltf::image::{Data, Format};
use gltf::mesh::{Mode, Semantic};
use signorini_multibody::Image;
use signorini_multibody::glam::{DMat4, DVec3};
use signorini_multibody::model::Mesh;

use super::bytes::read_file;
use super::painted::{Corners, NOWHERE, Paint, Painted, Source};
use super::picture;

/// Scenes nested deeper than this are refused, as are those that contain themselves.
const MAX_DEPTH: usize = 64;
/// More corners than this, copies counted, are refused.
const MAX_CORNERS: usize = 30_000_000;

/// Files larger than this are refused.
const MAX_BYTES: u64 = 512 << 20;

struct Scene {
    buffers: Vec<gltf::buffer::Data>,
    painted: Painted,
}

/// Reads a file that stands for itself (GLB, or text with its data in it).
pub(super) fn read(bytes: &[u8]) -> Result<Painted, String> {
    check_attributes(bytes)?;
    let (document, buffers, images) = gltf::import_slice(bytes).map_err(|e| e.to_string())?;
    of(&document, buffers, images)
}

/// Reads a file with those that it names.
pub(super) fn load(path: &Path) -> Result<Painted, String> {
    check_attributes(&read_file(path, MAX_BYTES)?)?;
    let (document, buffers, images) = gltf::import(path).map_err(|e| e.to_string())?;
    of(&document, buffers, images)
}

fn of(document: &gltf::Document, buffers: Vec<gltf::buffer::Data>, images: Vec<Data>) -> Result<Painted, String> {
    check_accessors(document, &buffers)?;
    let images: Vec<Option<Arc<Image>>> = images.into_iter().map(|image| pixels(image).map(Arc::new)).collect();
    let paints = document.materials().map(|material| paint(&material, &images)).collect();
    let mut scene = Scene { buffers, painted: Painted { paints, ..Painted::default() } };
    let axes = DMat4::IDENTITY;
    let shown = document.default_scene().or_else(|| document.scenes().next());
    match shown {
        Some(shown) => shown.nodes().try_for_each(|node| scene.add_node(&node, axes, 0))?,
        None => document.meshes().try_for_each(|mesh| scene.add_mesh(&mesh, axes))?,
    }
    Ok(scene.painted)
}

/// Whether a binary file is as long as it says: the crate subtracts the length of the header from that, and asks for so much memory.
fn check_length(bytes: &[u8]) -> Result<(), String> {
    let Some((b"glTF", rest)) = bytes.split_first_chunk() else { return Ok(()) };
    let said = rest.get(4..8).and_then(|length| length.try_into().ok()).map_or(0, u32::from_le_bytes) as usize;
    match (12..=bytes.len()).contains(&said) {
        true => Ok(()),
        false => Err(format!("its header speaks of {said} bytes, there are {}", bytes.len())),
    }
}

/// Whether the attributes of every primitive are there: the crate's own check takes that for granted.
fn check_attributes(bytes: &[u8]) -> Result<(), String> {
    check_length(bytes)?;
    let file = gltf::Gltf::from_slice_without_validation(bytes).map_err(|e| e.to_string())?;
    let root = file.document.as_json();
    let primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    match primitives.flat_map(|p| p.attributes.values()).any(|index| index.value() >= root.accessors.len()) {
        true => Err("a primitive names an accessor that is not there".into()),
        false => Ok(()),
    }
}

/// Whether the numbers of a primitive are of the types that the specification gives them, which the crate's readers take for granted.
fn has_usual_types(primitive: &gltf::Primitive) -> bool {
    use gltf::accessor::{DataType, Dimensions};
    let sort = |accessor: gltf::Accessor| (accessor.data_type(), accessor.dimensions());
    let positions = primitive.get(&Semantic::Positions).map(sort);
    let places = primitive.get(&Semantic::TexCoords(0)).map(sort);
    let indices = primitive.indices().map(sort);
    matches!(positions, None | Some((DataType::F32, Dimensions::Vec3)))
        && matches!(places, None | Some((DataType::F32 | DataType::U8 | DataType::U16, Dimensions::Vec2)))
        && matches!(indices, None | Some((DataType::U8 | DataType::U16 | DataType::U32, Dimensions::Scalar)))
}

/// Whether every accessor lies within its buffer: the crate's readers take that for granted.
fn check_accessors(document: &gltf::Document, buffers: &[gltf::buffer::Data]) -> Result<(), String> {
    let fits = |view: &gltf::buffer::View, offset: usize, count: usize, size: usize| {
        let stride = view.stride().unwrap_or(size).max(size);
        let length = count.saturating_sub(1).checked_mul(stride)?.checked_add(size)?.checked_add(offset)?;
        let end = view.offset().checked_add(view.length())?;
        (length <= view.length() && end <= buffers.get(view.buffer().index())?.len()).then_some(())
    };
    for accessor in document.accessors() {
        let own = accessor.view().map(|view| fits(&view, accessor.offset(), accessor.count(), accessor.size()));
        if accessor.count() == 0 {
            return Err(format!("accessor {} holds nothing", accessor.index()));
        }
        if accessor.sparse().is_some() {
            return Err("sparse accessors are not supported".into());
        }
        if own == Some(None) {
            return Err(format!("accessor {} reaches beyond its buffer", accessor.index()));
        }
    }
    Ok(())
}

impl Scene {
    fn add_node(&mut self, node: &gltf::Node, frame: DMat4, depth: usize) -> Result<(), String> {
        if depth > MAX_DEPTH {
            return Err(format!("nested more than {MAX_DEPTH} deep, or within itself"));
        }
        let own = node.transform().matrix().map(|column| column.map(f64::from));
        let frame = frame * DMat4::from_cols_array_2d(&own);
        if let Some(mesh) = node.mesh() {
            self.painted.begin_part(node.name().or(mesh.name()).unwrap_or(""));
            self.add_mesh(&mesh, frame)?;
        }
        node.children().try_for_each(|child| self.add_node(&child, frame, depth + 1))
    }

    fn add_mesh(&mut self, mesh: &gltf::Mesh, frame: DMat4) -> Result<(), String> {
        for primitive in mesh.primitives() {
            if primitive.mode() != Mode::Triangles {
                continue;
            }
            if !has_usual_types(&primitive) {
                return Err("numbers of other types than glTF gives them".into());
            }
            let reader = primitive.reader(|buffer| self.buffers.get(buffer.index()).map(|data| &data.0[..]));
            let Some(positions) = reader.read_positions() else { continue };
            let points: Vec<DVec3> =
                positions.map(|p| frame.transform_point3(DVec3::from_array(p.map(f64::from)))).collect();
            let places: Option<Vec<[f32; 2]>> =
                reader.read_tex_coords(0).map(|places| places.into_f32().map(|[u, v]| [u, 1.0 - v]).collect());
            let indices: Vec<u32> = match reader.read_indices() {
                Some(indices) => indices.into_u32().collect(),
                None => (0..points.len() as u32).collect(),
            };
            let paint = primitive.material().index().map_or(u32::MAX, |k| k as u32);
            self.add_triangles(points, places.as_deref(), &indices, paint, frame.determinant() < 0.0)?;
        }
        Ok(())
    }

    fn add_triangles(
        &mut self,
        points: Vec<DVec3>,
        places: Option<&[[f32; 2]]>,
        indices: &[u32],
        paint: u32,
        mirrored: bool,
    ) -> Result<(), String> {
        let Painted { mesh: Mesh { vertices, triangles }, corners, paint_of, .. } = &mut self.painted;
        let (first, count) = (vertices.len(), points.len());
        if first + count > MAX_CORNERS || 3 * triangles.len() + indices.len() > MAX_CORNERS {
            return Err(format!("more than {MAX_CORNERS} corners"));
        }
        if points.iter().any(|p| !p.is_finite()) {
            return Err("a vertex is not finite".into());
        }
        vertices.extend(points);
        for face in indices.chunks_exact(3) {
            let [a, b, c] = if mirrored { [face[0], face[2], face[1]] } else { [face[0], face[1], face[2]] };
            if [a, b, c].iter().any(|&k| k as usize >= count) {
                return Err("a face names a vertex that is not there".into());
            }
            triangles.push([a, b, c].map(|k| k + first as u32));
            let place = |k: u32| places.and_then(|places| places.get(k as usize)).copied();
            let own: Option<Vec<[f32; 2]>> = [a, b, c].into_iter().map(place).collect();
            corners.push(own.and_then(|own| Corners::try_from(own).ok()).unwrap_or(NOWHERE));
            paint_of.push(paint);
        }
        Ok(())
    }
}

fn paint(material: &gltf::Material, images: &[Option<Arc<Image>>]) -> Paint {
    let metal = material.pbr_metallic_roughness();
    let [r, g, b, a] = metal.base_color_factor();
    let opacity = if material.alpha_mode() == gltf::material::AlphaMode::Blend { a } else { 1.0 };
    let image =
        metal.base_color_texture().and_then(|info| images.get(info.texture().source().index()).cloned().flatten());
    // Factors are in linear light, colours elsewhere in sRGB.
    let encoded = |x: f32| match x {
        x if x <= 0.003_130_8 => 12.92 * x,
        x if x < 1.0 => 1.055 * x.powf(1.0 / 2.4) - 0.055,
        _ => 1.0,
    };
    Paint { rgba: Some([encoded(r), encoded(g), encoded(b), opacity]), image: image.map(Source::Here) }
}

/// The colours of an image of eight bits; none of other ones.
fn pixels(image: Data) -> Option<Image> {
    let bytes = match image.format {
        Format::R8G8B8 => image.pixels,
        Format::R8G8B8A8 => image.pixels.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).collect(),
        Format::R8 => image.pixels.iter().flat_map(|&p| [p; 3]).collect(),
        Format::R8G8 => image.pixels.chunks_exact(2).flat_map(|p| [p[0]; 3]).collect(),
        _ => return None,
    };
    picture::kept(image::RgbImage::from_raw(image.width, image.height, bytes)?).ok()
}
