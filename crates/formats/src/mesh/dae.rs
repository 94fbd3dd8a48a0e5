//! COLLADA: the triangles of the scene in metres, and their colours. Normals, animation, skins are passed over, and so is `<up_axis>`, as in Gazebo
//! and RViz: of published robots those whose links touch with an STL mesh beside a COLLADA file with y up have both along the same axes.
//!
//! # Source
//! COLLADA 1.4.1 specification, ch. 5 (core elements and geometry).

use std::collections::HashMap;
use std::path::Path;

use signorini_multibody::glam::{DMat4, DQuat, DVec3};

use super::dae_effects::paint;
use super::dae_xml::{attribute, child, children, line, numbers};
use super::painted::{Corners, NOWHERE, Painted};
use crate::xml::{Element, parse};

/// Scenes nested deeper than this are refused, as are those that contain themselves.
const MAX_DEPTH: usize = 64;
/// More corners than this, copies counted, are refused.
const MAX_CORNERS: usize = 30_000_000;

/// Reads all geometries that the scene shows, each where its nodes place it; without a scene each where it is.
///
/// - `folder`: that of the file, in which its images lie
pub(super) fn read(bytes: &[u8], folder: &Path) -> Result<Painted, String> {
    let text = &String::from_utf8_lossy(bytes);
    let tree = parse(text, "COLLADA").map_err(|e| e.to_string())?;
    let root = tree.root();
    if !root.is("COLLADA") {
        return Err(format!("the root element is <{}>, expected <COLLADA>", root.name()));
    }
    let by_id = tree.elements().filter_map(|n| Some((attribute(n, "id")?, n))).collect();
    let mut scene =
        Scene { by_id, folder, painted: Painted::default(), shapes: HashMap::new(), known: HashMap::new(), name: "" };
    let axes = to_metres(root)?;
    match child(root, "scene").and_then(|s| child(s, "instance_visual_scene")) {
        Some(instance) => {
            let visual = scene.target(instance, "url")?;
            scene.add_children(visual, axes, 0)?;
        }
        None => {
            let libraries = children(root, "library_geometries");
            let geometries: Vec<Element> = libraries.flat_map(|l| children(l, "geometry")).collect();
            for geometry in geometries {
                scene.name = attribute(geometry, "name").unwrap_or("");
                scene.add_geometry(geometry, axes, None)?;
            }
        }
    }
    Ok(scene.painted)
}

/// `<unit meter>` as a map.
fn to_metres(root: Element) -> Result<DMat4, String> {
    let asset = child(root, "asset");
    let unit = asset.and_then(|a| child(a, "unit")).and_then(|u| attribute(u, "meter"));
    let unit: f64 = unit.map_or(Ok(1.0), |m| m.trim().parse().map_err(|_| "<unit meter> is not a number"))?;
    if unit.is_finite() && unit > 0.0 {
        Ok(DMat4::from_scale(DVec3::splat(unit)))
    } else {
        Err(format!("<unit meter=\"{unit}\"> is not positive"))
    }
}

/// A geometry in its own frame.
#[derive(Default)]
struct Shape<'d> {
    points: Vec<DVec3>,
    faces: Vec<Faces<'d>>,
}

/// Triangles of a geometry that are of one material.
struct Faces<'d> {
    /// The name that whoever shows the geometry gives a material for.
    symbol: Option<&'d str>,
    triangles: Vec<[u32; 3]>,
    /// One for each triangle.
    corners: Vec<Corners>,
}

struct Scene<'d, 'f> {
    by_id: HashMap<&'d str, Element<'d>>,
    folder: &'f Path,
    painted: Painted,
    shapes: HashMap<usize, std::rc::Rc<Shape<'d>>>,
    /// Materials met so far, by their element, and their index.
    known: HashMap<usize, u32>,
    /// The name of the nearest node around that has one.
    name: &'d str,
}

