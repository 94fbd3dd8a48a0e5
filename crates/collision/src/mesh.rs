//! Triangle meshes and height fields, made ready.

use std::collections::HashMap;

use glamx::glam::{DMat3, DVec3};
use signorini_multibody::model::{HeightField, Mesh};

use crate::bvh::{Aabb, Bvh};
use crate::convex::{Triangle, bounds_of};

/// Triangles with what their neighbours allow.
#[derive(Clone, Debug)]
pub(crate) struct TriangleSet {
    pub vertices: Vec<DVec3>,
    faces: Vec<Face>,
    pub bvh: Bvh,
    /// Whether the side behind the triangles is solid (height fields); otherwise both sides are outside.
    pub solid_below: bool,
    /// Whether the surface encloses a solid, whose outside the normals look to.
    pub closed: bool,
}

/// A mesh at a pose in the common frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlacedSet<'a> {
    pub set: &'a TriangleSet,
    pub rotation: DMat3,
    pub position: DVec3,
}

#[derive(Clone, Copy, Debug)]
struct Face {
    ids: [u32; 3],
    normal: DVec3,
    /// The edges from vertex k to vertex k + 1.
    edges: [Edge; 3],
}

/// An edge of a face.
#[derive(Clone, Copy, Debug)]
struct Edge {
    /// Unit vector in the face's plane, out of the face across the edge.
    out: DVec3,
    /// How far normals of the front, and of the back, may lean over the edge: cosine and sine.
    lean: [[f64; 2]; 2],
}

impl Edge {
    /// - `fold`: the angle from the face's normal to the neighbour's, positive across a ridge, negative across a valley, rad; none where
    ///   there is no neighbour
    fn new(out: DVec3, fold: Option<f64>) -> Self {
        let bound = |fold: f64| fold.max(0.0) + LEAN;
        // Whatever leans has a sine that is not negative: this bound no angle exceeds.
        let free = [-1.0, 0.0];
        let of = |side: f64| match fold.map(|fold| bound(side * fold)) {
            Some(bound) if bound < std::f64::consts::PI => [bound.cos(), bound.sin()],
            _ => free,
        };
        Self { out, lean: [of(1.0), of(-1.0)] }
    }
}

/// A normal that looks into a closed surface by less than this sine lies in it.
const LEVEL: f64 = 1e-9;

/// Leaning over an edge by less than this angle (rad) beyond what it allows is rounding.
const LEAN: f64 = 1e-6;

impl TriangleSet {
    pub fn from_mesh(mesh: &Mesh) -> Self {
        let (vertices, same) = weld(&mesh.vertices);
        let triangles: Vec<[u32; 3]> = mesh.triangles.iter().map(|t| t.map(|i| same[i as usize])).collect();
        let inside_out = signed_volume(&vertices, &triangles) < 0.0;
        let turned = triangles.into_iter().map(|[a, b, c]| if inside_out { [a, c, b] } else { [a, b, c] });
        Self::new(vertices, turned, false)
    }

    pub fn from_height_field(field: &HeightField) -> Self {
        let [nx, ny] = field.size;
        let place = |i: usize, n: usize, half: f64| half * (2.0 * i as f64 / (n - 1) as f64 - 1.0);
        let vertices = (0..nx * ny).map(|k| {
            let (ix, iy) = (k % nx, k / nx);
            DVec3::new(place(ix, nx, field.half_extents[0]), place(iy, ny, field.half_extents[1]), field.heights[k])
        });
        let cells = (0..ny - 1).flat_map(|iy| (0..nx - 1).map(move |ix| iy * nx + ix));
        let triangles = cells.flat_map(|k| {
            let [a, b, c, d] = [k, k + 1, k + nx + 1, k + nx].map(|i| i as u32);
            [[a, b, c], [a, c, d]]
        });
        Self::new(vertices.collect(), triangles, true)
    }

    fn new(vertices: Vec<DVec3>, triangles: impl Iterator<Item = [u32; 3]>, solid_below: bool) -> Self {
        let mut faces: Vec<Face> = triangles
            .filter_map(|ids| {
                let [a, b, c] = ids.map(|i| vertices[i as usize]);
                let area = (b - a).cross(c - a);
                let longest = (b - a).length_squared().max((c - a).length_squared()).max((c - b).length_squared());
                let thin = area.length() <= 1e-12 * longest;
                let normal = area.try_normalize().filter(|_| !thin)?;
                let out = |p: DVec3, q: DVec3| (q - p).cross(normal).normalize_or_zero();
                let edges = [out(a, b), out(b, c), out(c, a)].map(|out| Edge::new(out, None));
                Some(Face { ids, normal, edges })
            })
            .collect();
        let closed = find_folds(&mut faces);
        let boxes: Vec<Aabb> = faces
            .iter()
            .map(|f| {
                let (low, high) = bounds_of(&f.ids.map(|i| vertices[i as usize]));
                Aabb { low, high }
            })
            .collect();
        let mut bvh = Bvh::default();
        bvh.build(&boxes, 0..boxes.len() as u32);
        Self { vertices, faces, bvh, solid_below, closed: closed && !solid_below }
    }

