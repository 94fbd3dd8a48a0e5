//! Closest points of two convex cores (Gilbert, Johnson, Keerthi 1988; simplex projection after Ericson 2005).

use glamx::glam::DVec3;

use crate::convex::Placed;

/// What the search found.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Outcome {
    /// The cores are farther apart than asked for along this direction.
    Beyond(DVec3),
    /// The cores do not meet.
    Apart(ClosestPair),
    /// The cores overlap or touch; a ball of this radius (m) about the origin lies in their difference, as far as that is known.
    Overlapping(f64),
}

/// Closest points of the cores.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ClosestPair {
    pub distance: f64,
    /// Unit, from A to B.
    pub normal: DVec3,
    pub point_a: DVec3,
    pub point_b: DVec3,
    /// How much larger than the true distance `distance` may be, m.
    pub open: f64,
}

/// A vertex `w = b − a` of the difference of the shapes.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Vertex {
    pub w: DVec3,
    pub a: DVec3,
    pub b: DVec3,
}

const ITERATIONS: usize = 96;
/// The square of the sine of a triangle's angle from which on rounding decides where the origin projects to.
const NEEDLE: f64 = 1e-12;

/// Closest points of the cores of A and B, given up as soon as they are known to be farther apart than `beyond` (m).
pub(crate) fn closest(a: &Placed, b: &Placed, beyond: f64) -> Outcome {
    search(a, b, beyond, difference)
}

/// Closest points of the cores made smaller by the share `shrink` about their centres.
pub(crate) fn closest_of_shrunk(a: &Placed, b: &Placed, shrink: f64) -> Outcome {
    search(a, b, f64::INFINITY, |a, b, d| {
        let Vertex { a: pa, b: pb, .. } = difference(a, b, d);
        let (pa, pb) = (pa.lerp(a.center, shrink), pb.lerp(b.center, shrink));
        Vertex { w: pb - pa, a: pa, b: pb }
    })
}

fn search(a: &Placed, b: &Placed, beyond: f64, difference: impl Fn(&Placed, &Placed, DVec3) -> Vertex) -> Outcome {
    let size = a.size + b.size;
    let mut simplex = Simplex::default();
    let first = difference(a, b, (a.center - b.center).try_normalize().unwrap_or(DVec3::X));
    simplex.vertices[0] = first;
    simplex.weights[0] = 1.0;
    simplex.count = 1;
    let mut v = first.w;
    let mut length2 = v.length_squared();
    let mut open = f64::INFINITY;
    for _ in 0..ITERATIONS {
        if length2 <= (1e-14 * size).powi(2) {
            return Outcome::Overlapping(0.0);
        }
        let vertex = difference(a, b, -v);
        let bound = v.dot(vertex.w);
        if bound > beyond * length2.sqrt() {
            return Outcome::Beyond(v);
        }
        open = (length2 - bound) / length2.sqrt();
        if length2 - bound <= 1e-15 * length2 || simplex.has(vertex.w) {
            break;
        }
        let kept = simplex;
        simplex.vertices[simplex.count] = vertex;
        simplex.count += 1;
        let Some(next) = simplex.project() else {
            // A needle can seem to hold the origin although a plane between the shapes is already known.
            if bound > 1e-12 * size * length2.sqrt() {
                simplex = kept;
                break;
            }
            return Outcome::Overlapping(simplex.inner_radius());
        };
        let next2 = next.length_squared();
        if next2.is_nan() || next2 >= length2 {
            simplex = kept;
            break;
        }
        (v, length2) = (next, next2);
    }
    let distance = length2.sqrt();
    let (point_a, point_b) = simplex.points();
    Outcome::Apart(ClosestPair { distance, normal: v / distance, point_a, point_b, open })
}

/// The vertex of `B − A` (cores) that is farthest along `d`.
fn difference(a: &Placed, b: &Placed, d: DVec3) -> Vertex {
    let (pa, pb) = (a.core_support(-d), b.core_support(d));
    Vertex { w: pb - pa, a: pa, b: pb }
}

#[derive(Clone, Copy, Debug, Default)]
struct Simplex {
    vertices: [Vertex; 4],
    weights: [f64; 4],
    count: usize,
}

impl Simplex {
    fn has(&self, w: DVec3) -> bool {
        self.vertices[..self.count].iter().any(|v| v.w == w)
    }

    /// The radius of the largest ball about the origin in a tetrahedron; 0 of what is none.
    fn inner_radius(&self) -> f64 {
        if self.count < 4 {
            return 0.0;
        }
        let w = self.vertices.map(|v| v.w);
        let faces = [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]].map(|face| face.map(|i: usize| w[i]));
        let distance = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).normalize_or_zero().dot(a).abs();
        faces.map(distance).into_iter().fold(f64::INFINITY, f64::min)
    }

    fn points(&self) -> (DVec3, DVec3) {
        let mut points = (DVec3::ZERO, DVec3::ZERO);
        for (vertex, weight) in self.vertices.iter().zip(self.weights).take(self.count) {
            points = (points.0 + vertex.a * weight, points.1 + vertex.b * weight);
        }
        points
    }

    /// The point nearest to the origin; drops what it does not need. `None` if the origin is inside. The last vertex is new, and lies closer along the
    /// old nearest point, which was that of the others: the new one is on a side with the new vertex.
    fn project(&mut self) -> Option<DVec3> {
        let w = self.vertices.map(|v| v.w);
        let (ids, weights): ([usize; 3], [f64; 3]) = match self.count {
            2 => {
                let (s, t) = segment_weights(w[0], w[1]);
                ([0, 1, 0], [s, t, 0.0])
            }
            3 => ([0, 1, 2], weights_with_last(w[0], w[1], w[2])),
            _ => tetrahedron(&w)?,
        };
        let (mut kept, mut nearest) = (Self::default(), DVec3::ZERO);
        for (i, weight) in ids.into_iter().zip(weights) {
            if weight > 0.0 {
                kept.vertices[kept.count] = self.vertices[i];
                kept.weights[kept.count] = weight;
                kept.count += 1;
                nearest += w[i] * weight;
            }
        }
        *self = kept;
        Some(nearest)
    }
}

