//! Triangle meshes for the page: each once, simplified as far as the eye forgives and the page needs, in 16 bits.

use std::collections::HashMap;
use std::mem::take;

use meshopt::{SimplifyOptions, VertexDataAdapter};
use serde::Serialize;

use super::coding;
use crate::header::{Header, ShapeVisual};
use crate::looks::SpreadVisual;

/// How far a simplified surface may lie from the mesh, as a share of the mesh's size. The first is less than a pixel of a part
/// that fills a tenth of the picture; the others follow while the meshes take more than their room.
const ERRORS: [f32; 6] = [0.001, 0.003, 0.01, 0.03, 0.1, 0.3];
/// Coordinates are whole numbers from 0 to this along the longest side.
const STEPS: f32 = 65535.0;

/// A mesh in the block: where its numbers are, and what they mean.
#[derive(Debug, Serialize)]
pub(super) struct MeshPlace {
    /// Where it starts in the block: vertices' coordinates as u16, those on an image, then the indices of its triangles.
    offset: usize,
    vertices: usize,
    triangles: usize,
    /// The place of the numbers 0, 0, 0, and the length of one unit, m.
    low: [f32; 3],
    unit: f32,
    /// The same of image coordinates, as u16 after those of space; none where the mesh has none.
    #[serde(skip_serializing_if = "Option::is_none")]
    places: Option<([f32; 2], f32)>,
}

/// The meshes of a page.
#[derive(Debug, Default, Serialize)]
pub(super) struct PageMeshes {
    /// The mesh of each geom that has one.
    of_geom: Vec<Option<usize>>,
    places: Vec<MeshPlace>,
    /// The block, deflated and as text.
    #[serde(skip)]
    pub text: String,
}

/// A mesh in single precision.
struct Triangles {
    vertices: Vec<Vertex>,
    indices: Vec<u32>,
    /// Whether its vertices have image coordinates.
    placed: bool,
}

/// x, y, z and image coordinates.
type Vertex = [f32; 5];

impl PageMeshes {
    /// Takes the triangles out of the header's shapes. As long as their text is longer than `room` they become coarser. Images that take
    /// more than that become smaller.
    pub fn take_from(header: &mut Header, room: usize) -> Self {
        shrink_images(header, room);
        let (meshes, of_geom) = distinct_meshes(header);
        let mut packed = Self::default();
        for error in ERRORS {
            packed = Self::pack(&meshes, error);
            if packed.text.len() <= room {
                break;
            }
        }
        Self { of_geom, ..packed }
    }

    fn pack(meshes: &[Triangles], error: f32) -> Self {
        let mut block = Vec::new();
        let places = meshes.iter().map(|mesh| mesh.simplified(error).write(&mut block)).collect();
        let text = if meshes.is_empty() { String::new() } else { coding::pack(&block) };
        Self { of_geom: Vec::new(), places, text }
    }
}

/// Sides of images, in pixels, from the finest on.
const SIDES: [u32; 3] = [256, 128, 64];

fn shrink_images(header: &mut Header, room: usize) {
    for side in SIDES {
        if header.images.iter().map(|image| image.base64.len()).sum::<usize>() <= room {
            return;
        }
        for image in &mut header.images {
            if let Some(smaller) = image.smaller(side) {
                *image = smaller;
            }
        }
    }
}

/// The meshes of a header, equal ones once, and which of them each geom has.
fn distinct_meshes(header: &mut Header) -> (Vec<Triangles>, Vec<Option<usize>>) {
    let mut known = HashMap::new();
    let mut meshes = Vec::new();
    let of_geom = header.geoms.iter_mut().map(|geom| {
        let ShapeVisual::Mesh { vertices, faces } = &mut geom.shape else { return None };
        let corners = match geom.look.texture.as_mut().map(|texture| &mut texture.spread) {
            Some(SpreadVisual::Corners(corners)) => take(corners),
            _ => Vec::new(),
        };
        let (vertices, faces) = (take(vertices), take(faces));
        let bits: Vec<[u32; 3]> = vertices.iter().map(|p| p.map(f32::to_bits)).collect();
        let places: Vec<[u32; 2]> = corners.as_flattened().iter().map(|p| p.map(f32::to_bits)).collect();
        let number = *known.entry((bits, faces, places)).or_insert_with_key(|(_, faces, _)| {
            meshes.push(Triangles::new(&vertices, faces, &corners));
            meshes.len() - 1
        });
        Some(number)
    });
    let of_geom = of_geom.collect();
    (meshes, of_geom)
}

