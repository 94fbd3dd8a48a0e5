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
    /// The faces beyond the edges from each corner to the next.
    beyond: [usize; 3],
    /// Outward unit normal.
    normal: DVec3,
    /// Signed distance of the plane from the origin; infinite where the face is gone, and its place free.
    distance: f64,
}

/// An edge between what a vertex sees and what it does not, with the face that stays and the place of the edge in it.
#[derive(Clone, Copy, Debug)]
struct Rim {
    from: usize,
    to: usize,
    stays: (usize, usize),
}

/// The face nearest to the origin and how far it may still be from the boundary.
#[derive(Clone, Copy, Debug)]
struct Nearest {
    outward: DVec3,
    corners: [Vertex; 3],
    open: f64,
}

/// A point of the boundary of `B − A` that is farthest along a direction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Farthest {
    /// Unit.
    pub along: DVec3,
    pub vertex: Vertex,
}

/// Buffers of the polytope.
#[derive(Clone, Debug, Default)]
pub(crate) struct Epa {
    vertices: Vec<Vertex>,
    faces: Vec<Face>,
    free: Vec<usize>,
    rim: Vec<Rim>,
    seen: Vec<usize>,
    inflation: f64,
}

const ITERATIONS: usize = 160;
/// Relative to the size: when the bounds of the overlap are this close the search ends.
const PRECISION: f64 = 1e-12;
/// Relative to the size: faces whose distances from the origin differ by less may be parts of one.
const COPLANAR: f64 = 1e-8;
/// A direction that no two faces of a box share.
const ASLANT: DVec3 = DVec3::new(0.55, 0.62, 0.56);
/// Relative to the size: bounds farther apart than this ask for another start.
const POOR: f64 = 1e-9;
/// Directions whose cosine is this near to 1 are taken for one: the axes of a box come as axes worth trying and as its own, to rounding. A support more or less is what
/// it decides.
const SAME: f64 = 1e-9;

impl Epa {
    /// The direction of least overlap (largest separation), or `None` if the difference of the shapes has no volume.
    /// `known` are supports in directions worth trying first. Shapes that are apart by less than `inflation` (m) are looked at as if
    /// B were thicker by it, which makes the direction of their distance that of least overlap.
    pub fn search(&mut self, a: &Placed, b: &Placed, known: &[Farthest], inflation: f64) -> Option<Separation> {
        self.inflation = inflation;
        let size = a.size + b.size;
        // Supports that nearly share a plane can spoil a start, or leave no face of it; a bare tetrahedron has none of those.
        let full = self.grow(a, b, known, true);
        let found = match full {
            Some(full) if full.open <= POOR * size => full,
            _ => {
                let bare = self.grow(a, b, known, false);
                [full, bare].into_iter().flatten().min_by(|f, g| f.open.total_cmp(&g.open))?
            }
        };
        let normal = -found.outward;
        let weights = triangle_weights(found.corners[0].w, found.corners[1].w, found.corners[2].w);
        let midpoint = found.corners.iter().zip(weights).map(|(v, w)| (v.a + v.b) * (0.5 * w)).sum();
        Some(Separation { normal, gap: separation_along(a, b, normal), midpoint: Some(midpoint) })
    }

    /// Grows the polytope until the face nearest to the origin is on the boundary.
    fn grow(&mut self, a: &Placed, b: &Placed, known: &[Farthest], full: bool) -> Option<Nearest> {
        let size = a.size + b.size;
        self.start(a, b, known, size, full)?;
        let mut best: Option<(f64, Nearest)> = None;
        for _ in 0..ITERATIONS {
            let place = self.nearest()?;
            let face = self.faces[place];
            let vertex = self.difference(a, b, face.normal);
            let reach = face.normal.dot(vertex.w);
            if best.is_none_or(|(r, _)| reach < r) {
                let corners = face.v.map(|i| self.vertices[i]);
                best = Some((reach, Nearest { outward: face.normal, corners, open: 0.0 }));
            }
            if let Some((reach, nearest)) = &mut best {
                nearest.open = *reach - face.distance;
                // What is farther than the nearest boundary known lies beyond this face.
                if nearest.open <= PRECISION * size || !self.insert(vertex, place, PRECISION * size) {
                    break;
                }
            }
        }
        let (_, mut nearest) = best?;
        self.move_to_projection(&mut nearest, size);
        Some(nearest)
    }

