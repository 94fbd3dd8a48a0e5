//! Kinematics of the state at which the next step may begin, for questions between two steps.

use signorini_multibody::{Input, Kinematics, Model, State, forward_kinematics_into};

use crate::rest::same_bits;

/// Kinematics, and the state that they are of.
#[derive(Clone, Debug)]
pub(crate) struct Ahead {
    pub kinematics: Kinematics,
    /// Whether they are of the state below. Of models whose bodies are moved from outside that is not known.
    holds: bool,
    q: Vec<f64>,
    v: Vec<f64>,
}

impl Ahead {
    pub fn new(model: &Model) -> Self {
        Self { kinematics: Kinematics::new(model), holds: false, q: vec![0.0; model.nq], v: vec![0.0; model.nv] }
    }

    /// Takes the kinematics for those of no state.
    pub fn forget(&mut self) {
        self.holds = false;
    }

    /// Finds the kinematics of a state, if they are not there.
    pub fn look(&mut self, model: &Model, state: &State, input: &Input) {
        if self.are_of(state) {
            return;
        }
        self.kinematics.place_mocap(model, input);
        forward_kinematics_into(model, &state.q, &state.v, &mut self.kinematics);
        self.holds = model.mocap_bodies.is_empty();
        self.q.clone_from(&state.q);
        self.v.clone_from(&state.v);
    }

    /// Gives away the kinematics of a state, if they are there; whether they were.
    pub fn give(&mut self, state: &State, kinematics: &mut Kinematics) -> bool {
        let are_there = self.are_of(state);
        if are_there {
            std::mem::swap(&mut self.kinematics, kinematics);
            self.holds = false;
        }
        are_there
    }

    fn are_of(&self, state: &State) -> bool {
        self.holds && same_bits(&self.v, &state.v) && same_bits(&self.q, &state.q)
    }
}
