//! What stays of a state when a model changes.

use signorini_multibody::{Model, State};

use crate::{Compiled, Spec, SpecError};

impl Spec {
    /// The model as it is now, and a state of it that goes on from one of the model before; see [`carry_state`].
    ///
    /// # Errors
    /// As [`compile`](Self::compile).
    ///
    /// # Panics
    /// As [`carry_state`].
    pub fn recompile(&self, old: &Model, state: &State) -> Result<(Compiled, State), SpecError> {
        let compiled = self.compile()?;
        let carried = carry_state(old, state, &compiled.model);
        Ok((compiled, carried))
    }
}

/// A state of a new model in which every joint and every actuator's activation that an old model has by the same name and of the same kind is
/// where it was there; the rest is at its reference, at rest. The time stays.
///
/// - `state`: of `old`
///
/// # Panics
/// If the state is not one of `old` ([`State::check`] says so).
pub fn carry_state(old: &Model, state: &State, new: &Model) -> State {
    let mut out = State::new(new);
    out.time = state.time;
    for joint in &new.joints {
        let same = old.joints.iter().find(|other| other.name == joint.name && other.kind.name() == joint.kind.name());
        if let Some(before) = same {
            let (nq, nv) = (joint.kind.nq(), joint.kind.nv());
            out.q[joint.q_index..joint.q_index + nq].copy_from_slice(&state.q[before.q_index..before.q_index + nq]);
            out.v[joint.v_index..joint.v_index + nv].copy_from_slice(&state.v[before.v_index..before.v_index + nv]);
        }
    }
    for actuator in &new.actuators {
        let same = old.actuators.iter().find(|other| other.name == actuator.name);
        if let (Some(now), Some(before)) = (actuator.activation, same.and_then(|other| other.activation)) {
            out.activation[now.index] = state.activation[before.index];
        }
    }
    out
}
