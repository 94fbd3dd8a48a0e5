//! Triangle meshes for the page: each once, simplified as far as the eye forgives and the page needs, in 16 bits.

use std::collections::HashMap;
use std::mem::take;

use meshopt::{SimplifyOptions, VertexDataAdapter};
use serde::Serialize;

use super::coding;
use crate::header::{Header, ShapeVisual};

/// How far a simplified surface may lie from the mesh, as a share of the mesh's size. The first is less than a pixel of a part
/// that fills a tenth of the picture; the others follow while the meshes take more than their room.
const ERRORS: [f32; 6] = [0.001, 0.003, 0.01, 0.03, 0.1, 0.3];
/// Coordinates are whole numbers from 0 to this along the longest side.
const STEPS: f32 = 65535.0;

/// A mesh in the block: where its numbers are, and what they mean.
#[derive(Debug, Serialize)]
pub(super) struct MeshPlace {
    /// Where it starts in the block: vertices' coordinates as u16, then the indices of its triangles.
    offset: usize,
    vertices: usize,
    triangles: usize,
    /// The place of the numbers 0, 0, 0, and the length of one unit, m.
    low: [f32; 3],
    unit: f32,
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
    vertices: Vec<[f32; 3]>,
    indices: Vec<u32>,
}

impl PageMeshes {
    /// Takes the triangles out of the header's shapes. As long as their text is longer than `room` they become coarser.
    pub fn take_from(header: &mut Header, room: usize) -> Self {
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

/// The meshes of a header, equal ones once, and which of them each geom has.
fn distinct_meshes(header: &mut Header) -> (Vec<Triangles>, Vec<Option<usize>>) {
    let mut known = HashMap::new();
    let mut meshes = Vec::new();
    let mut number_of = |shape: &mut ShapeVisual| {
        let ShapeVisual::Mesh { vertices, faces } = shape else { return None };
        let (vertices, faces) = (take(vertices), take(faces));
        let bits: Vec<[u32; 3]> = vertices.iter().map(|p| p.map(f32::to_bits)).collect();
        let number = *known.entry((bits, faces)).or_insert_with_key(|(_, faces)| {
            meshes.push(Triangles { vertices, indices: faces.as_flattened().to_vec() });
            meshes.len() - 1
        });
        Some(number)
    };
    let of_geom = header.geoms.iter_mut().map(|geom| number_of(&mut geom.shape)).collect();
    (meshes, of_geom)
}

impl Triangles {
    /// Fewer triangles whose surface is nowhere farther away than this share of the mesh's size, in an order in which
    /// neighbours follow each other; vertices that none of them uses are left out.
    fn simplified(&self, error: f32) -> Self {
        let bytes: Vec<u8> = self.vertices.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        let coordinates = VertexDataAdapter::new(&bytes, size_of::<[f32; 3]>(), 0).expect("three numbers a vertex");
        // Parts smaller than the error go, too.
        let options = SimplifyOptions::Prune;
        let kept = meshopt::simplify(&self.indices, &coordinates, 0, error, options, None);
        let mut indices = meshopt::optimize_vertex_cache(&kept, self.vertices.len());
        let vertices = meshopt::optimize_vertex_fetch(&mut indices, &self.vertices);
        Self { vertices, indices }
    }

    fn write(&self, block: &mut Vec<u8>) -> MeshPlace {
        let offset = block.len();
        let side = |axis: usize| {
            let along = self.vertices.iter().map(move |p| p[axis]);
            let low = along.clone().fold(f32::INFINITY, f32::min);
            (low, along.fold(f32::NEG_INFINITY, f32::max) - low)
        };
        let sides = if self.vertices.is_empty() { [(0.0, 0.0); 3] } else { [0, 1, 2].map(side) };
        let unit = (sides.iter().fold(0.0_f32, |a, (_, length)| a.max(*length)) / STEPS).max(f32::MIN_POSITIVE);
        let whole = |p: &[f32; 3]| [0, 1, 2].map(|axis| ((p[axis] - sides[axis].0) / unit).round() as u16);
        let coordinates: Vec<[u16; 3]> = self.vertices.iter().map(whole).collect();
        coding::write_differences(coordinates.as_flattened(), 3, block);
        coding::write_indices(&self.indices, block);
        MeshPlace {
            offset,
            vertices: self.vertices.len(),
            triangles: self.indices.len() / 3,
            low: sides.map(|(low, _)| low),
            unit,
        }
    }
}