    /// Flat parts of the boundary are made of several faces: takes the corners of the one that holds the projection of
    /// the origin.
    fn move_to_projection(&self, nearest: &mut Nearest, size: f64) {
        let off = |corners: &[Vertex; 3]| {
            let weights = triangle_weights(corners[0].w, corners[1].w, corners[2].w);
            let point: DVec3 = corners.iter().zip(weights).map(|(v, w)| v.w * w).sum();
            (point - nearest.outward * nearest.outward.dot(point)).length()
        };
        let level = nearest.outward.dot(nearest.corners[0].w);
        let mut best = off(&nearest.corners);
        let mut corners = nearest.corners;
        for face in self.faces.iter().filter(|f| (f.distance - level).abs() <= COPLANAR * size) {
            let others = face.v.map(|i| self.vertices[i]);
            let distance = off(&others);
            if distance < best {
                (best, corners) = (distance, others);
            }
        }
        nearest.corners = corners;
    }

    /// A tetrahedron from the supports that span most, then (if `full`) the other supports.
    fn start(&mut self, a: &Placed, b: &Placed, known: &[Farthest], size: f64, full: bool) -> Option<()> {
        self.vertices.clear();
        self.faces.clear();
        self.free.clear();
        let inflation = self.inflation;
        let inflated = |f: &Farthest| Vertex { w: f.vertex.w + f.along * inflation, ..f.vertex };
        self.vertices.extend(known.iter().map(inflated));
        for d in [a.rotation.x_axis, a.rotation.y_axis, a.rotation.z_axis] {
            if known.iter().all(|f| f.along.dot(d).abs() < 1.0 - SAME) {
                for d in [d, -d] {
                    let vertex = self.difference(a, b, d);
                    self.vertices.push(vertex);
                }
            }
        }
        let (mut corners, mut side) = self.tetrahedron(size);
        if side == 0.0 {
            // Of parallel faces any corner is a support, and all of them may lie in one plane. Aslant there is one for each direction.
            for signs in
                [DVec3::ONE, DVec3::new(1.0, -1.0, -1.0), DVec3::new(-1.0, 1.0, -1.0), DVec3::new(-1.0, -1.0, 1.0)]
            {
                let d = a.rotation * (signs * ASLANT);
                let vertex = self.difference(a, b, d.normalize());
                self.vertices.push(vertex);
            }
            (corners, side) = self.tetrahedron(size);
        }
        if side == 0.0 {
            return None;
        }
        let [first, second, third, fourth] = corners;
        let [p, q, r, s] = if side < 0.0 { [first, second, third, fourth] } else { [first, third, second, fourth] };
        for (v, beyond) in
            [([p, q, r], [1, 2, 3]), ([p, s, q], [3, 2, 0]), ([q, s, r], [1, 3, 0]), ([r, s, p], [2, 1, 0])]
        {
            self.add_face(v, beyond)?;
        }
        for i in 0..if full { self.vertices.len() } else { 0 } {
            if ![p, q, r, s].contains(&i) {
                let vertex = self.vertices[i];
                self.insert_beyond(vertex, 1e-9 * size);
            }
        }
        Some(())
    }

    /// Of the vertices four that span much, and the height of the fourth over the first three, with its sign; 0 where all lie in
    /// a plane or are not numbers.
    fn tetrahedron(&self, size: f64) -> ([usize; 4], f64) {
        let first = self.vertices[0].w;
        let second = self.spanning(|w| (w - first).length_squared());
        let line = (self.vertices[second].w - first).normalize_or_zero();
        let third = self.spanning(|w| line.cross(w - first).length_squared());
        let across = line.cross(self.vertices[third].w - first);
        let normal = across.normalize_or_zero();
        let fourth = self.spanning(|w| normal.dot(w - first).abs());
        let side = normal.dot(self.vertices[fourth].w - first);
        let spans = across.length() > 1e-9 * size && side.abs() > 1e-9 * size;
        ([0, second, third, fourth], if spans { side } else { 0.0 })
    }

    /// The vertex of `B − A`, B as thick as it is taken, farthest along the unit vector `d`.
    fn difference(&self, a: &Placed, b: &Placed, d: DVec3) -> Vertex {
        let vertex = farthest(a, b, d);
        Vertex { w: vertex.w + d * self.inflation, ..vertex }
    }

