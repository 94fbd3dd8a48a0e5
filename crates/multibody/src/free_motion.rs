//! The motion of a step without contact: effective mass matrix and free velocity.
//!
//! Springs, dampers and servos are taken linearly implicitly, so that stiff ones are stable at any step. With
//! `q⁺ = q + Δt v⁺` in the spring terms, the step without contact is
//!
//! ```text
//! M (v⁺ − v) = Δt (τ − h + f_e − D v⁺ − K (q + Δt v⁺ − q_r))
//! ```
//!
//! where `D` and `K` are diagonal: joint damping and stiffness plus the gains of the servos, through their gears. Moving
//! the terms in `v⁺ − v` to the left gives
//!
//! ```text
//! M̂ (v⁺ − v) = Δt (τ − h + f_e − D v − K (q + Δt v − q_r)),   M̂ = M + Δt D + Δt² K.
//! ```
//!
//! `M̂` and the `v⁺` of this equation are what the contact problem takes as its `M` and `v^f`: impulses then act on the
//! implicit springs too. `M` and `h` are those of the beginning of the step (formulation §1, §6), except for the
//! gyroscopic torque of bodies that turn freely, which is that of a variational integrator (`free_rotation.rs`): it differs
//! from the explicit one by O(Δt²) and does not feed energy to a tumbling body.
//!
//! An actuator whose force at the end of the step would leave its range is held at the end of the range instead, as a
//! constant force `f_e` with no share in `D` and `K`, and the step is solved again. For one actuator this is the exact
//! solution of the implicit step with the clamped law, because its force falls monotonically with `v⁺`.

use glamx::glam::DVec3;

use crate::cholesky::BlockCholesky;
use crate::composite::{MassMatrix, mass_matrix_into};
use crate::free_rotation::FreeRotation;
use crate::inverse_dynamics::{NewtonEuler, bias_force_into};
use crate::kinematics::Kinematics;
use crate::mass::MassError;
use crate::model::{Actuator, ActuatorKind, Joint, JointKind, Model};
use crate::state::{Input, State, StateError};

/// Why there is no free motion.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FreeMotionError {
    /// The state or the input does not fit the model.
    #[error(transparent)]
    State(#[from] StateError),
    /// The mass matrix is singular.
    #[error(transparent)]
    Mass(#[from] MassError),
}

/// What [`free_motion_into`] computes, and the storage it needs.
#[derive(Clone, Debug)]
pub struct FreeMotion {
    /// `M̂ = M + Δt D + Δt² K`.
    pub mass: MassMatrix,
    /// Factor of `M̂`.
    pub factor: BlockCholesky,
    /// `h(q, v)`, `[nv]`, N, N·m.
    pub bias: Vec<f64>,
    /// `v^f`, `[nv]`, m/s, rad/s.
    pub free_velocity: Vec<f64>,
    /// Force of every actuator at the end of the step without contact, before the gear, N or N·m.
    pub actuator_force: Vec<f64>,
    /// Which end of its force range an actuator is held at, if any.
    pub saturation: Vec<Saturation>,
    /// Number of freely turning bodies that turn too fast for Δt (about half a turn in a step) for their gyroscopic
    /// torque to be integrated; it was left out for them.
    pub unresolved_rotations: usize,
    free_rotations: Vec<FreeRotation>,
    newton_euler: NewtonEuler,
    /// Diagonal of `M`, to which the implicit terms are added anew when an actuator saturates.
    diagonal: Vec<f64>,
    /// `Δt (τ − h)` with the gyroscopic impulse of the variational integrator.
    impulse: Vec<f64>,
    rhs: Vec<f64>,
}

/// Whether an actuator is at an end of its force range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Saturation {
    /// Within its range.
    Within,
    /// Held at the lower end.
    Lower,
    /// Held at the upper end.
    Upper,
}

