//! Prepared geoms where they stand.

use glamx::glam::{DMat3, DVec3};

use crate::convex::{Convex, Placed};
use crate::halfspace::HalfSpace;
use crate::mesh::{PlacedSet, TriangleSet};
use crate::shape::{Prepared, Shape};

/// A geom in world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct GeomPose {
    pub rotation: DMat3,
    pub position: DVec3,
    pub center: DVec3,
}

/// Order in which shapes take the A side of the narrow phase.
pub(crate) fn rank(shape: &Shape) -> u32 {
    match shape {
        Shape::Absent | Shape::HalfSpace => 0,
        Shape::Triangles(_) => 1,
        Shape::Convex(_) => 2,
    }
}

pub(crate) fn place<'a>(geom: &Prepared, shape: &'a Convex, pose: &GeomPose, origin: DVec3) -> Placed<'a> {
    let (position, center) = (pose.position - origin, pose.center - origin);
    Placed { shape, rotation: pose.rotation, position, center, size: geom.size }
}

pub(crate) fn place_set<'a>(set: &'a TriangleSet, pose: &GeomPose, origin: DVec3) -> PlacedSet<'a> {
    PlacedSet { set, rotation: pose.rotation, position: pose.position - origin }
}

pub(crate) fn half_space(pose: &GeomPose, origin: DVec3) -> HalfSpace {
    let normal = pose.rotation.z_axis;
    HalfSpace { normal, offset: normal.dot(pose.position - origin) }
}
