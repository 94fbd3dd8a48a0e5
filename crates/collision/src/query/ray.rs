//! What a ray meets first.

use glamx::glam::DVec3;
use signorini_multibody::GeomId;

use super::placed::Queries;
use super::ray_shapes;
use crate::shape::Shape;

/// A half-line.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Ray {
    /// Where it begins, in world, m.
    pub origin: DVec3,
    /// Where it goes, unit, world axes; zero for a ray that meets nothing.
    pub direction: DVec3,
}

impl Ray {
    /// A ray from a point (m) along a vector of any length; one without a direction meets nothing.
    pub fn new(origin: impl Into<DVec3>, direction: impl Into<DVec3>) -> Self {
        Self { origin: origin.into(), direction: direction.into().normalize_or_zero() }
    }
}

/// Where a ray meets a geom first.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct RayHit {
    /// The geom.
    pub geom: GeomId,
    /// Distance from the ray's origin, m, ≥ 0.
    pub distance: f64,
    /// The point, in world, m.
    pub point: DVec3,
    /// Unit outward normal of the geom's surface, world axes; that of a triangle mesh looks at the ray's origin.
    pub normal: DVec3,
}

impl Queries {
    /// The first point at which a ray crosses the surface of a geom that is wanted. A ray that begins inside a shape meets its surface from
    /// inside; a plane is met from its front alone (MuJoCo's rules for `mj_ray`); of a convex mesh the hull is met.
    pub fn ray(&self, ray: &Ray, wanted: impl Fn(GeomId) -> bool) -> Option<RayHit> {
        if ray.direction == DVec3::ZERO || !ray.origin.is_finite() {
            return None;
        }
        let mut best: Option<RayHit> = None;
        for &i in self.planes.iter().filter(|&&i| wanted(GeomId(i))) {
            best = nearer(best, self.crossing(i, ray, f64::INFINITY));
        }
        let limit = best.map_or(f64::INFINITY, |hit| hit.distance);
        self.tree.along(ray.origin, ray.direction, limit, |i| {
            let limit = best.map_or(f64::INFINITY, |hit| hit.distance);
            if wanted(GeomId(i)) {
                best = nearer(best, self.crossing(i, ray, limit));
            }
            best.map_or(f64::INFINITY, |hit| hit.distance)
        });
        best
    }

    /// [`ray`](Self::ray) for many rays, on `threads` threads (0: as many as the machine runs at once); the result does not depend on
    /// their number.
    ///
    /// - `out`: `[rays]`
    ///
    /// # Panics
    /// If `out` has another length than `rays`.
    pub fn rays_into(
        &self,
        rays: &[Ray],
        threads: usize,
        wanted: impl Fn(GeomId) -> bool + Sync,
        out: &mut [Option<RayHit>],
    ) {
        assert_eq!(rays.len(), out.len(), "a hit for every ray");
        let available = || std::thread::available_parallelism().map_or(1, |n| n.get());
        let threads = if threads == 0 { available() } else { threads }.min(rays.len() / RAYS_PER_THREAD).max(1);
        let share = rays.len().div_ceil(threads).max(1);
        let cast = |rays: &[Ray], out: &mut [Option<RayHit>]| {
            rays.iter().zip(out).for_each(|(ray, hit)| *hit = self.ray(ray, &wanted));
        };
        if threads == 1 {
            return cast(rays, out);
        }
        std::thread::scope(|scope| {
            for (rays, out) in rays.chunks(share).zip(out.chunks_mut(share)) {
                scope.spawn(move || cast(rays, out));
            }
        });
    }

    /// Where a ray crosses one geom before `limit` (m).
    fn crossing(&self, i: u32, ray: &Ray, limit: f64) -> Option<RayHit> {
        let k = i as usize;
        let (rotation, position) = (self.rotation[k], self.pose[k].position);
        let back = rotation.transpose();
        let (origin, direction) = (back * (ray.origin - position), back * ray.direction);
        let crossing = match &self.geoms[k].shape {
            Shape::HalfSpace => ray_shapes::plane(origin, direction),
            Shape::Convex(shape) => ray_shapes::convex(shape, origin, direction),
            Shape::Triangles(set) => ray_shapes::triangles(set, origin, direction, limit),
            Shape::Absent => None,
        }?;
        let (distance, point) = (crossing.distance, ray.origin + ray.direction * crossing.distance);
        Some(RayHit { geom: GeomId(i), distance, point, normal: rotation * crossing.normal })
    }
}

/// A thread is worth its start where it has so many rays: tens of microseconds.
const RAYS_PER_THREAD: usize = 256;

/// The nearer of two hits; of two at the same distance that of the first geom, whatever the order in which they were found.
fn nearer(a: Option<RayHit>, b: Option<RayHit>) -> Option<RayHit> {
    match (a, b) {
        (Some(x), Some(y)) if (y.distance, y.geom) < (x.distance, x.geom) => b,
        (None, _) => b,
        _ => a,
    }
}
