//! The way of a spatial tendon.

use glamx::glam::DVec3;

use super::wrapping::Obstacle;
use super::{BodyId, GeomId, Geometry, Model, PathPart, SiteId};
use crate::math::Pose;

/// A straight part of a tendon's path.
pub(crate) struct Segment {
    /// Its ends: the body that carries each, and where it is in world, m.
    pub ends: [(BodyId, DVec3); 2],
    /// How much of its length counts.
    pub weight: f64,
}

impl Segment {
    pub fn way(&self) -> DVec3 {
        self.ends[1].1 - self.ends[0].1
    }

    /// Its direction; x where it has no length, as MuJoCo has it.
    pub fn direction(&self) -> DVec3 {
        self.way().try_normalize().unwrap_or(DVec3::X)
    }
}

/// Visits the straight parts of a path, and returns the whole length, m.
///
/// - `pose`: `X_WB` of every body
pub(crate) fn walk(
    model: &Model,
    pose: impl Fn(BodyId) -> Pose,
    path: &[PathPart],
    mut visit: impl FnMut(&Segment),
) -> f64 {
    let place = |id: SiteId| {
        let site = &model.sites[id.index()];
        (site.body, pose(site.body).transform_point(site.placement.position))
    };
    let (mut length, mut weight) = (0.0, 1.0);
    let mut straight = |ends: [(BodyId, DVec3); 2], weight: f64| {
        let segment = Segment { ends, weight };
        visit(&segment);
        segment.way().length()
    };
    let mut last = None;
    let mut around = None;
    for part in path {
        match *part {
            PathPart::Pulley { divisor } => (weight, last, around) = (1.0 / divisor, None, None),
            PathPart::Wrap { geom, side } => around = Some((geom, side)),
            PathPart::Site(site) => {
                let to = place(site);
                if let Some(from) = last {
                    let touching = around.take().and_then(|(geom, side): (GeomId, Option<SiteId>)| {
                        let side = side.map(|side| place(side).1);
                        Some((geom, obstacle(model, &pose, geom)?.wrap([from, to].map(|(_, p)| p), side)?))
                    });
                    length += weight
                        * match touching {
                            None => straight([from, to], weight),
                            Some((geom, touching)) => {
                                let body = model.geoms[geom.index()].body;
                                let [first, second] = touching.points.map(|point| (body, point));
                                straight([from, first], weight) + touching.length + straight([second, to], weight)
                            }
                        };
                }
                last = Some(to);
            }
        }
    }
    length
}

/// What a geom is for a string; nothing for shapes that are neither a sphere nor a cylinder, which models do not have here.
fn obstacle(model: &Model, pose: impl Fn(BodyId) -> Pose, geom: GeomId) -> Option<Obstacle> {
    let geom = &model.geoms[geom.index()];
    let (radius, is_cylinder) = match geom.geometry {
        Geometry::Sphere { radius } => (radius, false),
        Geometry::Cylinder { radius, .. } => (radius, true),
        _ => return None,
    };
    Some(Obstacle { pose: pose(geom.body) * geom.placement, radius, is_cylinder })
}