impl Triangles {
    /// Vertices of several places on an image are several vertices.
    fn new(vertices: &[[f32; 3]], faces: &[[u32; 3]], corners: &[[[f32; 2]; 3]]) -> Self {
        if corners.len() != faces.len() || corners.is_empty() {
            let vertices = vertices.iter().map(|&[x, y, z]| [x, y, z, 0.0, 0.0]).collect();
            return Self { vertices, indices: faces.as_flattened().to_vec(), placed: false };
        }
        let (mut known, mut own) = (HashMap::new(), Vec::new());
        let all = faces.as_flattened().iter().zip(corners.as_flattened());
        let indices = all.map(|(&k, &[u, v])| {
            *known.entry((k, u.to_bits(), v.to_bits())).or_insert_with(|| {
                let [x, y, z] = vertices[k as usize];
                own.push([x, y, z, u, v]);
                own.len() as u32 - 1
            })
        });
        let indices = indices.collect();
        Self { vertices: own, indices, placed: true }
    }

    /// Fewer triangles whose surface is nowhere farther away than this share of the mesh's size, in an order in which
    /// neighbours follow each other; vertices that none of them uses are left out.
    fn simplified(&self, error: f32) -> Self {
        let bytes: Vec<u8> = self.vertices.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        let coordinates = VertexDataAdapter::new(&bytes, size_of::<Vertex>(), 0).expect("five numbers a vertex");
        // Parts smaller than the error go, too.
        let options = SimplifyOptions::Prune;
        let kept = meshopt::simplify(&self.indices, &coordinates, 0, error, options, None);
        let mut indices = meshopt::optimize_vertex_cache(&kept, self.vertices.len());
        let vertices = meshopt::optimize_vertex_fetch(&mut indices, &self.vertices);
        Self { vertices, indices, placed: self.placed }
    }

    fn write(&self, block: &mut Vec<u8>) -> MeshPlace {
        let offset = block.len();
        let count = self.vertices.len();
        let side = |axis: usize| {
            let along = self.vertices.iter().map(move |p| p[axis]);
            let low = along.clone().fold(f32::INFINITY, f32::min);
            (low, along.fold(f32::NEG_INFINITY, f32::max) - low)
        };
        let sides = if count == 0 { [(0.0, 0.0); 5] } else { [0, 1, 2, 3, 4].map(side) };
        let unit_of = |sides: &[(f32, f32)]| {
            (sides.iter().fold(0.0_f32, |a, (_, length)| a.max(*length)) / STEPS).max(f32::MIN_POSITIVE)
        };
        let mut write = |axes: std::ops::Range<usize>| {
            let unit = unit_of(&sides[axes.clone()]);
            let whole =
                |p: &Vertex| axes.clone().map(|axis| ((p[axis] - sides[axis].0) / unit).round() as u16).collect();
            let rows: Vec<Vec<u16>> = self.vertices.iter().map(whole).collect();
            coding::write_differences(&rows.concat(), axes.len(), block);
            unit
        };
        let unit = write(0..3);
        let places = self.placed.then(|| ([sides[3].0, sides[4].0], write(3..5)));
        coding::write_indices(&self.indices, block);
        MeshPlace {
            offset,
            vertices: count,
            triangles: self.indices.len() / 3,
            low: [sides[0].0, sides[1].0, sides[2].0],
            unit,
            places,
        }
    }
}
