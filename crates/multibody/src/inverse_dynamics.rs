//! Generalized forces of a motion by the recursive Newton–Euler algorithm.

use glamx::glam::{DMat3, DVec3};

use crate::kinematics::Kinematics;
use crate::model::{BodyId, Inertia, Model};
use crate::moving::{MovingBodies, MovingBody};
use crate::standing::{Known, Nothing};

/// Storage of the recursive Newton–Euler algorithm.
#[derive(Clone, Debug)]
pub struct NewtonEuler {
    /// Of every body, world axes, about its origin.
    motions: Vec<Motion>,
    moving: MovingBodies,
}

/// How a body is accelerated, the acceleration of its origin less gravity, and the wrench that it takes with all that hangs on it.
#[derive(Clone, Copy, Debug)]
struct Motion {
    angular: DVec3,
    linear: DVec3,
    moment: DVec3,
    force: DVec3,
}

impl NewtonEuler {
    /// Storage for a model.
    pub fn new(model: &Model) -> Self {
        let zero = DVec3::ZERO;
        let rest = Motion { angular: zero, linear: zero, moment: zero, force: zero };
        Self { motions: vec![rest; model.bodies.len()], moving: MovingBodies::of(model) }
    }

    /// Angular acceleration of a body and the acceleration of its origin less gravity, world axes, rad/s² and m/s², of the
    /// last motion given to [`inverse_dynamics_into`].
    pub fn acceleration(&self, body: BodyId) -> (DVec3, DVec3) {
        let motion = &self.motions[body.index()];
        (motion.angular, motion.linear)
    }

    /// Moment about a body's origin and force, world axes, N·m and N, that the last motion given to
    /// [`inverse_dynamics_into`] takes for the body with all that hangs on it. Less what acts from outside, this is how
    /// its parent holds it. Zero for the world.
    pub fn wrench(&self, body: BodyId) -> (DVec3, DVec3) {
        let motion = &self.motions[body.index()];
        (motion.moment, motion.force)
    }
}

/// Inverse dynamics: the generalized force `τ = M v̇ + h` of a motion, with gravity, Coriolis, centrifugal and gyroscopic
/// forces and armature; joint springs, damping, limits and friction are not part of it.
///
/// - `kinematics`: from [`forward_kinematics_into`](crate::forward_kinematics_into) at the same `(q, v)`
/// - `acceleration`: `v̇`, `[nv]`
/// - `tau`: out, `[nv]`, N, N·m
///
/// # Panics
/// If a length does not fit the model.
///
/// # Cost
/// O(bodies + dofs), no allocation.
///
/// # Source
/// Featherstone (2008), ch. 5.3, with classical accelerations of the bodies' origins.
pub fn inverse_dynamics_into(
    model: &Model,
    kinematics: &Kinematics,
    acceleration: &[f64],
    work: &mut NewtonEuler,
    tau: &mut [f64],
) {
    assert!(acceleration.len() == model.nv && tau.len() == model.nv, "lengths must be nv");
    newton_euler(model, kinematics, Some(acceleration), || MovingBodies::apart(model), &mut work.motions, tau);
    for joint in model.joints.iter().filter(|joint| joint.armature != 0.0) {
        for k in joint.v_index..joint.v_index + joint.kind.nv() {
            tau[k] += joint.armature * acceleration[k];
        }
    }
}

/// The bias force `h(q, v)` of `M v̇ + h = τ`: gravity, Coriolis, centrifugal and gyroscopic forces (formulation §1).
///
/// Arguments as for [`inverse_dynamics_into`].
///
/// # Panics
/// If a length does not fit the model.
pub fn bias_force_into(model: &Model, kinematics: &Kinematics, work: &mut NewtonEuler, h: &mut [f64]) {
    bias_force_of(model, kinematics, Nothing, work, h);
}

/// [`bias_force_into`] of what is not known.
pub(crate) fn bias_force_of(
    model: &Model,
    kinematics: &Kinematics,
    known: impl Known,
    work: &mut NewtonEuler,
    h: &mut [f64],
) {
    assert_eq!(h.len(), model.nv, "length must be nv");
    let NewtonEuler { motions, moving } = work;
    let unknown = || moving.0.iter().copied().filter(|one| !known.has_body(one.body));
    newton_euler(model, kinematics, None, unknown, motions, h);
}

/// - `acceleration`: zero where it is not given
/// - `bodies`: those that are visited, parents first
fn newton_euler<Bodies: DoubleEndedIterator<Item = MovingBody>>(
    model: &Model,
    kinematics: &Kinematics,
    acceleration: Option<&[f64]>,
    bodies: impl Fn() -> Bodies,
    motions: &mut [Motion],
    tau: &mut [f64],
) {
    motions[0].linear = -model.gravity;
    for MovingBody { body: i, carrier, inertia } in bodies() {
        let step = &model.path[i];
        let carrying = &motions[carrier];
        let around = carrying.angular;
        let mut angular = around + kinematics.bias_angular[i];
        let mut linear = carrying.linear + kinematics.bias_linear[i];
        if carrier != 0 {
            linear += around.cross(kinematics.offset[i]);
        }
        if let Some(acceleration) = acceleration {
            for k in step.first_dof..step.end_dof {
                angular += kinematics.dof_angular[k] * acceleration[k];
                linear += kinematics.dof_linear[k] * acceleration[k];
            }
        }
        let (moment, force) = rate_of_momentum(&inertia, kinematics, i, angular, linear);
        motions[i] = Motion { angular, linear, moment, force };
    }
    for MovingBody { body: i, carrier, .. } in bodies().rev() {
        let step = &model.path[i];
        let Motion { moment, force, .. } = motions[i];
        if step.free {
            // Its axes are the world's and the body's.
            let moment = kinematics.rotation[i].mul_transpose_vec3(moment);
            tau[step.first_dof..][..3].copy_from_slice(&force.to_array());
            tau[step.first_dof + 3..][..3].copy_from_slice(&moment.to_array());
            continue;
        }
        for k in step.first_dof..step.end_dof {
            tau[k] = kinematics.dof_angular[k].dot(moment) + kinematics.dof_linear[k].dot(force);
        }
        if carrier != 0 {
            let carrying = &mut motions[carrier];
            carrying.moment += moment + kinematics.offset[i].cross(force);
            carrying.force += force;
        }
    }
}

/// Newton–Euler equations of one body: moment about its origin and force, world axes, that give it an angular
/// acceleration and its origin an acceleration, at the velocities of the kinematics.
pub(crate) fn rate_of_momentum(
    inertia: &Inertia,
    kinematics: &Kinematics,
    i: usize,
    angular: DVec3,
    linear: DVec3,
) -> (DVec3, DVec3) {
    if inertia.mass == 0.0 && inertia.rotational == DMat3::ZERO {
        return (DVec3::ZERO, DVec3::ZERO);
    }
    let rotation = kinematics.rotation[i];
    let velocity = kinematics.angular_velocity[i];
    let velocity_b = rotation.mul_transpose_vec3(velocity);
    let mut spin = velocity_b.cross(inertia.rotational * velocity_b);
    if angular != DVec3::ZERO {
        spin += inertia.rotational * rotation.mul_transpose_vec3(angular);
    }
    if inertia.center_of_mass == DVec3::ZERO {
        return (rotation * spin, linear * inertia.mass);
    }
    let c = rotation * inertia.center_of_mass;
    let force = (linear + angular.cross(c) + velocity.cross(velocity.cross(c))) * inertia.mass;
    (rotation * spin + c.cross(force), force)
}
