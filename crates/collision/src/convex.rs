//! Convex shapes by their support functions.

use std::sync::Arc;

use glamx::glam::{DMat3, DVec3};

use crate::hull::Hull;

/// A convex shape in its own frame. Sizes as in [`Geometry`](signorini_multibody::Geometry).
#[derive(Clone, Debug)]
pub(crate) enum Convex {
    Sphere { radius: f64 },
    Box { half: DVec3 },
    Capsule { radius: f64, half_length: f64 },
    Cylinder { radius: f64, half_length: f64 },
    Cone { radius: f64, half_length: f64 },
    Ellipsoid { axes: DVec3 },
    Hull(Arc<Hull>),
    Triangle(Triangle),
}

/// A triangle of a mesh with its unit normal and the mesh indices of its vertices.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Triangle {
    pub vertices: [DVec3; 3],
    pub ids: [u32; 3],
    pub normal: DVec3,
}

impl Convex {
    /// Radius of the ball that is swept over the core (see [`core_support`](Self::core_support)), m.
    pub fn radius(&self) -> f64 {
        match self {
            Self::Sphere { radius } | Self::Capsule { radius, .. } => *radius,
            _ => 0.0,
        }
    }

    /// A point of the core that is farthest along `d`: the centre of a sphere, the axis of a capsule, else the shape.
    pub fn core_support(&self, d: DVec3) -> DVec3 {
        match self {
            Self::Sphere { .. } => DVec3::ZERO,
            Self::Box { half } => {
                DVec3::new(half.x.copysign(d.x + 0.0), half.y.copysign(d.y + 0.0), half.z.copysign(d.z + 0.0))
            }
            Self::Capsule { half_length, .. } => DVec3::new(0.0, 0.0, half_length.copysign(d.z + 0.0)),
            Self::Cylinder { radius, half_length } => {
                let rim = radial(d) * *radius;
                DVec3::new(rim.x, rim.y, half_length.copysign(d.z + 0.0))
            }
            Self::Cone { radius, half_length } => {
                let rim = radial(d) * *radius - DVec3::Z * *half_length;
                let apex = DVec3::Z * *half_length;
                if d.dot(apex) > d.dot(rim) { apex } else { rim }
            }
            Self::Ellipsoid { axes } => {
                let scaled = *axes * d;
                let length = scaled.length();
                if length > 0.0 { *axes * scaled / length } else { DVec3::X * axes.x }
            }
            Self::Hull(hull) => hull.support(d),
            Self::Triangle(t) => {
                let [a, b, c] = t.vertices;
                let (x, y, z) = (d.dot(a), d.dot(b), d.dot(c));
                if x >= y && x >= z {
                    a
                } else if y >= z {
                    b
                } else {
                    c
                }
            }
        }
    }

    /// Corners of the axis-aligned box around the shape, in its own frame.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let symmetric = |e: DVec3| (-e, e);
        match self {
            Self::Sphere { radius } => symmetric(DVec3::splat(*radius)),
            Self::Box { half } => symmetric(*half),
            Self::Capsule { radius, half_length } => symmetric(DVec3::new(*radius, *radius, half_length + radius)),
            Self::Cylinder { radius, half_length } | Self::Cone { radius, half_length } => {
                symmetric(DVec3::new(*radius, *radius, *half_length))
            }
            Self::Ellipsoid { axes } => symmetric(*axes),
            Self::Hull(hull) => bounds_of(&hull.vertices),
            Self::Triangle(t) => bounds_of(&t.vertices),
        }
    }
}

/// Unit vector of `d` without its z component; x where there is none.
pub(crate) fn radial(d: DVec3) -> DVec3 {
    // Directions are far from where squares underflow, and `hypot` would take more time than all the rest.
    let length = (d.x * d.x + d.y * d.y).sqrt();
    if length > 0.0 { DVec3::new(d.x / length, d.y / length, 0.0) } else { DVec3::X }
}

/// Corners of the axis-aligned box around points.
pub(crate) fn bounds_of(points: &[DVec3]) -> (DVec3, DVec3) {
    let start = (DVec3::splat(f64::INFINITY), DVec3::splat(f64::NEG_INFINITY));
    points.iter().fold(start, |(low, high), p| (low.min(*p), high.max(*p)))
}

/// A convex shape at a pose. All narrow-phase functions work in one common frame whose origin is near both shapes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placed<'a> {
    pub shape: &'a Convex,
    pub rotation: DMat3,
    pub position: DVec3,
    /// Centre of the shape's bounding box, in the common frame, m.
    pub center: DVec3,
    /// Radius of a ball about `center` that holds the shape, m.
    pub size: f64,
}

impl Placed<'_> {
    /// The direction in the shape's own frame.
    pub fn local(&self, d: DVec3) -> DVec3 {
        self.rotation.transpose() * d
    }

    /// The point in the common frame.
    pub fn point(&self, p: DVec3) -> DVec3 {
        self.rotation * p + self.position
    }

    /// A point of the core farthest along `d`.
    pub fn core_support(&self, d: DVec3) -> DVec3 {
        self.point(self.shape.core_support(self.local(d)))
    }

    /// A point of the shape farthest along `d`.
    pub fn support(&self, d: DVec3) -> DVec3 {
        let core = self.core_support(d);
        let radius = self.shape.radius();
        if radius > 0.0 { core + d.normalize_or_zero() * radius } else { core }
    }

    /// A point inside the shape, in the common frame: the mean of what reaches farthest along its axes. The centre of its bounding box may lie outside.
    pub fn inside(&self) -> DVec3 {
        let ends = DVec3::AXES.iter().flat_map(|d| [*d, -*d]).map(|d| self.shape.core_support(d));
        self.point(ends.sum::<DVec3>() / 6.0)
    }

    /// The farthest reach along the unit vector `d`, m.
    pub fn extent(&self, d: DVec3) -> f64 {
        d.dot(self.core_support(d)) + self.shape.radius()
    }
}

/// The length that tolerances of a pair are shares of, m: the smaller shape's, but not so small that the larger one's
/// rounding exceeds them.
pub(crate) fn scale(a: &Placed, b: &Placed) -> f64 {
    (2.0 * a.size.min(b.size)).max(1e-3 * (a.size + b.size))
}

/// How far two shapes are apart along a unit normal from A to B: `min n·b − max n·a`, m.
pub(crate) fn separation_along(a: &Placed, b: &Placed, n: DVec3) -> f64 {
    let core = n.dot(b.core_support(-n) - a.core_support(n));
    core - a.shape.radius() - b.shape.radius()
}