fn segment_weights(a: DVec3, b: DVec3) -> (f64, f64) {
    let e = b - a;
    let length2 = e.length_squared();
    let t = if length2 > 0.0 { (-a.dot(e) / length2).clamp(0.0, 1.0) } else { 0.0 };
    (1.0 - t, t)
}

/// Barycentric weights of the point of a triangle nearest to the origin: the best of its three sides and, where the
/// origin projects into it, of its inside. Needles lose nothing this way: the answer is never worse than a side's.
pub(crate) fn triangle_weights(a: DVec3, b: DVec3, c: DVec3) -> [f64; 3] {
    let (ab, bc, ca) = (segment_weights(a, b), segment_weights(b, c), segment_weights(c, a));
    let mut nearest = Nearest::new([a, b, c], [1.0, 0.0, 0.0]);
    for weights in [[ab.0, ab.1, 0.0], [0.0, bc.0, bc.1], [ca.1, 0.0, ca.0]] {
        nearest.try_out(weights);
    }
    Projection::new(a, b, c).inside().into_iter().for_each(|weights| nearest.try_out(weights));
    nearest.weights
}

/// The same where the nearest point is known not to be on the first side alone: the sides that the origin projects beyond are enough, where
/// rounding does not decide which these are.
fn weights_with_last(a: DVec3, b: DVec3, c: DVec3) -> [f64; 3] {
    let projection = Projection::new(a, b, c);
    let inside = projection.inside();
    let is_needle = projection.normal_squared <= NEEDLE * (b - a).length_squared() * (c - a).length_squared();
    if let (Some(weights), false) = (inside, is_needle) {
        return weights;
    }
    let mut nearest = Nearest::new([a, b, c], [0.0, 0.0, 1.0]);
    if is_needle || projection.areas[1] <= 0.0 {
        let (s, t) = segment_weights(a, c);
        nearest.try_out([s, 0.0, t]);
    }
    if is_needle || projection.areas[0] <= 0.0 {
        let (s, t) = segment_weights(b, c);
        nearest.try_out([0.0, s, t]);
    }
    inside.into_iter().for_each(|weights| nearest.try_out(weights));
    nearest.weights
}

/// Where the origin projects to in the plane of a triangle.
struct Projection {
    /// Of the triangles of the projection with each side, opposite to each corner, times the triangle's own area; negative beyond a side.
    areas: [f64; 3],
    /// The square of twice the triangle's area.
    normal_squared: f64,
}

impl Projection {
    fn new(a: DVec3, b: DVec3, c: DVec3) -> Self {
        let normal = (b - a).cross(c - a);
        let areas = [normal.dot(b.cross(c)), normal.dot(c.cross(a)), normal.dot(a.cross(b))];
        Self { areas, normal_squared: normal.length_squared() }
    }

    /// Barycentric weights, if it lies inside.
    fn inside(&self) -> Option<[f64; 3]> {
        let sum = self.areas[0] + self.areas[1] + self.areas[2];
        (self.areas.iter().all(|x| *x > 0.0) && sum > 0.0).then(|| self.areas.map(|x| x / sum))
    }
}

/// The point of a triangle nearest to the origin of those tried out.
struct Nearest {
    corners: [DVec3; 3],
    length2: f64,
    weights: [f64; 3],
}

impl Nearest {
    fn new(corners: [DVec3; 3], weights: [f64; 3]) -> Self {
        Self { corners, length2: f64::INFINITY, weights }
    }

    fn try_out(&mut self, weights: [f64; 3]) {
        let [a, b, c] = self.corners;
        let length2 = (a * weights[0] + b * weights[1] + c * weights[2]).length_squared();
        if length2 < self.length2 {
            (self.length2, self.weights) = (length2, weights);
        }
    }
}

/// The face of a tetrahedron nearest to the origin and the weights there; `None` if the origin is inside. It is one with the last vertex.
fn tetrahedron(w: &[DVec3; 4]) -> Option<([usize; 3], [f64; 3])> {
    let mut inside = true;
    let mut best = (f64::INFINITY, [0, 1, 3], [0.0, 0.0, 1.0]);
    for (face, opposite) in [([0, 1, 3], 2), ([0, 2, 3], 1), ([1, 2, 3], 0)] {
        let [a, b, c] = face.map(|i| w[i]);
        let normal = (b - a).cross(c - a);
        let (origin_side, vertex_side) = (-a.dot(normal), (w[opposite] - a).dot(normal));
        let flat = vertex_side.abs() <= 1e-13 * normal.length() * (w[opposite] - a).length();
        if !flat && origin_side * vertex_side > 0.0 {
            continue;
        }
        inside = false;
        let weights = weights_with_last(a, b, c);
        let length2 = (a * weights[0] + b * weights[1] + c * weights[2]).length_squared();
        if length2 < best.0 {
            best = (length2, face, weights);
        }
    }
    (!inside).then_some((best.1, best.2))
}