impl FreeMotion {
    /// Storage for a model.
    pub fn new(model: &Model) -> Self {
        let mass = MassMatrix::new(model);
        Self {
            factor: BlockCholesky::new(&mass.matrix),
            mass,
            bias: vec![0.0; model.nv],
            free_velocity: vec![0.0; model.nv],
            actuator_force: vec![0.0; model.actuators.len()],
            saturation: vec![Saturation::Within; model.actuators.len()],
            unresolved_rotations: 0,
            free_rotations: FreeRotation::all(model),
            newton_euler: NewtonEuler::new(model),
            diagonal: vec![0.0; model.nv],
            impulse: vec![0.0; model.nv],
            rhs: vec![0.0; model.nv],
        }
    }
}

/// Effective mass matrix and free velocity of a step of length Δt (the scheme is derived at the top of this module).
///
/// Joint limits, joint friction and servos of speed ([`ActuatorKind::Speed`]) are not forces; they are rows of the contact problem.
/// The force of a servo of speed is here the middle of its range.
/// - `kinematics`: from [`forward_kinematics_into`](crate::forward_kinematics_into) at the state
/// - `dt`: Δt > 0, s
/// - `out`: see [`FreeMotion`]
///
/// # Errors
/// [`FreeMotionError::State`] if the state or input has a wrong length or a number that is not finite or Δt is not
/// positive; [`FreeMotionError::Mass`] if `M̂` is not positive definite.
///
/// # Cost
/// One factorisation, and one more each time an actuator runs into its range; no allocation.
pub fn free_motion_into(
    model: &Model,
    kinematics: &Kinematics,
    state: &State,
    input: &Input,
    dt: f64,
    out: &mut FreeMotion,
) -> Result<(), FreeMotionError> {
    state.check(model)?;
    input.check(model)?;
    if !(dt > 0.0 && dt.is_finite()) {
        return Err(StateError::InvalidTimeStep { found: dt }.into());
    }
    bias_force_into(model, kinematics, &mut out.newton_euler, &mut out.bias);
    mass_matrix_into(model, kinematics, &mut out.mass);
    for k in 0..model.nv {
        out.diagonal[k] = out.mass.matrix.get(k, k);
    }
    smooth_impulse(kinematics, state, input, dt, out);
    out.saturation.fill(Saturation::Within);
    loop {
        assemble(model, state, input, dt, out);
        out.factor.refactor(&out.mass.matrix)?;
        out.free_velocity.copy_from_slice(&out.rhs);
        out.factor.solve_in_place(&mut out.free_velocity);
        for (v_free, v) in out.free_velocity.iter_mut().zip(&state.v) {
            *v_free += v;
        }
        if !saturate(model, state, input, dt, out) {
            return Ok(());
        }
    }
}

/// The impulse of applied forces and `h`, with the gyroscopic part of freely turning bodies exchanged.
fn smooth_impulse(kinematics: &Kinematics, state: &State, input: &Input, dt: f64, out: &mut FreeMotion) {
    for (k, impulse) in out.impulse.iter_mut().enumerate() {
        *impulse = dt * (input.generalized_force.get(k).unwrap_or(&0.0) - out.bias[k]);
    }
    out.unresolved_rotations = 0;
    for body in &out.free_rotations {
        let mut add = |first: usize, x: DVec3| (0..3).for_each(|a| out.impulse[first + a] += x[a]);
        let correction = body.correction(kinematics, &state.v, dt);
        let (translation, rotation) = body.dofs();
        add(rotation, correction.angular);
        if let Some(first) = translation {
            add(first, correction.linear);
        }
        out.unresolved_rotations += usize::from(!correction.resolved);
    }
}

/// `M̂` and the right-hand side for the present saturations.
fn assemble(model: &Model, state: &State, input: &Input, dt: f64, out: &mut FreeMotion) {
    for k in 0..model.nv {
        out.mass.matrix.set(k, k, out.diagonal[k]);
    }
    out.rhs.copy_from_slice(&out.impulse);
    for joint in &model.joints {
        if joint.damping != 0.0 || joint.stiffness != 0.0 {
            for k in joint.v_index..joint.v_index + joint.kind.nv() {
                add_implicit(joint_spring(joint, state), k, state, dt, out);
            }
        }
    }
    for (a, actuator) in model.actuators.iter().enumerate() {
        let joint = &model.joints[actuator.joint.index()];
        let law = match (out.saturation[a], actuator.force_range) {
            (Saturation::Lower, Some([lower, _])) => AffineForce::constant(lower),
            (Saturation::Upper, Some([_, upper])) => AffineForce::constant(upper),
            _ => actuator_law(actuator, joint, actuator.control(input, a), state),
        };
        add_implicit(law.through_gear(actuator.gear), joint.v_index, state, dt, out);
    }
}