impl<'d> Scene<'d, '_> {
    /// The element that an attribute such as `url="#id"` refers to.
    fn target(&self, node: Element<'d>, name: &str) -> Result<Element<'d>, String> {
        let place = || format!("line {}: <{}>", line(node), node.name());
        let uri = attribute(node, name).ok_or_else(|| format!("{} needs attribute '{name}'", place()))?;
        let found = uri.strip_prefix('#').and_then(|id| self.by_id.get(id)).copied();
        found.ok_or_else(|| format!("{} refers to '{uri}', which is not in the file", place()))
    }

    /// Adds what a node or a scene contains.
    fn add_children(&mut self, parent: Element<'d>, frame: DMat4, depth: usize) -> Result<(), String> {
        if depth > MAX_DEPTH {
            return Err(format!("line {}: nested more than {MAX_DEPTH} deep, or within itself", line(parent)));
        }
        for node in parent.children() {
            match node.name() {
                "node" => self.add_node(node, frame, depth)?,
                "instance_node" => self.add_node(self.target(node, "url")?, frame, depth)?,
                "instance_geometry" => self.add_geometry(self.target(node, "url")?, frame, Some(node))?,
                _ => {}
            }
        }
        Ok(())
    }

    fn add_node(&mut self, node: Element<'d>, frame: DMat4, depth: usize) -> Result<(), String> {
        let around = self.name;
        self.name = attribute(node, "name").unwrap_or(around);
        self.add_children(node, frame * local_transform(node)?, depth + 1)?;
        self.name = around;
        Ok(())
    }

    /// Adds a geometry.
    ///
    /// - `shown_by`: says which materials its faces have
    fn add_geometry(
        &mut self,
        geometry: Element<'d>,
        frame: DMat4,
        shown_by: Option<Element<'d>>,
    ) -> Result<(), String> {
        // Splines and convex hulls of other geometries have no triangles.
        let Some(mesh) = child(geometry, "mesh") else { return Ok(()) };
        let shape = match self.shapes.get(&geometry.index()) {
            Some(shape) => shape.clone(),
            None => {
                let shape = std::rc::Rc::new(self.read_mesh(mesh)?);
                self.shapes.insert(geometry.index(), shape.clone());
                shape
            }
        };
        let first = self.painted.mesh.vertices.len();
        let triangles: usize = shape.faces.iter().map(|faces| faces.triangles.len()).sum();
        let known = self.painted.mesh.triangles.len();
        if first + shape.points.len() > MAX_CORNERS || 3 * (known + triangles) > MAX_CORNERS {
            return Err(format!("more than {MAX_CORNERS} corners"));
        }
        for p in &shape.points {
            let p = frame.transform_point3(*p);
            if !p.is_finite() {
                return Err(format!("line {}: a vertex is not finite", line(geometry)));
            }
            self.painted.mesh.vertices.push(p);
        }
        self.painted.begin_part(self.name);
        let mirrored = frame.determinant() < 0.0;
        for faces in &shape.faces {
            let paint = self.paint_of(faces.symbol, shown_by);
            for (triangle, corners) in faces.triangles.iter().zip(&faces.corners) {
                let [a, b, c] = triangle.map(|k| k + first as u32);
                let [u, v, w] = *corners;
                self.painted.mesh.triangles.push(if mirrored { [a, c, b] } else { [a, b, c] });
                self.painted.corners.push(if mirrored { [u, w, v] } else { [u, v, w] });
                self.painted.paint_of.push(paint);
            }
        }
        Ok(())
    }

    /// The index of the material that whoever shows a geometry gives for a symbol.
    fn paint_of(&mut self, symbol: Option<&str>, shown_by: Option<Element<'d>>) -> u32 {
        let bound = shown_by.and_then(|node| child(node, "bind_material")).and_then(|b| child(b, "technique_common"));
        let mut bindings = bound.into_iter().flat_map(|b| children(b, "instance_material"));
        let binding = bindings.find(|b| attribute(*b, "symbol") == symbol);
        // Some files name the material itself.
        let material = match binding {
            Some(binding) => self.target(binding, "target").ok(),
            None => symbol.and_then(|id| self.by_id.get(id)).copied(),
        };
        let Some(material) = material.filter(|m| m.is("material")) else { return u32::MAX };
        if let Some(&known) = self.known.get(&material.index()) {
            return known;
        }
        let index = self.painted.paints.len() as u32;
        self.painted.paints.push(paint(&self.by_id, material, self.folder));
        self.known.insert(material.index(), index);
        index
    }

    fn read_mesh(&self, mesh: Element<'d>) -> Result<Shape<'d>, String> {
        let Some(vertices) = child(mesh, "vertices") else { return Ok(Shape::default()) };
        let input = children(vertices, "input").find(|i| attribute(*i, "semantic") == Some("POSITION"));
        let input = input.ok_or_else(|| format!("line {}: <vertices> without positions", line(vertices)))?;
        let points = self.read_points(self.target(input, "source")?)?;
        let mut faces = Vec::new();
        for primitive in mesh.children() {
            let counts: Vec<usize> = match primitive.name() {
                "polylist" => numbers(child(primitive, "vcount"))?,
                "triangles" | "polygons" => Vec::new(),
                _ => continue,
            };
            let corners_of = |face: usize| match primitive.name() {
                "triangles" => Some(3),
                "polylist" => counts.get(face).copied(),
                _ => None,
            };
            faces.push(self.read_faces(primitive, points.len(), corners_of)?);
        }
        Ok(Shape { points, faces })
    }

    /// The faces of a primitive as fans of triangles. `corners`: number of corners of each face; none where each `<p>` is one face.
    fn read_faces(
        &self,
        primitive: Element<'d>,
        vertices: usize,
        corners: impl Fn(usize) -> Option<usize>,
    ) -> Result<Faces<'d>, String> {
        let mut faces = Faces { symbol: attribute(primitive, "material"), triangles: Vec::new(), corners: Vec::new() };
        let offset =
            |input: &Element| attribute(*input, "offset").and_then(|o| o.trim().parse::<usize>().ok()).unwrap_or(0);
        let inputs: Vec<Element> = children(primitive, "input").collect();
        let stride = inputs.iter().map(offset).max().unwrap_or(0).saturating_add(1);
        let of = |semantic: &str| inputs.iter().find(|i| attribute(**i, "semantic") == Some(semantic));
        let Some(own) = of("VERTEX").map(offset) else { return Ok(faces) };
        let places = of("TEXCOORD").and_then(|input| Some((offset(input), self.read_places(*input)?)));
        let place = |corner: &[usize]| {
            let found = places.as_ref().and_then(|(offset, places)| places.get(corner[*offset]));
            found.copied().unwrap_or([f32::NAN; 2])
        };
        for list in children(primitive, "p") {
            let indices: Vec<usize> = numbers(Some(list))?;
            let indices: Vec<&[usize]> = indices.chunks_exact(stride).collect();
            if let Some(k) = indices.iter().map(|corner| corner[own]).find(|&k| k >= vertices) {
                return Err(format!("line {}: a face names vertex {k} of {vertices}", line(list)));
            }
            let (mut start, mut face) = (0, 0);
            while start < indices.len() {
                let count = corners(face).unwrap_or(indices.len()).max(1);
                let polygon = &indices[start..indices.len().min(start.saturating_add(count))];
                for pair in polygon.get(1..).unwrap_or_default().windows(2) {
                    let triangle = [polygon[0], pair[0], pair[1]];
                    faces.triangles.push(triangle.map(|corner| corner[own] as u32));
                    faces.corners.push(if places.is_some() { triangle.map(place) } else { NOWHERE });
                }
                start = start.saturating_add(count);
                face += 1;
            }
        }
        Ok(faces)
    }

    /// Image coordinates; none where they cannot be read.
    fn read_places(&self, input: Element<'d>) -> Option<Vec<[f32; 2]>> {
        let source = self.target(input, "source").ok()?;
        let (stride, offset) = layout(source);
        let floats: Vec<f32> = numbers(child(source, "float_array")).ok()?;
        let rest = floats.get(offset..)?;
        (stride.unwrap_or(2) >= 2).then(|| rest.chunks_exact(stride.unwrap_or(2)).map(|p| [p[0], p[1]]).collect())
    }

    fn read_points(&self, source: Element<'d>) -> Result<Vec<DVec3>, String> {
        let (stride, offset) = layout(source);
        let stride = stride.unwrap_or(3);
        if stride < 3 {
            return Err(format!("line {}: positions with {stride} coordinates", line(source)));
        }
        let floats: Vec<f64> = numbers(child(source, "float_array"))?;
        let rest = floats.get(offset..).unwrap_or_default();
        Ok(rest.chunks_exact(stride).map(DVec3::from_slice).collect())
    }
}

