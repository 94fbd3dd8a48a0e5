//! Where cameras are, and where they see a point.

use glamx::glam::{DMat3, DQuat, DVec3};

use crate::kinematics::Kinematics;
use crate::math::Pose;
use crate::model::{Camera, CameraMode, Model};
use crate::subtree::subtree_center_of_mass;

/// Nearer to the plane of the camera than this, a point is seen as if at this distance, m: MuJoCo's `mjMINVAL`.
const NOTHING: f64 = 1e-15;

/// `X_WC` of a camera of a model: x to the right of the picture, y up, −z into the scene.
///
/// - `kinematics`: from [`forward_kinematics_into`](crate::forward_kinematics_into) at the configuration
///
/// # Source
/// MuJoCo's camera modes.
pub fn camera_pose(model: &Model, kinematics: &Kinematics, camera: &Camera) -> Pose {
    let carried = kinematics.pose[camera.body.index()] * camera.placement;
    let center = |body| subtree_center_of_mass(model, kinematics, body).1;
    let following = |origin: DVec3| Pose::new(origin + camera.start.position, camera.start.rotation);
    let looking = |to: DVec3| Pose::new(carried.position, camera_axes(to - carried.position));
    match camera.mode {
        CameraMode::Fixed => carried,
        CameraMode::Track => following(kinematics.pose[camera.body.index()].position),
        CameraMode::TrackCenterOfMass => following(center(camera.body)),
        CameraMode::Target(body) => looking(kinematics.pose[body.index()].position),
        CameraMode::TargetCenterOfMass(body) => looking(center(body)),
    }
}

/// Axes of a camera that looks along a vector with the world's z axis up, or y where it looks along z.
pub fn camera_axes(ahead: DVec3) -> DQuat {
    let back = -ahead.normalize_or(DVec3::NEG_Z);
    let across = DVec3::Z.cross(back);
    let right = if across.length() > 1e-6 { across.normalize() } else { DVec3::X };
    DQuat::from_mat3(&DMat3::from_cols(right, back.cross(right), back)).normalize()
}

/// Pixels from the left and from the upper edge of a camera's picture at which it sees a point in world.
pub(crate) fn project(model: &Model, kinematics: &Kinematics, camera: &Camera, point: DVec3) -> [f64; 2] {
    let p = camera_pose(model, kinematics, camera).inverse().transform_point(point);
    let [width, height] = camera.resolution.map(f64::from);
    let square = 0.5 * height / (0.5 * camera.field_of_view).tan();
    let [fx, fy] = camera.focal.map_or([square; 2], |[x, y]| [x * width, y * height]);
    let depth = if p.z.abs() < NOTHING { NOTHING.copysign(p.z) } else { p.z };
    [0.5 * width - fx * p.x / depth, 0.5 * height + fy * p.y / depth]
}
