//! Velocities, Jacobians and their rates of frames fixed to bodies, in the three conventions in use.

use glamx::glam::DVec3;

use crate::kinematics::Kinematics;
use crate::math::Pose;
use crate::model::{BodyId, FrameId, JointKind, Model};
use crate::spatial::SpatialVector;

/// A frame fixed to a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// The body.
    pub body: BodyId,
    /// `X_BF`, the frame in the body's.
    pub placement: Pose,
}

impl Frame {
    /// The frame of a body.
    pub fn of_body(body: BodyId) -> Self {
        Self { body, placement: Pose::IDENTITY }
    }

    /// A frame that sensors can look at, as one fixed to a body.
    ///
    /// # Panics
    /// If the model has no such part.
    pub fn of(model: &Model, frame: FrameId) -> Self {
        let (body, placement) = match frame {
            FrameId::Body(body) => (body, Pose::IDENTITY),
            FrameId::CenterOfMass(body) => {
                (body, Pose::from_position(model.bodies[body.index()].inertia.center_of_mass))
            }
            FrameId::Geom(geom) => (model.geoms[geom.index()].body, model.geoms[geom.index()].placement),
            FrameId::Site(site) => (model.sites[site.index()].body, model.sites[site.index()].placement),
        };
        Self { body, placement }
    }

    /// `X_WF`, m.
    pub fn pose(&self, kinematics: &Kinematics) -> Pose {
        kinematics.pose[self.body.index()] * self.placement
    }
}

/// Where and along which axes the velocity of a frame is expressed; the names are Pinocchio's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReferenceFrame {
    /// The body's point at the world's origin, world axes (spatial velocity).
    World,
    /// The frame's origin, the frame's axes (body velocity).
    Local,
    /// The frame's origin, world axes.
    LocalWorldAligned,
}

/// Rates of the joint axes in [`Kinematics::dof_angular`] and [`Kinematics::dof_linear`], from which the rate `J̇` of every
/// Jacobian follows.
#[derive(Clone, Debug)]
pub struct AxisRates {
    /// `d/dt` of `dof_angular`, world axes, 1/s.
    pub angular: Vec<DVec3>,
    /// `d/dt` of `dof_linear`, world axes, m/s or 1/s.
    pub linear: Vec<DVec3>,
}

impl AxisRates {
    /// Storage for a model.
    pub fn new(model: &Model) -> Self {
        Self { angular: vec![DVec3::ZERO; model.nv], linear: vec![DVec3::ZERO; model.nv] }
    }
}

/// Rates of all joint axes along the motion.
///
/// - `kinematics`: from [`forward_kinematics_into`](crate::forward_kinematics_into) at `(q, v)`
/// - `v`: `[nv]`
/// - `rates`: out
///
/// # Panics
/// If a length does not fit the model.
///
/// # Cost
/// O(dofs), no allocation.
///
/// # Source
/// An axis is fixed in the frame after its joint, which turns with `ω`; with the lever `r` from a fixed point of the axis
/// to the body's origin, `d/dt (a × r) = ω × (a × r) + a × u`, where `u` is the velocity that the later joints of the same
/// body give to its origin.
pub fn axis_rates_into(model: &Model, kinematics: &Kinematics, v: &[f64], rates: &mut AxisRates) {
    assert!(v.len() == model.nv && rates.angular.len() == model.nv, "lengths must be nv");
    for i in 1..model.bodies.len() {
        let (mut omega, mut later) = (kinematics.angular_velocity[i], DVec3::ZERO);
        for joint in model.joints_of(BodyId(i as u32)).iter().rev() {
            let dofs = joint.v_index..joint.v_index + joint.kind.nv();
            for k in dofs.clone() {
                let (angular, linear) = (kinematics.dof_angular[k], kinematics.dof_linear[k]);
                rates.angular[k] = omega.cross(angular);
                rates.linear[k] = omega.cross(linear) + angular.cross(later);
            }
            if joint.kind == JointKind::Free {
                // Its translations are along the world's axes.
                rates.linear[joint.v_index..joint.v_index + 3].fill(DVec3::ZERO);
            }
            for k in dofs {
                omega -= kinematics.dof_angular[k] * v[k];
                later += kinematics.dof_linear[k] * v[k];
            }
        }
    }
}

/// Velocity of a frame.
pub fn frame_velocity(kinematics: &Kinematics, frame: &Frame, reference: ReferenceFrame) -> SpatialVector {
    let pose = frame.pose(kinematics);
    let angular = kinematics.angular_velocity[frame.body.index()];
    let linear = kinematics.point_velocity(frame.body, pose.position);
    express(SpatialVector { angular, linear }, &pose, reference)
}