/// How many numbers of a source belong together, if it says so, and where the first are.
fn layout(source: Element) -> (Option<usize>, usize) {
    let accessor = child(source, "technique_common").and_then(|t| child(t, "accessor"));
    let own = |name| accessor.and_then(|a| attribute(a, name)).and_then(|s| s.trim().parse::<usize>().ok());
    (own("stride"), own("offset").unwrap_or(0))
}

/// The product of the transformations of a node, in their order.
fn local_transform(node: Element) -> Result<DMat4, String> {
    let mut transform = DMat4::IDENTITY;
    for element in node.children() {
        let name = element.name();
        let count = match name {
            "matrix" => 16,
            "rotate" => 4,
            "translate" | "scale" => 3,
            _ => continue,
        };
        let x: Vec<f64> = numbers(Some(element))?;
        if x.len() != count {
            return Err(format!("line {}: <{name}> has {} numbers, expected {count}", line(element), x.len()));
        }
        transform *= match name {
            "matrix" => DMat4::from_cols_slice(&x).transpose(),
            "translate" => DMat4::from_translation(DVec3::from_slice(&x)),
            "scale" => DMat4::from_scale(DVec3::from_slice(&x)),
            _ => match crate::xml::unit(DVec3::from_slice(&x)) {
                Some(axis) => DMat4::from_quat(DQuat::from_axis_angle(axis, x[3].to_radians())),
                None => DMat4::IDENTITY,
            },
        };
    }
    Ok(transform)
}