    pub fn bounds(&self) -> (DVec3, DVec3) {
        self.bvh.bounds()
    }

    /// Number of triangles.
    pub fn len(&self) -> u32 {
        self.faces.len() as u32
    }

    pub fn triangle(&self, index: u32) -> Triangle {
        let face = &self.faces[index as usize];
        Triangle { vertices: face.ids.map(|i| self.vertices[i as usize]), ids: face.ids, normal: face.normal }
    }

    /// The normal (in the mesh's frame) at which a contact of a triangle with normal `n` is made: `n` itself where the
    /// triangle's edges let it lean so far, else the face normal; and whether it is `n`. An edge inside a flat or hollow
    /// part of the surface lets nothing lean over it, so that bodies slide over it unhindered.
    ///
    /// - `from_front`: whether the triangle's front alone can be touched, as that of a solid from its outside
    pub fn allowed_normal(&self, index: u32, n: DVec3, from_front: bool) -> (DVec3, bool) {
        let face = &self.faces[index as usize];
        let front = self.solid_below || from_front || self.is_front(index, n);
        let side = if front { face.normal } else { -face.normal };
        let is_behind = from_front && n.dot(face.normal) < -LEVEL;
        if is_behind || (self.solid_below && n.dot(face.normal) <= 0.0) {
            return (side, false);
        }
        let upright = n.dot(side);
        for (k, edge) in face.edges.iter().enumerate() {
            let [cosine, sine] = edge.lean[usize::from(!front)];
            // The sine of the angle by which it leans farther than it may.
            let too_far = |across: f64| across >= 0.0 && across * cosine > upright * sine;
            if too_far(n.dot(edge.out)) && too_far(face.leaning_over(k, n)) {
                return (side, false);
            }
        }
        (n, true)
    }
}

/// The two sides of triangles and of closed surfaces.
impl TriangleSet {
    /// Whether a contact on this triangle whose normal, in the mesh's frame, points along `n` is on its front.
    pub fn is_front(&self, index: u32, n: DVec3) -> bool {
        n.dot(self.faces[index as usize].normal) >= 0.0
    }

    /// Whether a closed surface goes around a point, in the mesh's frame: more triangles above it look up than down, or fewer.
    pub fn encloses(&self, point: DVec3) -> bool {
        let above = Aabb { low: point, high: point.with_z(f64::INFINITY) };
        let mut turns = 0;
        self.bvh.overlapping(&above, |i| {
            let face = &self.faces[i as usize];
            if face.is_above(point, &self.vertices) {
                turns += if face.normal.z > 0.0 { 1 } else { -1 };
            }
        });
        turns != 0
    }
}

impl Face {
    /// Whether a ray upwards from `point` goes through: it crosses one of the sides in the plan to the right of it. Neighbours compute their common side with the same
    /// numbers, so that no ray slips between them or meets both.
    fn is_above(&self, point: DVec3, vertices: &[DVec3]) -> bool {
        let crossed = |k: usize| {
            let (i, j) = (self.ids[k], self.ids[(k + 1) % 3]);
            let [p, q] = [i.min(j), i.max(j)].map(|i| vertices[i as usize]);
            let share = (point.y - p.y) / (q.y - p.y);
            (p.y > point.y) != (q.y > point.y) && point.x < p.x + share * (q.x - p.x)
        };
        let is_beneath = || self.normal.dot(vertices[self.ids[0] as usize] - point) * self.normal.z > 0.0;
        (0..3).filter(|k| crossed(*k)).count() == 1 && is_beneath()
    }

    /// How much of the part of `n` in the face's plane points over edge `k`: what points out of a triangle is made up of two of its outward directions, one where
    /// it is at an edge. Next to an obtuse corner the other edge's outward direction has a part along it as well, over which it does not lean.
    fn leaning_over(&self, k: usize, n: DVec3) -> f64 {
        let out = self.edges[k].out;
        let along = n.dot(out);
        let beside = [1, 2].map(|step| {
            let other = self.edges[(k + step) % 3].out;
            let (cosine, across) = (out.dot(other), n.dot(other));
            let square = 1.0 - cosine * cosine;
            ((across - cosine * along) / square, (along - cosine * across) / square)
        });
        let [(b, a), (c, d)] = beside;
        along.min(if b >= c { a } else { d })
    }
}

