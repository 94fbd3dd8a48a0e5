//! Closed forms of pairs whose features are not certain from where a point lies: differences of the search have to confirm them.

use signorini_multibody::glam::{DMat3, DVec3};
use signorini_multibody::{ContactPoint, GeomId, Geometry, Kinematics, Model, Pose};

use super::features::Feature;
use super::motion::{PointMotion, true_gap};
use super::rounded;

/// A place within this part of a shape's size of a face, an edge or an end is there.
const AT: f64 = 1e-9;

/// How the point moves if its features are what they seem to be: corners and ends on faces, edges on edges, and round shapes on a plane.
pub(super) fn motion(model: &Model, kinematics: &Kinematics, point: &ContactPoint) -> Option<PointMotion> {
    let gap = true_gap(model, point);
    let half = point.normal * (0.5 * gap);
    let [surface_a, surface_b] = [point.position - half, point.position + half];
    let shapes = [point.geom_a, point.geom_b].map(|id| &model.geoms[id.index()].geometry);
    if let (Geometry::Plane, round) = (shapes[0], shapes[1]) {
        let pose = pose_of(model, kinematics, point.geom_b);
        if let Some(slide) = Slide::on_plane(round, pose, -point.normal, surface_b) {
            return Some(slide.motion(point));
        }
    }
    let a = seen(model, kinematics, point.geom_a, surface_a, point.normal)?;
    let b = seen(model, kinematics, point.geom_b, surface_b, -point.normal)?;
    rounded::motion(point, gap, [a, b])
}

fn pose_of(model: &Model, kinematics: &Kinematics, id: GeomId) -> Pose {
    let geom = &model.geoms[id.index()];
    kinematics.pose[geom.body.index()] * geom.placement
}

/// The feature that a geom seems to have at a point of its surface.
fn seen(model: &Model, kinematics: &Kinematics, id: GeomId, surface: DVec3, outward: DVec3) -> Option<Feature> {
    let pose = pose_of(model, kinematics, id);
    let local = pose.rotation.conjugate() * (surface - pose.position);
    let leans = pose.rotation.conjugate() * outward;
    match model.geoms[id.index()].geometry {
        Geometry::Plane => Some(Feature::Plane),
        Geometry::Sphere { radius } => Some(Feature::Point { core: pose.position, radius, is_tie: false }),
        Geometry::Capsule { radius, half_length } => {
            let (core, axis) = (surface - outward * radius, pose.rotation * DVec3::Z);
            let place = axis.dot(core - pose.position);
            if half_length - place.abs() > AT * (half_length + radius) {
                return Some(Feature::Line { core, along: axis, radius });
            }
            let end = pose.position + axis * half_length.copysign(place);
            Some(Feature::Point { core: end, radius, is_tie: false })
        }
        Geometry::Box { half_extents } => {
            let at = [0, 1, 2].map(|i| (local[i].abs() - half_extents[i]).abs() <= AT * half_extents.max_element());
            match at.iter().filter(|at| **at).count() {
                1 => (0..3).any(|i| at[i] && leans[i] * local[i].signum() > 1.0 - AT).then_some(Feature::Plane),
                2 => {
                    let free = (0..3).find(|&i| !at[i])?;
                    Some(Feature::Line { core: surface, along: pose.rotation * DVec3::AXES[free], radius: 0.0 })
                }
                3 => Some(Feature::Point { core: surface, radius: 0.0, is_tie: false }),
                _ => None,
            }
        }
        // A place of the rim that does not slide along it.
        Geometry::Cylinder { .. } => Some(Feature::Point { core: surface, radius: 0.0, is_tie: false }),
        _ => None,
    }
}

/// The point of a round shape that lies farthest along a direction, and how it slides over the shape as this turns.
struct Slide {
    /// The centre of the shape.
    center: DVec3,
    /// How the point moves relative to the centre with rotations of the shape about the world's axes.
    by_turn: DMat3,
}

impl Slide {
    /// - `d`: towards the plane
    /// - `surface`: where the contact point lies, which has to be that point
    fn on_plane(shape: &Geometry, pose: Pose, d: DVec3, surface: DVec3) -> Option<Self> {
        let center = pose.position;
        let (arm, size, by_turn) = match *shape {
            Geometry::Ellipsoid { semi_axes } => {
                let turn = DMat3::from_quat(pose.rotation);
                let squares = turn * DMat3::from_diagonal(semi_axes * semi_axes) * turn.transpose();
                let along = squares * d;
                let reach = d.dot(along).sqrt();
                let by_turn = |axis: DVec3| {
                    let turned = axis.cross(along) - squares * axis.cross(d);
                    (turned - along * (d.dot(turned) / (2.0 * reach * reach))) / reach
                };
                (along / reach, semi_axes.max_element(), columns(by_turn))
            }
            Geometry::Cylinder { radius, half_length } => {
                let axis = pose.rotation * DVec3::Z;
                let out = d - axis * axis.dot(d);
                let tilt = out.length();
                let end = axis * half_length.copysign(axis.dot(surface - center));
                let unit = out / tilt;
                let by_turn = |turn: DVec3| {
                    let moved = turn.cross(axis);
                    let across = -(moved * axis.dot(d) + axis * moved.dot(d));
                    turn.cross(end) + (across - unit * unit.dot(across)) * (radius / tilt)
                };
                (end + unit * radius, radius + half_length, columns(by_turn))
            }
            _ => return None,
        };
        // What is not a number is not near.
        ((center + arm - surface).length() <= AT * size).then_some(Self { center, by_turn })
    }

    fn motion(&self, point: &ContactPoint) -> PointMotion {
        let n = point.normal;
        let mut out = PointMotion::of_rest();
        let to_center = self.center - point.position;
        for e in 0..6 {
            let axis = DVec3::AXES[e % 3];
            let moved = if e < 3 { axis.cross(to_center) + self.by_turn * axis } else { axis };
            out.gap[e] = n.dot(moved);
            out.position[e] = moved - n * (0.5 * out.gap[e]);
        }
        out
    }
}

fn columns(of: impl Fn(DVec3) -> DVec3) -> DMat3 {
    DMat3::from_cols(of(DVec3::X), of(DVec3::Y), of(DVec3::Z))
}
