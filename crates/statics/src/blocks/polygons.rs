//! Faces with any number of corners as triangles.

use signorini_multibody::glam::{DVec2, DVec3};
use signorini_multibody::model::Mesh;

impl super::Block {
    /// A mesh from polygons, convex or not, that are flat or nearly so: ears are cut off (G. Meisters, American Mathematical Monthly 82, 1975).
    ///
    /// - `vertices`: m
    /// - `faces`: indices of the corners of each polygon, round about it
    ///
    /// Nothing where a face names a vertex that is not there.
    pub fn mesh_of(vertices: Vec<DVec3>, faces: &[Vec<u32>]) -> Option<Mesh> {
        let known = |corner: &u32| (*corner as usize) < vertices.len();
        if !faces.iter().flatten().all(known) {
            return None;
        }
        let triangles = faces.iter().flat_map(|face| ears(&vertices, face)).collect();
        Some(Mesh { vertices, triangles })
    }
}

/// Triangles of one polygon.
fn ears(vertices: &[DVec3], face: &[u32]) -> Vec<[u32; 3]> {
    let place = |corner: u32| vertices[corner as usize];
    let sides = (0..face.len()).map(|k| (place(face[k]), place(face[(k + 1) % face.len()])));
    let normal = sides.map(|(p, q)| p.cross(q)).sum::<DVec3>();
    let Some(normal) = normal.try_normalize().filter(|_| face.len() >= 3) else { return Vec::new() };
    let across = normal.any_orthonormal_vector();
    let along = normal.cross(across);
    let flat = |corner: u32| DVec2::new(place(corner).dot(across), place(corner).dot(along));
    let turn = |a: u32, b: u32, c: u32| (flat(b) - flat(a)).perp_dot(flat(c) - flat(a));
    let mut left = face.to_vec();
    let mut triangles = Vec::with_capacity(face.len() - 2);
    while left.len() > 3 {
        let n = left.len();
        let corners = |k: usize| [left[(k + n - 1) % n], left[k], left[(k + 1) % n]];
        let is_ear = |k: usize| {
            let [a, b, c] = corners(k);
            let inside = |p: u32| turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
            turn(a, b, c) > 0.0 && !left.iter().any(|&p| p != a && p != b && p != c && inside(p))
        };
        // A polygon with corners on its own sides may have no ear in this sense; what turns most is cut off then.
        let largest = |&i: &usize, &j: &usize| {
            let [of_i, of_j] = [corners(i), corners(j)].map(|[a, b, c]| turn(a, b, c));
            of_i.total_cmp(&of_j)
        };
        let Some(ear) = (0..n).find(|&k| is_ear(k)).or_else(|| (0..n).max_by(largest)) else { break };
        triangles.push(corners(ear));
        left.remove(ear);
    }
    triangles.push([left[0], left[1], left[2]]);
    triangles
}