/// A force `value − stiffness (q⁺ − q) − damping v⁺` of the end of a step, with `value` that at the step's
/// configuration and no velocity.
#[derive(Clone, Copy, Debug)]
struct AffineForce {
    value: f64,
    stiffness: f64,
    damping: f64,
}

impl AffineForce {
    fn constant(value: f64) -> Self {
        Self { value, stiffness: 0.0, damping: 0.0 }
    }

    /// The joint force of an actuator force.
    fn through_gear(self, gear: f64) -> Self {
        let Self { value, stiffness, damping } = self;
        Self { value: gear * value, stiffness: gear * stiffness, damping: gear * damping }
    }

    /// The force at the end of a step of length `dt` with velocity `v`.
    fn at(self, v: f64, dt: f64) -> f64 {
        self.value - (self.damping + dt * self.stiffness) * v
    }
}

fn add_implicit(force: AffineForce, k: usize, state: &State, dt: f64, out: &mut FreeMotion) {
    out.mass.matrix.add_to_diagonal(k, dt * (force.damping + dt * force.stiffness));
    out.rhs[k] += dt * force.at(state.v[k], dt);
}

/// The spring and damper of a joint.
fn joint_spring(joint: &Joint, state: &State) -> AffineForce {
    let stretch = match joint.kind {
        JointKind::Hinge { .. } | JointKind::Slide { .. } => state.q[joint.q_index] - joint.spring_reference,
        JointKind::Ball | JointKind::Free => 0.0,
    };
    AffineForce { value: -joint.stiffness * stretch, stiffness: joint.stiffness, damping: joint.damping }
}

/// The force of an actuator as a function of its joint's motion, before the gear.
fn actuator_law(actuator: &Actuator, joint: &Joint, control: f64, state: &State) -> AffineForce {
    let gear = actuator.gear;
    match actuator.kind {
        ActuatorKind::Motor => {
            let [lower, upper] = actuator.force_range.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
            AffineForce::constant(control.clamp(lower, upper))
        }
        ActuatorKind::Position { kp, kv } => {
            let value = kp * (control - gear * state.q[joint.q_index]);
            AffineForce { value, stiffness: gear * kp, damping: gear * kv }
        }
        // Its row of the contact problem adds up to half the range in either direction.
        ActuatorKind::Speed => {
            AffineForce::constant(actuator.force_range.map_or(0.0, |[lower, upper]| (lower + upper) / 2.0))
        }
        ActuatorKind::Velocity { kv } => AffineForce { value: kv * control, stiffness: 0.0, damping: gear * kv },
    }
}

/// Stores the actuator forces at the end of the step and holds those that would leave their range at its end; whether
/// there is a new one. An actuator that is held stays held, so this ends after at most one round per actuator.
fn saturate(model: &Model, state: &State, input: &Input, dt: f64, out: &mut FreeMotion) -> bool {
    let mut changed = false;
    for (a, actuator) in model.actuators.iter().enumerate() {
        let [lower, upper] = actuator.force_range.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        out.actuator_force[a] = match out.saturation[a] {
            Saturation::Lower => lower,
            Saturation::Upper => upper,
            Saturation::Within => {
                let joint = &model.joints[actuator.joint.index()];
                let law = actuator_law(actuator, joint, actuator.control(input, a), state);
                let force = law.at(out.free_velocity[joint.v_index], dt);
                if force < lower || force > upper {
                    out.saturation[a] = if force < lower { Saturation::Lower } else { Saturation::Upper };
                    changed = true;
                }
                force
            }
        };
    }
    changed
}
