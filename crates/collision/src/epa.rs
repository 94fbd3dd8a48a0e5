//! The least overlap of two convex shapes by an expanding polytope (van den Bergen 2001).
//!
//! The polytope is grown inside the difference `B − A` from the outside in: it starts from supports in fixed directions,
//! whether or not they enclose the origin, and always expands at the face with the smallest signed distance. So it also
//! serves touching and barely separated shapes, and symmetric poses are not special.

use glamx::glam::DVec3;

use crate::convex::{Placed, separation_along};
use crate::gjk::{Vertex, triangle_weights};
use crate::separation::Separation;

#[derive(Clone, Copy, Debug)]
struct Face {
    v: [usize; 3],
    /// Outward unit normal.
    normal: DVec3,
    /// Signed distance of the plane from the origin.
    distance: f64,
}

/// Buffers of the polytope.
#[derive(Clone, Debug, Default)]
pub(crate) struct Epa {
    vertices: Vec<Vertex>,
    faces: Vec<Face>,
    edges: Vec<[usize; 2]>,
}

const ITERATIONS: usize = 160;
/// Relative to the size: when the bounds of the overlap are this close the search ends.
const PRECISION: f64 = 1e-12;

impl Epa {
    /// The direction of least overlap (largest separation), or `None` if the difference of the shapes has no volume.
    /// `axes` are directions worth trying first.
    pub fn search(&mut self, a: &Placed, b: &Placed, axes: &[DVec3]) -> Option<Separation> {
        let size = a.size + b.size;
        self.start(a, b, axes, size)?;
        let mut best: Option<(f64, Face)> = None;
        for _ in 0..ITERATIONS {
            let face = *self.faces.iter().min_by(|f, g| f.distance.total_cmp(&g.distance))?;
            let vertex = difference(a, b, face.normal);
            let reach = face.normal.dot(vertex.w);
            if best.is_none_or(|(r, _)| reach < r) {
                best = Some((reach, face));
            }
            let open = best.map_or(f64::INFINITY, |(r, _)| r) - face.distance;
            if open <= PRECISION * size || !self.insert(vertex, PRECISION * size) {
                break;
            }
        }
        let (_, face) = best?;
        let normal = -face.normal;
        let vertices = face.v.map(|i| self.vertices[i]);
        let weights = triangle_weights(vertices[0].w, vertices[1].w, vertices[2].w);
        let midpoint = vertices.iter().zip(weights).map(|(v, w)| (v.a + v.b) * (0.5 * w)).sum();
        Some(Separation { normal, gap: separation_along(a, b, normal), midpoint: Some(midpoint) })
    }

    /// A tetrahedron from the supports that span most, then the other supports.
    fn start(&mut self, a: &Placed, b: &Placed, axes: &[DVec3], size: f64) -> Option<()> {
        self.vertices.clear();
        self.faces.clear();
        let own = [a.rotation.x_axis, a.rotation.y_axis, a.rotation.z_axis];
        for d in own.iter().chain(axes) {
            self.vertices.push(difference(a, b, *d));
            self.vertices.push(difference(a, b, -*d));
        }
        let first = self.vertices[0].w;
        let second = self.farthest(|w| (w - first).length_squared());
        let line = (self.vertices[second].w - first).try_normalize()?;
        let third = self.farthest(|w| line.cross(w - first).length_squared());
        let normal = line.cross(self.vertices[third].w - first).try_normalize()?;
        let fourth = self.farthest(|w| normal.dot(w - first).abs());
        let side = normal.dot(self.vertices[fourth].w - first);
        if side.is_nan() || side.abs() <= 1e-9 * size {
            return None;
        }
        let [p, q, r, s] = if side < 0.0 { [0, second, third, fourth] } else { [0, third, second, fourth] };
        for v in [[p, q, r], [p, s, q], [q, s, r], [r, s, p]] {
            self.add_face(v);
        }
        for i in 0..self.vertices.len() {
            if ![p, q, r, s].contains(&i) {
                let vertex = self.vertices[i];
                self.insert(vertex, 1e-9 * size);
            }
        }
        Some(())
    }

    fn farthest(&self, measure: impl Fn(DVec3) -> f64) -> usize {
        let mut best = (0, -1.0);
        for (i, v) in self.vertices.iter().enumerate() {
            let m = measure(v.w);
            if m > best.1 {
                best = (i, m);
            }
        }
        best.0
    }

    fn add_face(&mut self, v: [usize; 3]) -> bool {
        let [a, b, c] = v.map(|i| self.vertices[i].w);
        let Some(normal) = (b - a).cross(c - a).try_normalize() else { return false };
        self.faces.push(Face { v, normal, distance: normal.dot(a) });
        true
    }

    /// Adds a vertex that lies beyond some face by more than `tolerance`; `false` if it lies beyond none or if rounding
    /// spoils the polytope.
    fn insert(&mut self, vertex: Vertex, tolerance: f64) -> bool {
        self.edges.clear();
        let beyond = |f: &Face| f.normal.dot(vertex.w) - f.distance > tolerance;
        for face in self.faces.iter().filter(|f| beyond(f)) {
            for k in 0..3 {
                let edge = [face.v[k], face.v[(k + 1) % 3]];
                match self.edges.iter().position(|e| *e == [edge[1], edge[0]]) {
                    Some(i) => {
                        self.edges.swap_remove(i);
                    }
                    None => self.edges.push(edge),
                }
            }
        }
        if self.edges.is_empty() || !is_one_loop(&self.edges) {
            return false;
        }
        self.faces.retain(|f| !beyond(f));
        let new = self.vertices.len();
        self.vertices.push(vertex);
        let edges = std::mem::take(&mut self.edges);
        let whole = edges.iter().all(|e| self.add_face([e[0], e[1], new]));
        self.edges = edges;
        whole
    }
}

/// Whether directed edges form a single closed loop.
fn is_one_loop(edges: &[[usize; 2]]) -> bool {
    let start = edges[0][0];
    let mut at = edges[0][1];
    for _ in 1..edges.len() {
        if at == start {
            return false;
        }
        match edges.iter().find(|e| e[0] == at) {
            Some(e) => at = e[1],
            None => return false,
        }
    }
    at == start
}

/// The vertex of `B − A` farthest along `d`.
fn difference(a: &Placed, b: &Placed, d: DVec3) -> Vertex {
    let (pa, pb) = (a.support(-d), b.support(d));
    Vertex { w: pb - pa, a: pa, b: pb }
}
