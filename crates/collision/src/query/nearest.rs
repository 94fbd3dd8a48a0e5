//! The distance of two geoms, with the points at which it is attained.

use glamx::glam::DVec3;
use signorini_multibody::GeomId;

use super::placed::Queries;
use crate::bvh::Aabb;
use crate::convex::{Convex, Placed, bounds_of, scale};
use crate::halfspace::HalfSpace;
use crate::mesh::PlacedSet;
use crate::narrow::{Narrow, REALISED};
use crate::search::TOUCHING;
use crate::separation::{self, Separation};
use crate::shape::Shape;

/// Where two geoms are nearest to each other; where they overlap, how far they have to be moved along the normal to touch.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Nearest {
    /// Signed distance of the surfaces, m; negative where they overlap.
    pub distance: f64,
    /// Unit normal from the first geom to the second, world axes.
    pub normal: DVec3,
    /// The point of the first geom's surface, in world, m.
    pub point_a: DVec3,
    /// The point of the second geom's surface, in world, m.
    pub point_b: DVec3,
}

impl Nearest {
    fn swapped(self) -> Self {
        Self { normal: -self.normal, point_a: self.point_b, point_b: self.point_a, ..self }
    }

    fn moved(self, by: DVec3) -> Self {
        Self { point_a: self.point_a + by, point_b: self.point_b + by, ..self }
    }
}

impl Queries {
    /// The distance of two geoms at the poses of [`place`](Self::place).
    ///
    /// Polyhedra, spheres, capsules and planes: exact to rounding; curved shapes: to 1e-8 of their size (the search is that of the
    /// contacts). A triangle mesh is the set of its triangles, without inside; so is the surface of a height field, from which a shape that
    /// lies wholly below it is as far as from above.
    ///
    /// `None` for two planes, and where the poses are not numbers.
    ///
    /// # Panics
    /// If the model has no such geom.
    pub fn distance(&mut self, a: GeomId, b: GeomId) -> Option<Nearest> {
        let (i, j) = (a.index(), b.index());
        // A common frame near both, so that nothing is lost far from the world's origin.
        let origin = match self.geoms[j].shape {
            Shape::HalfSpace => self.pose[i].position,
            _ => self.pose[j].position,
        };
        if !(self.pose[i].position.is_finite() && self.pose[j].position.is_finite()) {
            return None;
        }
        let mut narrow = std::mem::take(&mut self.narrow);
        let found = match (&self.geoms[i].shape, &self.geoms[j].shape) {
            (Shape::HalfSpace, _) => self.above(&self.half_space(i, origin), j, origin),
            (_, Shape::HalfSpace) => self.above(&self.half_space(j, origin), i, origin).map(Nearest::swapped),
            (Shape::Convex(shape_a), Shape::Convex(shape_b)) => {
                let (placed_a, placed_b) = (self.placed(i, shape_a, origin), self.placed(j, shape_b, origin));
                convex(&mut narrow, &placed_a, &placed_b)
            }
            (Shape::Triangles(set), Shape::Convex(shape)) => {
                let placed = self.placed(j, shape, origin);
                to_set(&mut narrow, &self.placed_set(i, set, origin), &placed, f64::INFINITY)
            }
            (Shape::Convex(shape), Shape::Triangles(set)) => {
                let placed = self.placed(i, shape, origin);
                to_set(&mut narrow, &self.placed_set(j, set, origin), &placed, f64::INFINITY).map(Nearest::swapped)
            }
            (Shape::Triangles(set_a), Shape::Triangles(set_b)) => {
                let (set_a, set_b) = (self.placed_set(i, set_a, origin), self.placed_set(j, set_b, origin));
                between_sets(&mut narrow, &set_a, &set_b)
            }
            _ => None,
        };
        self.narrow = narrow;
        found.map(|nearest| nearest.moved(origin))
    }

