//! Generalized forces of a motion by the recursive Newton–Euler algorithm.

use glamx::glam::DVec3;

use crate::kinematics::Kinematics;
use crate::model::{BodyId, Inertia, Model};

/// Storage of the recursive Newton–Euler algorithm: one entry per body, world axes, about the body's origin.
#[derive(Clone, Debug)]
pub struct NewtonEuler {
    angular_acceleration: Vec<DVec3>,
    linear_acceleration: Vec<DVec3>,
    moment: Vec<DVec3>,
    force: Vec<DVec3>,
}

impl NewtonEuler {
    /// Storage for a model.
    pub fn new(model: &Model) -> Self {
        let zeros = vec![DVec3::ZERO; model.bodies.len()];
        Self {
            angular_acceleration: zeros.clone(),
            linear_acceleration: zeros.clone(),
            moment: zeros.clone(),
            force: zeros,
        }
    }

    /// Angular acceleration of a body and the acceleration of its origin less gravity, world axes, rad/s² and m/s², of the
    /// last motion given to [`inverse_dynamics_into`].
    pub fn acceleration(&self, body: BodyId) -> (DVec3, DVec3) {
        (self.angular_acceleration[body.index()], self.linear_acceleration[body.index()])
    }

    /// Moment about a body's origin and force, world axes, N·m and N, that the last motion given to
    /// [`inverse_dynamics_into`] takes for the body with all that hangs on it. Less what acts from outside, this is how
    /// its parent holds it. Zero for the world.
    pub fn wrench(&self, body: BodyId) -> (DVec3, DVec3) {
        (self.moment[body.index()], self.force[body.index()])
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
    newton_euler(model, kinematics, |k| acceleration[k], work, tau);
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
    assert_eq!(h.len(), model.nv, "length must be nv");
    newton_euler(model, kinematics, |_| 0.0, work, h);
}

fn newton_euler(
    model: &Model,
    kinematics: &Kinematics,
    acceleration: impl Fn(usize) -> f64,
    work: &mut NewtonEuler,
    tau: &mut [f64],
) {
    work.linear_acceleration[0] = -model.gravity;
    for i in 1..model.bodies.len() {
        let body = &model.bodies[i];
        let parent = body.parent.index();
        let mut angular = work.angular_acceleration[parent] + kinematics.bias_angular[i];
        let mut linear = work.linear_acceleration[parent]
            + work.angular_acceleration[parent].cross(kinematics.offset[i])
            + kinematics.bias_linear[i];
        for k in model.dofs_of(BodyId(i as u32)) {
            angular += kinematics.dof_angular[k] * acceleration(k);
            linear += kinematics.dof_linear[k] * acceleration(k);
        }
        (work.angular_acceleration[i], work.linear_acceleration[i]) = (angular, linear);
        (work.moment[i], work.force[i]) = rate_of_momentum(&body.inertia, kinematics, i, angular, linear);
    }
    for i in (1..model.bodies.len()).rev() {
        let (moment, force) = (work.moment[i], work.force[i]);
        for k in model.dofs_of(BodyId(i as u32)) {
            tau[k] = kinematics.dof_angular[k].dot(moment) + kinematics.dof_linear[k].dot(force);
        }
        let parent = model.bodies[i].parent.index();
        if parent != 0 {
            work.moment[parent] += moment + kinematics.offset[i].cross(force);
            work.force[parent] += force;
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
    let c = rotation * inertia.center_of_mass;
    let force = (linear + angular.cross(c) + velocity.cross(velocity.cross(c))) * inertia.mass;
    let (angular_b, velocity_b) = (rotation.mul_transpose_vec3(angular), rotation.mul_transpose_vec3(velocity));
    let spin = inertia.rotational * angular_b + velocity_b.cross(inertia.rotational * velocity_b);
    (rotation * spin + c.cross(force), force)
}
