//! Accelerations under given forces by the articulated-body algorithm, without the mass matrix.

use glamx::glam::{DMat3, DVec3};

use crate::inverse_dynamics::rate_of_momentum;
use crate::kinematics::Kinematics;
use crate::mass::MassError;
use crate::math::{cross_matrix, outer, scalar};
use crate::model::{BodyId, Inertia, Model};

/// A symmetric 6 × 6 inertia about a body's origin, world axes:
/// `moment = rotational α + coupling a`, `force = couplingᵀ α + translational a`.
#[derive(Clone, Copy, Debug)]
struct ArticulatedInertia {
    rotational: DMat3,
    coupling: DMat3,
    translational: DMat3,
}

impl ArticulatedInertia {
    const ZERO: Self = Self { rotational: DMat3::ZERO, coupling: DMat3::ZERO, translational: DMat3::ZERO };

    fn of_body(inertia: &Inertia, rotation: DMat3) -> Self {
        let c = rotation * inertia.center_of_mass;
        let about_com = rotation * inertia.rotational * rotation.transpose();
        Self {
            rotational: about_com + (scalar(c.length_squared()) - outer(c, c)) * inertia.mass,
            coupling: cross_matrix(c) * inertia.mass,
            translational: scalar(inertia.mass),
        }
    }

    fn times(&self, angular: DVec3, linear: DVec3) -> (DVec3, DVec3) {
        (
            self.rotational * angular + self.coupling * linear,
            self.coupling.mul_transpose_vec3(angular) + self.translational * linear,
        )
    }

    /// Subtracts `u uᵀ / d` with `u = (moment, force)`.
    fn subtract_outer(&mut self, moment: DVec3, force: DVec3, d: f64) {
        self.rotational -= outer(moment, moment / d);
        self.coupling -= outer(moment, force / d);
        self.translational -= outer(force, force / d);
    }

    /// Adds an inertia whose origin is at `r` from this one's: `XᵀIX`.
    fn add_at(&mut self, other: &Self, r: DVec3) {
        let r = cross_matrix(r);
        let coupling = other.coupling + r * other.translational;
        let cross = r * other.coupling.transpose();
        self.rotational += other.rotational + cross + cross.transpose() - r * other.translational * r;
        self.coupling += coupling;
        self.translational += other.translational;
    }
}

/// Storage of the articulated-body algorithm.
#[derive(Clone, Debug)]
pub struct ArticulatedBodies {
    inertia: Vec<ArticulatedInertia>,
    bias_moment: Vec<DVec3>,
    bias_force: Vec<DVec3>,
    angular_acceleration: Vec<DVec3>,
    linear_acceleration: Vec<DVec3>,
    /// `U = I^A S` of every degree of freedom.
    dof_moment: Vec<DVec3>,
    dof_force: Vec<DVec3>,
    /// `D = Sᵀ U` plus armature.
    dof_inertia: Vec<f64>,
    /// `u = τ − Sᵀ p^A`.
    dof_drive: Vec<f64>,
}

impl ArticulatedBodies {
    /// Storage for a model.
    pub fn new(model: &Model) -> Self {
        let (zeros, dof_zeros) = (vec![DVec3::ZERO; model.bodies.len()], vec![DVec3::ZERO; model.nv]);
        Self {
            inertia: vec![ArticulatedInertia::ZERO; model.bodies.len()],
            bias_moment: zeros.clone(),
            bias_force: zeros.clone(),
            angular_acceleration: zeros.clone(),
            linear_acceleration: zeros,
            dof_moment: dof_zeros.clone(),
            dof_force: dof_zeros,
            dof_inertia: vec![0.0; model.nv],
            dof_drive: vec![0.0; model.nv],
        }
    }
}