/// Vertices at the same place become one.
fn weld(points: &[DVec3]) -> (Vec<DVec3>, Vec<u32>) {
    let mut first: HashMap<[u64; 3], u32> = HashMap::new();
    let mut vertices = Vec::new();
    let same = points
        .iter()
        .map(|p| {
            *first.entry(p.to_array().map(|x| (x + 0.0).to_bits())).or_insert_with(|| {
                vertices.push(*p);
                vertices.len() as u32 - 1
            })
        })
        .collect();
    (vertices, same)
}

/// Six times the volume that triangles enclose; negative where their normals look inside.
fn signed_volume(vertices: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
    let corner = |i: u32| vertices[i as usize];
    triangles.iter().map(|&[a, b, c]| corner(a).dot(corner(b).cross(corner(c)))).sum()
}

/// Fills in how far edges let lean that two triangles share; edges of more than two stay free. Whether every edge is shared by two triangles that
/// run along it in opposite directions: the surface of a solid.
fn find_folds(faces: &mut [Face]) -> bool {
    let mut closed = true;
    let mut edges: Vec<(u32, u32, u32, u32)> = Vec::with_capacity(3 * faces.len());
    for (i, face) in faces.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (face.ids[k], face.ids[(k + 1) % 3]);
            edges.push((a.min(b), a.max(b), i as u32, k as u32));
        }
    }
    edges.sort_unstable();
    for group in edges.chunk_by(|e, f| (e.0, e.1) == (f.0, f.1)) {
        let [first, second] = group else {
            closed = false;
            continue;
        };
        for (own, other) in [(first, second), (second, first)] {
            let (face, k) = (faces[own.2 as usize], own.3 as usize);
            let neighbour = faces[other.2 as usize];
            let [a, b] = [face.ids[k], face.ids[(k + 1) % 3]];
            let l = other.3 as usize;
            let aligned = neighbour.ids[l] == b && neighbour.ids[(l + 1) % 3] == a;
            closed &= aligned;
            let normal = if aligned { neighbour.normal } else { -neighbour.normal };
            let out = face.edges[k].out;
            let fold = normal.dot(out).atan2(normal.dot(face.normal));
            faces[own.2 as usize].edges[k] = Edge::new(out, Some(fold));
        }
    }
    closed
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sum of the solid angles of all triangles seen from a point, over 4π (van Oosterom & Strackee 1983).
    fn winding(set: &TriangleSet, point: DVec3) -> f64 {
        let angles = (0..set.len()).map(|i| {
            let [a, b, c] = set.triangle(i).vertices.map(|p| p - point);
            let (x, y, z) = (a.length(), b.length(), c.length());
            let across = x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y;
            2.0 * a.dot(b.cross(c)).atan2(across)
        });
        angles.sum::<f64>() / (4.0 * std::f64::consts::PI)
    }

    /// Boxes as triangles: a large one with a hollow in it, and a small one in the hollow.
    fn boxes() -> Mesh {
        let mut mesh = Mesh::default();
        for (half, turned) in [(4.0, false), (3.0, true), (1.0, false)] {
            let first = mesh.vertices.len() as u32;
            let sign = |k: u32, bit: u32| if k & bit > 0 { half } else { -half };
            mesh.vertices.extend((0..8).map(|k| DVec3::new(sign(k, 1), sign(k, 2), sign(k, 4))));
            let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
            let triangles = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
            let order = |[a, b, c]: [u32; 3]| if turned { [a, c, b] } else { [a, b, c] };
            mesh.triangles.extend(triangles.map(|t| order(t).map(|i| i + first)));
        }
        mesh
    }

    /// On a grid, where rays go through corners and along edges, as in between.
    #[test]
    fn a_closed_surface_encloses_what_it_winds_around() {
        let set = TriangleSet::from_mesh(&boxes());
        assert!(set.closed);
        let (mut inside, steps) = (0, -10..=10);
        for (x, y, z) in steps.clone().flat_map(|x| steps.clone().flat_map(move |y| (-10..=10).map(move |z| (x, y, z))))
        {
            let point = 0.5 * DVec3::new(f64::from(x), f64::from(y), f64::from(z));
            if [1.0, 3.0, 4.0].contains(&point.abs().max_element()) {
                continue;
            }
            let expected = winding(&set, point);
            assert!((expected - expected.round()).abs() < 1e-9, "{point} is on no surface: {expected}");
            assert_eq!(set.encloses(point), expected.round() != 0.0, "{point}");
            inside += usize::from(expected.round() != 0.0);
        }
        // Of points within the shell and the small box: 15³ − 13³ and 3³.
        assert_eq!(inside, 15 * 15 * 15 - 13 * 13 * 13 + 27);
    }
}
