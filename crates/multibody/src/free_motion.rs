//! The motion of a step without contact: effective mass matrix and free velocity.
//!
//! Dampers and servos are taken linearly implicitly, so that stiff ones are stable at any step; springs by the mean of their force
//! at the configurations before and after, so that they are stable at any step and keep their energy. With `q⁺ = q + Δt v⁺` and
//! `q⁻ = q − Δt v` the step without contact is
//!
//! ```text
//! M (v⁺ − v) = Δt (τ − h + f_e − D v⁺ − S (q⁺ − q_r) − K ((q⁻ + q⁺)/2 − q_s))
//! ```
//!
//! where `D`, `S` and `K` hold the damping of joints, the stiffness of servos and that of springs on their diagonals and, for every
//! tendon and actuator with length `l(q)`, its gains times `∇l ∇lᵀ`. Where two degrees of freedom of a length are not on one path to
//! the root, the entry that would couple them is left out and its absolute value added to both diagonal entries: the factor keeps its
//! zeros, the step is still consistent to first order, and what is added is positive semidefinite, so that stiff ones stay stable.
//! Moving the terms in `v⁺ − v` to the left gives
//!
//! ```text
//! M̂ (v⁺ − v) = Δt (τ − h + f_e − D v − S (q + Δt v − q_r) − K (q − q_s)),   M̂ = M + Δt D + Δt² S + ½ Δt² K.
//! ```
//!
//! The springs' part is Newmark's rule with β = γ = 1/2 (N. M. Newmark, "A method of computation for structural dynamics", J. Eng.
//! Mech. Div. ASCE 85 (1959), eqs. 1–2). With constant `M` and the potential `U(q) = ½ (q − q_s)ᵀ K (q − q_s)`
//!
//! ```text
//! E = ½ vᵀ M v + ½ (U(q⁻) + U(q))
//! ```
//!
//! changes in a step by exactly the work of all other forces and impulses on the mean velocity `(v + v⁺)/2`, whatever Δt: put the
//! equation for `M (v⁺ − v)` into `½ (v⁺ + v)ᵀ M (v⁺ − v)`, and use `q⁺ − q⁻ = Δt (v + v⁺)`.
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

use crate::actuator_length::actuator_length_into;
use crate::applied::applied_force_into;
use crate::cholesky::BlockCholesky;
use crate::composite::{MassMatrix, mass_matrix_of};
use crate::coriolis::CoriolisSystem;
use crate::free_rotation::FreeRotation;
use crate::implicit::ImplicitLengths;
use crate::inverse_dynamics::{NewtonEuler, bias_force_of};
use crate::jacobian::point_column;
use crate::kinematics::Kinematics;
use crate::length::LengthRow;
use crate::mass::{BlockDiagonal, MassError};
use crate::model::{Actuator, ActuatorKind, BodyId, Joint, JointKind, Model, Tendon, Transmission};
use crate::standing::{Known, Nothing, StandingTrees};
use crate::state::{Input, State, StateError};
use crate::tendon::tendon_length_into;

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
    /// Generalized force of the input, its wrenches included, `[nv]`, N, N·m.
    pub applied_force: Vec<f64>,
    pub(crate) free_rotations: Vec<FreeRotation>,
    pub(crate) coriolis: CoriolisSystem,
    newton_euler: NewtonEuler,
    /// `M`, to which the implicit terms are added anew when an actuator saturates; kept only where one can.
    rigid: BlockDiagonal,
    can_saturate: bool,
    /// `Δt (τ − h)` with gravity compensation and the gyroscopic impulse of the variational integrator.
    impulse: Vec<f64>,
    rhs: Vec<f64>,
    /// Length of every actuator, gear included.
    pub(crate) actuator_rows: Vec<LengthRow>,
    /// Force of every actuator as it acts in the step.
    pub(crate) laws: Vec<AffineForce>,
    pub(crate) tendon_rows: Vec<LengthRow>,
    lengths: ImplicitLengths,
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
        let free_rotations = FreeRotation::all(model);
        let mut apart = vec![false; model.nv];
        for body in &free_rotations {
            let (translation, rotation) = body.dofs();
            apart[translation.unwrap_or(rotation)..rotation + 3].fill(true);
        }
        Self {
            coriolis: CoriolisSystem::new(model, &mass.matrix, |k| apart[k]),
            factor: BlockCholesky::new(&mass.matrix),
            rigid: mass.matrix.clone(),
            can_saturate: model.actuators.iter().any(can_saturate),
            mass,
            bias: vec![0.0; model.nv],
            free_velocity: vec![0.0; model.nv],
            actuator_force: vec![0.0; model.actuators.len()],
            saturation: vec![Saturation::Within; model.actuators.len()],
            unresolved_rotations: 0,
            applied_force: vec![0.0; model.nv],
            free_rotations,
            newton_euler: NewtonEuler::new(model),
            impulse: vec![0.0; model.nv],
            rhs: vec![0.0; model.nv],
            actuator_rows: vec![LengthRow::new(model); model.actuators.len()],
            laws: vec![AffineForce::constant(0.0); model.actuators.len()],
            tendon_rows: vec![LengthRow::new(model); model.tendons.len()],
            lengths: ImplicitLengths::new(model),
        }
    }

    /// Length of actuator `a` at the beginning of the step, gear included, with its row.
    pub fn actuator_length(&self, a: usize) -> &LengthRow {
        &self.actuator_rows[a]
    }

    /// Whether trees turn, so that Coriolis forces depend on the velocity at the end of the motion without contact, and a force acts on them, too.
    pub fn turns(&self) -> bool {
        self.coriolis.is_turning()
    }

    /// Force of actuator `a` at the end of a step of length `dt` (s) that ends with velocity `v`, `[nv]`, before the gear.
    pub fn actuator_force_at(&self, a: usize, v: &[f64], dt: f64) -> f64 {
        let rate = self.actuator_rows[a].rate(v);
        self.laws[a].at(rate, rate, dt)
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
    free_motion_of(model, kinematics, state, input, dt, Nothing, out)
}

