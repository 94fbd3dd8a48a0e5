//! Activations: what actuators remember from step to step.
//!
//! An actuator with an [`Activation`] `a` hands `a` to its force law in place of its control `u` (cut to its range). The activation
//! follows `u` by the ordinary differential equation of its [`ActivationKind`]; a step moves it from `a` to `a⁺` with the control
//! of the step, as MuJoCo does (its documentation, "Computation", section "Actuation model"):
//!
//! ```text
//! integrator     a⁺ = a + Δt u
//! filter         a⁺ = a + Δt (u − a)/τ
//! exact filter   a⁺ = a + (1 − e^(−Δt/τ)) (u − a)
//! muscle         a⁺ = a + Δt (u − a)/τ(u, a)
//! ```
//!
//! cut to the activation's range. The force of the step is made with `a`, or with `a⁺` where the activation is early. Filters of servos of
//! angles that are the same after a turn go the shorter way round.

use crate::model::{Activation, ActivationKind, Actuator, Model, activation_rate};
use crate::state::{Input, State};

impl Activation {
    /// `a⁺` after `dt` (s) at the control `u`.
    fn after(&self, a: f64, u: f64, dt: f64) -> f64 {
        let moved = match self.kind {
            ActivationKind::Integrator => a + dt * u,
            ActivationKind::Filter { time_constant } => a + dt * (u - a) / time_constant,
            ActivationKind::ExactFilter { time_constant } => a - (-dt / time_constant).exp_m1() * (u - a),
            ActivationKind::Muscle { times, smoothing } => a + dt * activation_rate(a, u, times, smoothing)[0],
        };
        self.range.map_or(moved, |[lower, upper]| moved.clamp(lower, upper))
    }
}

impl Actuator {
    /// What the force law of this actuator, the model's number `index`, takes as its control in a step of length `dt` (s): the
    /// control of the input, or the activation where there is one.
    pub fn drive(&self, state: &State, input: &Input, index: usize, dt: f64) -> f64 {
        match &self.activation {
            None => self.control(input, index),
            Some(activation) if activation.early => self.activation_after(activation, state, input, index, dt),
            Some(activation) => state.activation[activation.index],
        }
    }

    /// The activation at the end of a step.
    fn activation_after(&self, activation: &Activation, state: &State, input: &Input, index: usize, dt: f64) -> f64 {
        let (a, control) = (state.activation[activation.index], self.control(input, index));
        let followed = match activation.kind {
            ActivationKind::Filter { .. } | ActivationKind::ExactFilter { .. } => self.nearest(control, a),
            ActivationKind::Integrator | ActivationKind::Muscle { .. } => control,
        };
        activation.after(a, followed, dt)
    }
}

/// The activations at the end of a step of length `dt` (s) from `state`.
///
/// - `out`: `[na]`; may hold anything before
///
/// # Panics
/// If `state`, `input` or `out` does not fit the model.
pub fn advance_activations_into(model: &Model, state: &State, input: &Input, dt: f64, out: &mut [f64]) {
    for (a, actuator) in model.actuators.iter().enumerate() {
        if let Some(activation) = &actuator.activation {
            out[activation.index] = actuator.activation_after(activation, state, input, a, dt);
        }
    }
}