    /// The lowest point of a geom above a half-space.
    fn above(&self, half_space: &HalfSpace, geom: usize, origin: DVec3) -> Option<Nearest> {
        let down = -half_space.normal;
        let lowest = match &self.geoms[geom].shape {
            Shape::Convex(shape) => self.placed(geom, shape, origin).support(down),
            Shape::Triangles(set) => {
                let placed = self.placed_set(geom, set, origin);
                let points = placed.set.vertices.iter().map(|p| placed.rotation * *p + placed.position);
                points.max_by(|p, q| down.dot(*p).total_cmp(&down.dot(*q)))?
            }
            Shape::HalfSpace | Shape::Absent => return None,
        };
        let distance = half_space.normal.dot(lowest) - half_space.offset;
        let point_a = lowest - half_space.normal * distance;
        Some(Nearest { distance, normal: half_space.normal, point_a, point_b: lowest })
    }
}

/// Two convex shapes.
fn convex(narrow: &mut Narrow, a: &Placed, b: &Placed) -> Option<Nearest> {
    let any = f64::INFINITY;
    let found = match (a.shape, b.shape) {
        (_, Convex::Sphere { radius }) => separation::sphere(a, b, *radius, any)?,
        (Convex::Sphere { radius }, _) => separation::sphere(b, a, *radius, any)?.swapped(),
        _ => {
            let axis = narrow.search.axis(a, b, any)?;
            let found = narrow.search.general(a, b, axis, any)?;
            // The closest points of shapes that are apart are sure, those where they touch or overlap less so.
            let is_sure = found.gap > TOUCHING * scale(a, b) && found.midpoint.is_some();
            if is_sure { found } else { with_facing_point(narrow, a, b, found) }
        }
    };
    let Separation { normal, gap, midpoint } = found;
    let (midpoint, half) = (midpoint?, normal * (0.5 * gap));
    Some(Nearest { distance: gap, normal, point_a: midpoint - half, point_b: midpoint + half })
}

/// A separation with a point midway between the parts of two shapes that face each other, where these attain the gap; else with that of what reaches farthest.
fn with_facing_point(narrow: &mut Narrow, a: &Placed, b: &Placed, found: Separation) -> Separation {
    let (mut touches, size) = (Vec::new(), scale(a, b));
    let smallest = narrow.patches(a, b, &found, size, &mut touches);
    match touches.iter().min_by(|s, t| s.gap.total_cmp(&t.gap)) {
        Some(deepest) if smallest <= found.gap + REALISED * size => {
            Separation { midpoint: Some(deepest.position), ..found }
        }
        _ => narrow.closest(a, b, found, size, &mut touches),
    }
}

/// The triangles of a set against a convex shape B, where they are nearer than `bound`.
fn to_set(narrow: &mut Narrow, a: &PlacedSet, b: &Placed, bound: f64) -> Option<Nearest> {
    let (low, high) = b.shape.bounds();
    let relative = a.rotation.transpose() * b.rotation;
    let center = relative * (0.5 * (low + high)) + a.rotation.transpose() * (b.position - a.position);
    let half = relative.abs() * (0.5 * (high - low));
    let around = Aabb { low: center - half, high: center + half };
    let mut best: Option<Nearest> = None;
    a.set.bvh.nearest(&around, bound, |index| {
        let triangle = a.set.triangle(index);
        let (low, high) = bounds_of(&triangle.vertices);
        let middle = 0.5 * (low + high);
        let shape = Convex::Triangle(triangle);
        let (position, center) = (a.position, a.rotation * middle + a.position);
        let placed =
            Placed { shape: &shape, rotation: a.rotation, position, center, size: 0.5 * (high - low).length() };
        let known = best.map_or(bound, |best| best.distance);
        if let Some(found) = convex(narrow, &placed, b)
            && found.distance < known
        {
            best = Some(found);
        }
        best.map_or(bound, |best| best.distance)
    });
    best
}

/// The nearest triangles of two sets.
fn between_sets(narrow: &mut Narrow, a: &PlacedSet, b: &PlacedSet) -> Option<Nearest> {
    let mut best: Option<Nearest> = None;
    for index in 0..b.set.len() {
        let triangle = b.set.triangle(index);
        let (low, high) = bounds_of(&triangle.vertices);
        let shape = Convex::Triangle(triangle);
        let center = b.rotation * (0.5 * (low + high)) + b.position;
        let size = 0.5 * (high - low).length();
        let placed = Placed { shape: &shape, rotation: b.rotation, position: b.position, center, size };
        let bound = best.map_or(f64::INFINITY, |best| best.distance);
        if let Some(found) = to_set(narrow, a, &placed, bound) {
            best = Some(found);
        }
    }
    best
}