/// [`free_motion_into`] where some trees stand as `out` has them, and on a state that [is checked](State::check).
///
/// # Errors
/// As there.
///
/// # Panics
/// If the state is not one of the model, or `standing` is of another one.
pub fn free_motion_beside(
    model: &Model,
    kinematics: &Kinematics,
    state: &State,
    input: &Input,
    dt: f64,
    standing: &StandingTrees,
    out: &mut FreeMotion,
) -> Result<(), FreeMotionError> {
    free_motion_of(model, kinematics, state, input, dt, standing, out)
}

fn free_motion_of(
    model: &Model,
    kinematics: &Kinematics,
    state: &State,
    input: &Input,
    dt: f64,
    known: impl Known,
    out: &mut FreeMotion,
) -> Result<(), FreeMotionError> {
    input.check(model)?;
    if !(dt > 0.0 && dt.is_finite()) {
        return Err(StateError::InvalidTimeStep { found: dt }.into());
    }
    bias_force_of(model, kinematics, known, &mut out.newton_euler, &mut out.bias);
    mass_matrix_of(model, kinematics, known, &mut out.mass);
    if out.can_saturate {
        out.rigid.copy_from(&out.mass.matrix);
    }
    measure_lengths(model, kinematics, state, out);
    smooth_impulse(model, kinematics, state, input, dt, out);
    out.coriolis.set(model, (kinematics, &out.mass.placed), &state.v, dt, known);
    out.saturation.fill(Saturation::Within);
    loop {
        assemble(model, state, input, dt, known, out);
        out.factor.refactor_of(&out.mass.matrix, known)?;
        let turns = |block| out.coriolis.has_block(block);
        out.factor.solve_and_add_of(known, turns, &out.rhs, &state.v, &mut out.free_velocity);
        out.coriolis.advance((&out.mass.matrix, &out.factor), &out.rhs, &state.v, &mut out.free_velocity);
        if !saturate(model, dt, out) {
            out.unresolved_rotations += out.coriolis.unresolved();
            return Ok(());
        }
        out.mass.matrix.copy_from(&out.rigid);
    }
}

/// Lengths of all tendons and actuators; an actuator along a tendon takes over what is known of that.
fn measure_lengths(model: &Model, kinematics: &Kinematics, state: &State, out: &mut FreeMotion) {
    for (tendon, row) in model.tendons.iter().zip(&mut out.tendon_rows) {
        tendon_length_into(model, kinematics, &state.q, tendon, row);
    }
    for (actuator, row) in model.actuators.iter().zip(&mut out.actuator_rows) {
        if let Transmission::Tendon(tendon) = actuator.transmission {
            row.clone_from(&out.tendon_rows[tendon.index()]);
            row.scale(actuator.gear);
        } else {
            actuator_length_into(model, kinematics, &state.q, actuator, row);
        }
    }
}

