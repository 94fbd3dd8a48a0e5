//! Triangles that rays meet: meshes and height fields.

use std::collections::HashMap;

use signorini_multibody::glam::{DVec3, Vec3};
use signorini_multibody::model::{HeightField, Mesh};

use crate::ray::{Hit, Ray};
use crate::tree::{Bounds, BoxRay, Tree};

/// Faces that meet at an angle below this are parts of something smooth: cosine of 35°, between the 30° of a hexagon's neighbours in round
/// parts of exported meshes and the 45° of their chamfers.
const SMOOTH: f32 = 0.82;

#[derive(Clone, Copy, Debug)]
struct Triangle {
    corner: Vec3,
    edges: [Vec3; 2],
}

/// Triangles in a tree, with normals that are smooth where the surface is.
#[derive(Clone, Debug)]
pub(crate) struct Triangles {
    tree: Tree,
    /// In the order of the tree.
    faces: Vec<Triangle>,
    normals: Vec<[Vec3; 3]>,
    /// Radius about the origin that holds everything.
    radius: f64,
    pub bounds: Bounds,
}

impl Triangles {
    pub fn of_mesh(mesh: &Mesh) -> Self {
        let vertices: Vec<Vec3> = mesh.vertices.iter().map(|p| p.as_vec3()).collect();
        Self::new(&vertices, &mesh.triangles)
    }

    /// Every cell as two triangles, split as the collision shapes split it: along the diagonal from its lowest corner in x and y.
    pub fn of_height_field(field: &HeightField) -> Self {
        let [nx, ny] = field.size;
        let place = |k: usize, n: usize, half: f64| half * (2.0 * k as f64 / (n - 1) as f64 - 1.0);
        let vertices: Vec<Vec3> = (0..nx * ny)
            .map(|i| {
                let [hx, hy] = field.half_extents;
                DVec3::new(place(i % nx, nx, hx), place(i / nx, ny, hy), field.heights[i]).as_vec3()
            })
            .collect();
        let cells = (0..ny - 1).flat_map(|y| (0..nx - 1).map(move |x| (y * nx + x) as u32));
        let n = nx as u32;
        let faces: Vec<[u32; 3]> = cells.flat_map(|a| [[a, a + 1, a + n + 1], [a, a + n + 1, a + n]]).collect();
        Self::new(&vertices, &faces)
    }

    fn new(vertices: &[Vec3], faces: &[[u32; 3]]) -> Self {
        let corners = |face: &[u32; 3]| face.map(|k| vertices[k as usize]);
        let boxes: Vec<Bounds> = faces.iter().map(|face| Bounds::around(corners(face))).collect();
        let tree = Tree::new(&boxes);
        let smooth = smooth_normals(vertices, faces);
        let triangle = |&i: &u32| {
            let [a, b, c] = corners(&faces[i as usize]);
            Triangle { corner: a, edges: [b - a, c - a] }
        };
        Self {
            faces: tree.order.iter().map(triangle).collect(),
            normals: tree.order.iter().map(|&i| smooth[i as usize]).collect(),
            radius: vertices.iter().map(|p| f64::from(p.length_squared())).fold(0.0, f64::max).sqrt(),
            bounds: boxes.iter().copied().fold(Bounds::EMPTY, Bounds::union),
            tree,
        }
    }

    /// The first triangle before `limit`, from either side.
    pub fn hit(&self, ray: &Ray, limit: f64) -> Option<Hit> {
        let mut best: Option<(usize, [f32; 2])> = None;
        let (start, distance) = self.walk(ray, limit, |place, weights| {
            best = Some((place, weights));
            false
        })?;
        let (place, [u, v]) = best?;
        let Triangle { edges: [e1, e2], .. } = self.faces[place];
        let [a, b, c] = self.normals[place];
        let face = e1.as_dvec3().cross(e2.as_dvec3()).normalize_or(-ray.direction);
        let normal = (a + u * (b - a) + v * (c - a)).as_dvec3().normalize_or(face);
        Some(Hit { distance: start + distance, face, normal, on_triangle: Some((self.tree.order[place], [u, v])) })
    }

    /// Whether anything is in the ray's way before `limit`.
    pub fn blocks(&self, ray: &Ray, limit: f64) -> bool {
        let mut found = false;
        self.walk(ray, limit, |_, _| {
            found = true;
            true
        });
        found
    }

    /// Walks along a ray from where it comes near; gives that distance and how far from there the nearest triangle is.
    fn walk(&self, ray: &Ray, limit: f64, mut found: impl FnMut(usize, [f32; 2]) -> bool) -> Option<(f64, f64)> {
        // Single precision has its digits for the mesh, not for the way to it.
        let start = (-ray.origin.dot(ray.direction) - 1.01 * self.radius).max(0.0);
        if start > limit {
            return None;
        }
        let (o, d) = (ray.at(start).as_vec3(), ray.direction.as_vec3());
        let mut nearest = (limit - start).min(f64::from(f32::MAX)) as f32;
        self.tree.along(&BoxRay::new(o, d), &mut nearest, |place, nearest| {
            let Some((distance, weights)) = cross(&self.faces[place], o, d, *nearest) else { return false };
            *nearest = distance;
            found(place, weights)
        });
        Some((start, f64::from(nearest)))
    }
}

/// Möller and Trumbore 1997: distance and the weights of the second and third corner. A hair of tolerance closes the seams.
fn cross(triangle: &Triangle, o: Vec3, d: Vec3, limit: f32) -> Option<(f32, [f32; 2])> {
    const SEAM: f32 = 1e-6;
    let Triangle { corner, edges: [e1, e2] } = *triangle;
    let p = d.cross(e2);
    let determinant = e1.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let inverse = 1.0 / determinant;
    let s = o - corner;
    let u = s.dot(p) * inverse;
    let q = s.cross(e1);
    let v = d.dot(q) * inverse;
    let t = e2.dot(q) * inverse;
    (u >= -SEAM && v >= -SEAM && u + v <= 1.0 + SEAM && t >= 0.0 && t < limit).then_some((t, [u, v]))
}

/// The normal of every corner of every face: the mean over the faces at that point that continue this one, weighted by their area.
fn smooth_normals(vertices: &[Vec3], faces: &[[u32; 3]]) -> Vec<[Vec3; 3]> {
    let areas: Vec<Vec3> = faces
        .iter()
        .map(|&[a, b, c]| {
            let [a, b, c] = [a, b, c].map(|k| vertices[k as usize]);
            (b - a).cross(c - a)
        })
        .collect();
    // Files repeat a vertex for every face: the place counts.
    let mut at: HashMap<[u32; 3], Vec<u32>> = HashMap::new();
    let place = |k: u32| (vertices[k as usize] + Vec3::ZERO).to_array().map(f32::to_bits);
    for (i, face) in faces.iter().enumerate() {
        face.iter().for_each(|&k| at.entry(place(k)).or_default().push(i as u32));
    }
    let normal_at = |i: usize, k: u32| {
        let own = areas[i].normalize_or_zero();
        let around = at.get(&place(k)).into_iter().flatten().map(|&j| areas[j as usize]);
        around.filter(|area| own.dot(*area) >= SMOOTH * area.length()).sum::<Vec3>().normalize_or(own)
    };
    faces.iter().enumerate().map(|(i, face)| face.map(|k| normal_at(i, k))).collect()
}
