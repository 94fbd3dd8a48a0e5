//! The way of a spatial tendon.

use glamx::glam::DVec3;

use super::wrapping::Obstacle;
use super::{BodyId, GeomId, Geometry, Model, PathPart, SiteId};
use crate::math::Pose;

/// A point of the world, m, and the body that carries it.
pub(crate) type Place = (BodyId, DVec3);

/// A straight part of a tendon's path.
pub(crate) struct Segment {
    /// Its ends: the body that carries each, and where it is in world, m.
    pub ends: [Place; 2],
    /// How much of its length counts.
    pub weight: f64,
    /// The obstacle on its way, touched or not.
    pub past: Option<Passage>,
}

/// An obstacle on the way between two sites.
#[derive(Clone, Copy)]
pub(crate) struct Passage {
    pub obstacle: Obstacle,
    /// The body that carries it.
    pub carrier: BodyId,
    /// The sites before and after.
    pub sites: [Place; 2],
    /// A site on the side where the string lies.
    pub side: Option<Place>,
    /// Which end of the segment slides on it: none where the string goes straight.
    pub touches: Option<usize>,
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
    let mut straight = |ends: [Place; 2], weight: f64, past: Option<Passage>| {
        let segment = Segment { ends, weight, past };
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
                    let past = around.take().and_then(|(geom, side): (GeomId, Option<SiteId>)| {
                        let (carrier, side) = (model.geoms[geom.index()].body, side.map(place));
                        let obstacle = obstacle(model, &pose, geom)?;
                        Some(Passage { obstacle, carrier, sites: [from, to], side, touches: None })
                    });
                    let touching = past.and_then(|past| {
                        let touching = past.obstacle.wrap([from, to].map(|(_, p)| p), past.side.map(|side| side.1))?;
                        Some((past, touching))
                    });
                    length += weight
                        * match touching {
                            None => straight([from, to], weight, past),
                            Some((past, touching)) => {
                                let [first, second] = touching.points.map(|point| (past.carrier, point));
                                let at = |end| Some(Passage { touches: Some(end), ..past });
                                straight([from, first], weight, at(1))
                                    + touching.length
                                    + straight([second, to], weight, at(0))
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