/// The impulse of applied forces, gravity compensation and `h`, with the gyroscopic part of freely turning bodies exchanged.
fn smooth_impulse(model: &Model, kinematics: &Kinematics, state: &State, input: &Input, dt: f64, out: &mut FreeMotion) {
    applied_force_into(model, kinematics, input, &mut out.applied_force);
    for ((impulse, applied), bias) in out.impulse.iter_mut().zip(&out.applied_force).zip(&out.bias) {
        *impulse = dt * (applied - bias);
    }
    compensate_gravity(model, kinematics, dt, &mut out.impulse);
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

/// The right-hand side and, added to `M`, the implicit terms, for the present saturations.
fn assemble(model: &Model, state: &State, input: &Input, dt: f64, known: impl Known, out: &mut FreeMotion) {
    out.rhs.copy_from_slice(&out.impulse);
    for joint in model.joints.iter().filter(|joint| !known.has_dof(joint.v_index)) {
        if joint.damping != 0.0 || joint.stiffness != 0.0 {
            let force = joint_spring(joint, state);
            for k in joint.v_index..joint.v_index + joint.kind.nv() {
                out.mass.matrix.add_to_diagonal(k, dt * force.slope(dt));
                out.rhs[k] += dt * force.at(state.v[k], state.v[k], dt);
            }
        }
    }
    for (tendon, row) in model.tendons.iter().zip(&out.tendon_rows) {
        let parts = tendon_spring(tendon, row.length).parts(row.rate(&state.v), dt);
        out.lengths.add(model, parts, row, &mut out.mass.matrix, &mut out.rhs);
    }
    for (a, actuator) in model.actuators.iter().enumerate() {
        let row = &out.actuator_rows[a];
        let rate = row.rate(&state.v);
        out.laws[a] = match (out.saturation[a], actuator.force_range) {
            (Saturation::Lower, Some([lower, _])) => AffineForce::constant(lower),
            (Saturation::Upper, Some([_, upper])) => AffineForce::constant(upper),
            _ => actuator_law(actuator, actuator.drive(state, input, a, dt), row.length, rate),
        };
        out.lengths.add(model, out.laws[a].parts(rate, dt), row, &mut out.mass.matrix, &mut out.rhs);
    }
    out.lengths.finish(&mut out.mass.matrix);
}

/// The forces that hold up bodies with gravity compensation, at their centres of mass.
fn compensate_gravity(model: &Model, kinematics: &Kinematics, dt: f64, rhs: &mut [f64]) {
    for (i, body) in model.bodies.iter().enumerate().filter(|(_, body)| body.gravity_compensation != 0.0) {
        let force = model.gravity * (-body.gravity_compensation * body.inertia.mass);
        for k in model.dofs_moving(BodyId(i as u32)) {
            rhs[k] += dt * force.dot(point_column(model, kinematics, k, kinematics.center_of_mass[i]));
        }
    }
}

/// A force `value − stiffness (q⁺ − q) − damping v⁺ − ½ elasticity Δt (v⁺ − v)` that acts during a step, with `value` that at the step's
/// configuration and no velocity. For joints, tendons and actuators `q` and `v` stand for the length and its rate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AffineForce {
    pub value: f64,
    pub stiffness: f64,
    pub damping: f64,
    pub elasticity: f64,
}

impl AffineForce {
    fn constant(value: f64) -> Self {
        Self { value, stiffness: 0.0, damping: 0.0, elasticity: 0.0 }
    }

    /// The impulse of a step of length `dt` in which the velocity stays `v`, and by how much it falls per unit of velocity at the end.
    fn parts(self, v: f64, dt: f64) -> (f64, f64) {
        (dt * self.at(v, v, dt), dt * self.slope(dt))
    }

    /// Fall of the force of a step of length `dt` per unit of velocity at its end.
    pub fn slope(self, dt: f64) -> f64 {
        self.damping + dt * self.stiffness + self.rise(dt)
    }

    /// Rise of the force of a step of length `dt` per unit of velocity at its beginning.
    pub fn rise(self, dt: f64) -> f64 {
        0.5 * dt * self.elasticity
    }