/// Forward dynamics: the acceleration `v̇ = M⁻¹(τ − h)`, with gravity and armature; joint springs, damping, limits and
/// friction are not part of it.
///
/// - `kinematics`: from [`forward_kinematics_into`](crate::forward_kinematics_into) at the same `(q, v)`
/// - `tau`: `τ`, `[nv]`, N, N·m
/// - `acceleration`: out, `v̇`, `[nv]`
///
/// # Errors
/// [`MassError::NotPositiveDefinite`] with the degree of freedom that moves nothing.
///
/// # Panics
/// If a length does not fit the model.
///
/// # Cost
/// O(bodies + dofs), no allocation.
///
/// # Source
/// Featherstone (2008), ch. 7.3; joints of several degrees of freedom are eliminated one degree of freedom at a time.
pub fn forward_dynamics_into(
    model: &Model,
    kinematics: &Kinematics,
    tau: &[f64],
    work: &mut ArticulatedBodies,
    acceleration: &mut [f64],
) -> Result<(), MassError> {
    assert!(tau.len() == model.nv && acceleration.len() == model.nv, "lengths must be nv");
    for i in 1..model.bodies.len() {
        let inertia = &model.bodies[i].inertia;
        work.inertia[i] = ArticulatedInertia::of_body(inertia, kinematics.rotation[i]);
        (work.bias_moment[i], work.bias_force[i]) = rate_of_momentum(inertia, kinematics, i, DVec3::ZERO, DVec3::ZERO);
    }
    for i in (1..model.bodies.len()).rev() {
        eliminate_joints(model, kinematics, i, tau, work)?;
        let parent = model.bodies[i].parent.index();
        if parent != 0 {
            hand_to_parent(kinematics, i, parent, work);
        }
    }
    work.linear_acceleration[0] = -model.gravity;
    for i in 1..model.bodies.len() {
        accelerate(model, kinematics, i, work, acceleration);
    }
    Ok(())
}

/// Eliminates the degrees of freedom of body `i` from its articulated inertia and bias force, last one first.
fn eliminate_joints(
    model: &Model,
    kinematics: &Kinematics,
    i: usize,
    tau: &[f64],
    work: &mut ArticulatedBodies,
) -> Result<(), MassError> {
    for k in model.dofs_of(BodyId(i as u32)).rev() {
        let (angular, linear) = (kinematics.dof_angular[k], kinematics.dof_linear[k]);
        let (moment, force) = work.inertia[i].times(angular, linear);
        let d = angular.dot(moment) + linear.dot(force) + model.joints[model.dof_joint[k].index()].armature;
        if !(d > 0.0 && d.is_finite()) {
            return Err(MassError::NotPositiveDefinite { dof: k, pivot: d });
        }
        let u = tau[k] - angular.dot(work.bias_moment[i]) - linear.dot(work.bias_force[i]);
        work.inertia[i].subtract_outer(moment, force, d);
        work.bias_moment[i] += moment * (u / d);
        work.bias_force[i] += force * (u / d);
        (work.dof_moment[k], work.dof_force[k]) = (moment, force);
        (work.dof_inertia[k], work.dof_drive[k]) = (d, u);
    }
    Ok(())
}

/// Adds what is left of body `i` to its parent; the velocity-product acceleration across the joints acts on it first.
fn hand_to_parent(kinematics: &Kinematics, i: usize, parent: usize, work: &mut ArticulatedBodies) {
    let inertia = work.inertia[i];
    let (moment, force) = inertia.times(kinematics.bias_angular[i], kinematics.bias_linear[i]);
    let (moment, force) = (work.bias_moment[i] + moment, work.bias_force[i] + force);
    let r = kinematics.offset[i];
    work.inertia[parent].add_at(&inertia, r);
    work.bias_moment[parent] += moment + r.cross(force);
    work.bias_force[parent] += force;
}

/// Accelerations of the degrees of freedom of body `i` and of the body, from its parent's.
fn accelerate(
    model: &Model,
    kinematics: &Kinematics,
    i: usize,
    work: &mut ArticulatedBodies,
    acceleration: &mut [f64],
) {
    let parent = model.bodies[i].parent.index();
    let mut angular = work.angular_acceleration[parent] + kinematics.bias_angular[i];
    let mut linear = work.linear_acceleration[parent]
        + work.angular_acceleration[parent].cross(kinematics.offset[i])
        + kinematics.bias_linear[i];
    for k in model.dofs_of(BodyId(i as u32)) {
        let carried = work.dof_moment[k].dot(angular) + work.dof_force[k].dot(linear);
        acceleration[k] = (work.dof_drive[k] - carried) / work.dof_inertia[k];
        angular += kinematics.dof_angular[k] * acceleration[k];
        linear += kinematics.dof_linear[k] * acceleration[k];
    }
    (work.angular_acceleration[i], work.linear_acceleration[i]) = (angular, linear);
}
