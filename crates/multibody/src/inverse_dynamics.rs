//! Generalized forces of a motion by the recursive Newton–Euler algorithm.

use glamx::glam::DVec3;

use crate::kinematics::Kinematics;
use crate::model::{BodyId, Inertia, Model};
use crate::standing::{Known, Nothing};

/// Storage of the recursive Newton–Euler algorithm: one entry per body, world axes, about the body's origin.
#[derive(Clone, Debug)]
pub struct NewtonEuler(Vec<Motion>);

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
        Self(vec![Motion { angular: zero, linear: zero, moment: zero, force: zero }; model.bodies.len()])
    }

    /// Angular acceleration of a body and the acceleration of its origin less gravity, world axes, rad/s² and m/s², of the
    /// last motion given to [`inverse_dynamics_into`].
    pub fn acceleration(&self, body: BodyId) -> (DVec3, DVec3) {
        let motion = &self.0[body.index()];
        (motion.angular, motion.linear)
    }

    /// Moment about a body's origin and force, world axes, N·m and N, that the last motion given to
    /// [`inverse_dynamics_into`] takes for the body with all that hangs on it. Less what acts from outside, this is how
    /// its parent holds it. Zero for the world.
    pub fn wrench(&self, body: BodyId) -> (DVec3, DVec3) {
        let motion = &self.0[body.index()];
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
    newton_euler(model, kinematics, Some(acceleration), Nothing, work, tau);
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
    newton_euler(model, kinematics, None, known, work, h);
}

/// `acceleration`: zero where it is not given.
fn newton_euler(
    model: &Model,
    kinematics: &Kinematics,
    acceleration: Option<&[f64]>,
    known: impl Known,
    work: &mut NewtonEuler,
    tau: &mut [f64],
) {
    let motions = &mut work.0[..];
    motions[0].linear = -model.gravity;
    let is_unknown = |i: usize| !known.has_body(i);
    for (i, (step, body)) in model.path.iter().zip(&model.bodies).enumerate().skip(1).filter(|(i, _)| is_unknown(*i)) {
        let parent = &motions[step.parent];
        let around = parent.angular;
        let mut angular = around + kinematics.bias_angular[i];
        let mut linear = parent.linear + kinematics.bias_linear[i];
        if step.parent != 0 {
            linear += around.cross(kinematics.offset[i]);
        }
        if let Some(acceleration) = acceleration {
            for k in step.first_dof..step.end_dof {
                angular += kinematics.dof_angular[k] * acceleration[k];
                linear += kinematics.dof_linear[k] * acceleration[k];
            }
        }
        let (moment, force) = rate_of_momentum(&body.inertia, kinematics, i, angular, linear);
        motions[i] = Motion { angular, linear, moment, force };
    }
    for (i, step) in model.path.iter().enumerate().skip(1).rev().filter(|(i, _)| is_unknown(*i)) {
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
        if step.parent != 0 {
            let parent = &mut motions[step.parent];
            parent.moment += moment + kinematics.offset[i].cross(force);
            parent.force += force;
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