    fn spanning(&self, measure: impl Fn(DVec3) -> f64) -> usize {
        let mut best = (0, -1.0);
        for (i, v) in self.vertices.iter().enumerate() {
            let m = measure(v.w);
            if m > best.1 {
                best = (i, m);
            }
        }
        best.0
    }

    /// Adds a face, at a place that is free; `None` if it has no area.
    fn add_face(&mut self, v: [usize; 3], beyond: [usize; 3]) -> Option<usize> {
        let [a, b, c] = v.map(|i| self.vertices[i].w);
        let normal = (b - a).cross(c - a).try_normalize()?;
        let face = Face { v, beyond, normal, distance: normal.dot(a) };
        let place = self.free.pop().unwrap_or(self.faces.len());
        if place == self.faces.len() {
            self.faces.push(face);
        } else {
            self.faces[place] = face;
        }
        Some(place)
    }

    /// The place of the face nearest to the origin.
    fn nearest(&self) -> Option<usize> {
        let mut best = (f64::INFINITY, None);
        for (place, face) in self.faces.iter().enumerate() {
            if face.distance < best.0 {
                best = (face.distance, Some(place));
            }
        }
        best.1
    }

    /// Adds a vertex if it lies beyond some face by more than `tolerance`.
    fn insert_beyond(&mut self, vertex: Vertex, tolerance: f64) {
        let mut highest = (tolerance, None);
        for (place, face) in self.faces.iter().enumerate() {
            let height = face.height(vertex.w);
            if height > highest.0 {
                highest = (height, Some(place));
            }
        }
        if let Some(seed) = highest.1 {
            self.insert(vertex, seed, tolerance);
        }
    }

    /// Adds a vertex that lies beyond the face `seed`; `false` if rounding spoils the polytope.
    fn insert(&mut self, vertex: Vertex, seed: usize, tolerance: f64) -> bool {
        self.see(vertex.w, seed, tolerance);
        let new = self.vertices.len();
        self.vertices.push(vertex);
        // What is seen gives up its places to what takes them.
        self.free.extend_from_slice(&self.seen);
        let rim = std::mem::take(&mut self.rim);
        let whole = self.close(&rim, new);
        self.rim = rim;
        whole
    }

    /// Finds the faces that a point beyond one of them sees, which go, and their rim.
    fn see(&mut self, point: DVec3, seed: usize, tolerance: f64) {
        self.rim.clear();
        self.seen.clear();
        self.seen.push(seed);
        self.faces[seed].distance = f64::INFINITY;
        let mut next = 0;
        while next < self.seen.len() {
            let (place, face) = (self.seen[next], self.faces[self.seen[next]]);
            next += 1;
            for (k, &other) in face.beyond.iter().enumerate() {
                if self.faces[other].height(point) > tolerance {
                    self.faces[other].distance = f64::INFINITY;
                    self.seen.push(other);
                } else if self.faces[other].distance < f64::INFINITY {
                    let edge = self.faces[other].beyond.iter().position(|&f| f == place).unwrap_or(0);
                    self.rim.push(Rim { from: face.v[k], to: face.v[(k + 1) % 3], stays: (other, edge) });
                }
            }
        }
    }

    /// Joins a vertex to all edges of a rim; `false` if that is not one closed line, or a face has no area.
    fn close(&mut self, rim: &[Rim], new: usize) -> bool {
        self.seen.clear();
        for edge in rim {
            let Some(place) = self.add_face([edge.from, edge.to, new], [edge.stays.0, 0, 0]) else { return false };
            self.faces[edge.stays.0].beyond[edge.stays.1] = place;
            self.seen.push(place);
        }
        for (edge, &place) in rim.iter().zip(&self.seen) {
            let Some(next) = rim.iter().position(|other| other.from == edge.to) else { return false };
            let next = self.seen[next];
            self.faces[place].beyond[1] = next;
            self.faces[next].beyond[2] = place;
        }
        true
    }
}

/// The vertex of `B − A` farthest along the unit vector `d`.
pub(crate) fn farthest(a: &Placed, b: &Placed, d: DVec3) -> Vertex {
    let (pa, pb) = (a.support(-d), b.support(d));
    Vertex { w: pb - pa, a: pa, b: pb }
}

impl Face {
    /// How far a point lies beyond its plane; of one that is gone nothing does.
    fn height(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.distance
    }
}