/// `J̇ v`: the acceleration of a frame when `v̇ = 0`, the rate of [`frame_velocity`] in the same convention.
///
/// - `kinematics`: from [`forward_kinematics_into`](crate::forward_kinematics_into) at `(q, v)`
///
/// In the conventions at the frame's origin the linear part is that of classical accelerations (second derivatives of
/// positions); for [`ReferenceFrame::Local`] it is the rate of the components, which lacks `ω ×` the velocity.
///
/// # Cost
/// O(depth), no allocation.
pub fn frame_bias_acceleration(
    model: &Model,
    kinematics: &Kinematics,
    frame: &Frame,
    reference: ReferenceFrame,
) -> SpatialVector {
    let pose = frame.pose(kinematics);
    let omega = kinematics.angular_velocity[frame.body.index()];
    // From the frame's origin back to the origin of each body on the way to the root.
    let mut lever = kinematics.rotation[frame.body.index()] * frame.placement.position;
    let mut bias = SpatialVector { angular: DVec3::ZERO, linear: omega.cross(omega.cross(lever)) };
    let mut b = frame.body;
    while b != BodyId::WORLD {
        let i = b.index();
        bias.angular += kinematics.bias_angular[i];
        bias.linear += kinematics.bias_linear[i] + kinematics.bias_angular[i].cross(lever);
        lever += kinematics.offset[i];
        b = model.bodies[i].parent;
    }
    let linear = kinematics.point_velocity(frame.body, pose.position);
    rate(bias, SpatialVector { angular: omega, linear }, omega, linear, &pose, reference)
}

/// Jacobian of the velocity of a frame: [`frame_velocity`]` = J v`.
///
/// - `kinematics`: from [`forward_kinematics_into`](crate::forward_kinematics_into)
/// - `out`: `J`, `[6, nv]` row by row, three angular rows before three linear ones (Pinocchio has them the other way round)
///
/// # Panics
/// If `out` does not have `6 nv` entries.
///
/// # Cost
/// O(depth) beside clearing `out`, no allocation.
pub fn frame_jacobian_into(
    model: &Model,
    kinematics: &Kinematics,
    frame: &Frame,
    reference: ReferenceFrame,
    out: &mut [f64],
) {
    let pose = frame.pose(kinematics);
    fill(model, frame.body, out, |k| express(column(model, kinematics, k, pose.position), &pose, reference));
}

/// Rate `J̇` of [`frame_jacobian_into`] along the motion, in the same convention.
///
/// - `kinematics`: from [`forward_kinematics_into`](crate::forward_kinematics_into) at `(q, v)`
/// - `rates`: from [`axis_rates_into`] at the same
/// - `out`: `J̇`, `[6, nv]` row by row, three angular rows before three linear ones
///
/// # Panics
/// If `out` does not have `6 nv` entries.
///
/// # Cost
/// O(depth) beside clearing `out`, no allocation.
pub fn frame_jacobian_rate_into(
    model: &Model,
    kinematics: &Kinematics,
    rates: &AxisRates,
    frame: &Frame,
    reference: ReferenceFrame,
    out: &mut [f64],
) {
    let pose = frame.pose(kinematics);
    let omega = kinematics.angular_velocity[frame.body.index()];
    let speed = kinematics.point_velocity(frame.body, pose.position);
    fill(model, frame.body, out, |k| {
        let i = model.dof_body(k).index();
        let lever = pose.position - kinematics.pose[i].position;
        let lever_rate = speed - kinematics.linear_velocity[i];
        let change = SpatialVector {
            angular: rates.angular[k],
            linear: rates.linear[k] + rates.angular[k].cross(lever) + kinematics.dof_angular[k].cross(lever_rate),
        };
        rate(change, column(model, kinematics, k, pose.position), omega, speed, &pose, reference)
    });
}

/// Velocity of the frame's origin and angular velocity per unit rate of a degree of freedom that moves the body.
fn column(model: &Model, kinematics: &Kinematics, k: usize, point: DVec3) -> SpatialVector {
    SpatialVector { angular: kinematics.dof_angular[k], linear: crate::point_column(model, kinematics, k, point) }
}

/// A velocity at the frame's origin in world axes, in a convention.
fn express(x: SpatialVector, pose: &Pose, reference: ReferenceFrame) -> SpatialVector {
    match reference {
        ReferenceFrame::LocalWorldAligned => x,
        ReferenceFrame::World => SpatialVector { linear: x.linear - x.angular.cross(pose.position), ..x },
        ReferenceFrame::Local => {
            let back = pose.rotation.conjugate();
            SpatialVector { angular: back * x.angular, linear: back * x.linear }
        }
    }
}

/// The rate of [`express`] when the frame turns with `omega`, its origin moves with `speed`, and `x` changes with `change`.
fn rate(
    change: SpatialVector,
    x: SpatialVector,
    omega: DVec3,
    speed: DVec3,
    pose: &Pose,
    reference: ReferenceFrame,
) -> SpatialVector {
    match reference {
        ReferenceFrame::LocalWorldAligned => change,
        ReferenceFrame::World => {
            let linear = change.linear - change.angular.cross(pose.position) - x.angular.cross(speed);
            SpatialVector { linear, ..change }
        }
        ReferenceFrame::Local => {
            let back = pose.rotation.conjugate();
            let angular = back * (change.angular - omega.cross(x.angular));
            SpatialVector { angular, linear: back * (change.linear - omega.cross(x.linear)) }
        }
    }
}

fn fill(model: &Model, body: BodyId, out: &mut [f64], column: impl Fn(usize) -> SpatialVector) {
    assert_eq!(out.len(), 6 * model.nv, "the Jacobian needs 6 nv entries");
    out.fill(0.0);
    for k in model.dofs_moving(body) {
        for (row, x) in column(k).to_array().into_iter().enumerate() {
            out[row * model.nv + k] = x;
        }
    }
}