    /// The force of a step of length `dt` that begins with velocity `v` and ends with `end`.
    pub fn at(self, v: f64, end: f64, dt: f64) -> f64 {
        self.value - self.slope(dt) * end + self.rise(dt) * v
    }
}

/// Whether degree of freedom `first` is on the way from `second` to the root.
pub(crate) fn is_before(model: &Model, first: usize, second: usize) -> bool {
    std::iter::successors(Some(second), |&k| model.dof_parent[k]).take_while(|&k| k >= first).any(|k| k == first)
}

/// The spring and damper of a joint.
pub(crate) fn joint_spring(joint: &Joint, state: &State) -> AffineForce {
    let stretch = match joint.kind {
        JointKind::Hinge { .. } | JointKind::Slide { .. } => state.q[joint.q_index] - joint.spring_reference,
        JointKind::Ball | JointKind::Free => 0.0,
    };
    AffineForce {
        value: -joint.stiffness * stretch,
        stiffness: 0.0,
        damping: joint.damping,
        elasticity: joint.stiffness,
    }
}

/// The spring and damper of a tendon.
pub(crate) fn tendon_spring(tendon: &Tendon, length: f64) -> AffineForce {
    let stretch = tendon.stretch(length);
    // A spring with one length at rest is none that is slack there, as models are where they begin.
    let is_slack = stretch == 0.0 && tendon.rest[0] < tendon.rest[1];
    let elasticity = if is_slack { 0.0 } else { tendon.stiffness };
    AffineForce { value: -tendon.stiffness * stretch, stiffness: 0.0, damping: tendon.damping, elasticity }
}

/// The force of an actuator as a function of its length and rate, before the gear; `control` may be its activation.
pub(crate) fn actuator_law(actuator: &Actuator, control: f64, length: f64, rate: f64) -> AffineForce {
    let control = actuator.nearest(control, length);
    match actuator.kind {
        ActuatorKind::Motor => {
            let [lower, upper] = actuator.force_range.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
            AffineForce::constant(control.clamp(lower, upper))
        }
        ActuatorKind::Position { kp, kv } => {
            AffineForce { stiffness: kp, damping: kv, ..AffineForce::constant(kp * (control - length)) }
        }
        ActuatorKind::Velocity { kv } => AffineForce { damping: kv, ..AffineForce::constant(kv * control) },
        ActuatorKind::Affine { gain, bias } => {
            let [constant, by_length, by_rate] = [0, 1, 2].map(|k| gain[k] * control + bias[k]);
            // What grows with length or rate would take stiffness or damping away from the matrix: it is explicit.
            let value = constant + by_length * length + by_rate.max(0.0) * rate;
            AffineForce {
                stiffness: (-by_length).max(0.0),
                damping: (-by_rate).max(0.0),
                ..AffineForce::constant(value)
            }
        }
        ActuatorKind::Muscle(muscle) => {
            let [force, by_length, by_rate, _] = muscle.force_with_slopes(control, length, rate);
            let damping = (-by_rate).max(0.0);
            AffineForce { value: force + damping * rate, stiffness: (-by_length).max(0.0), damping, elasticity: 0.0 }
        }
        // Its row of the contact problem adds up to half the range in either direction.
        ActuatorKind::Speed => {
            AffineForce::constant(actuator.force_range.map_or(0.0, |[lower, upper]| (lower + upper) / 2.0))
        }
    }
}

/// Whether the force of an actuator changes during a step and has a range that it can leave.
pub(crate) fn can_saturate(actuator: &Actuator) -> bool {
    actuator.force_range.is_some() && !matches!(actuator.kind, ActuatorKind::Motor | ActuatorKind::Speed)
}

/// Stores the actuator forces at the end of the step and holds those that would leave their range at its end; whether
/// there is a new one. An actuator that is held stays held, so this ends after at most one round per actuator.
fn saturate(model: &Model, dt: f64, out: &mut FreeMotion) -> bool {
    let mut changed = false;
    for (a, actuator) in model.actuators.iter().enumerate() {
        let force = out.actuator_force_at(a, &out.free_velocity, dt);
        out.actuator_force[a] = force;
        let [lower, upper] = actuator.force_range.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        let within = out.saturation[a] == Saturation::Within && can_saturate(actuator);
        if within && (force < lower || force > upper) {
            out.saturation[a] = if force < lower { Saturation::Lower } else { Saturation::Upper };
            changed = true;
        }
    }
    changed
}
