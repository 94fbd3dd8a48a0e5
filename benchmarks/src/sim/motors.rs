//! The joint controller of the quadruped: the same law for every engine.

use std::f64::consts::TAU;

use serde::Deserialize;
use signorini::multibody::{Input, Model, State};

/// Legs in the order of the joints.
const LEGS: [&str; 4] = ["FL", "FR", "RL", "RR"];

/// What a scene says about its robot's controller.
#[derive(Clone, Debug, Deserialize)]
struct Law {
    motors: Vec<String>,
    stance: [f64; 3],
    kp: f64,
    kd: f64,
    tau_max: f64,
    trot: Trot,
}

/// Trot in place: each leg is lifted in one half of the wave.
#[derive(Clone, Debug, Deserialize)]
struct Trot {
    start: f64,
    hz: f64,
    lift: [f64; 3],
    /// Legs that are lifted in the first half.
    phase_on: Vec<String>,
}

/// Joint PD with limited torque that follows a stance and then a trot in place.
#[derive(Clone, Debug)]
pub struct Motors {
    law: Law,
    /// Place of every motor's joint in `q` and `v`.
    places: Vec<(usize, usize)>,
}

impl Motors {
    /// Finds the joints of a scene's controller in its model.
    ///
    /// # Errors
    /// What is missing, as a sentence.
    pub fn new(scene: &serde_json::Value, model: &Model) -> Result<Self, String> {
        let law: Law = Law::deserialize(scene).map_err(|e| format!("the robot's controller: {e}"))?;
        let place = |name: &String| {
            let joint = model.joints.iter().find(|joint| joint.name == *name);
            joint.map(|joint| (joint.q_index, joint.v_index)).ok_or(format!("the robot has no joint '{name}'"))
        };
        let places = law.motors.iter().map(place).collect::<Result<_, _>>()?;
        Ok(Self { law, places })
    }

    /// Puts the joints of a configuration into the stance.
    pub fn stand(&self, state: &mut State) {
        for (k, &(q, _)) in self.places.iter().enumerate() {
            state.q[q] = self.law.stance[k % 3];
        }
    }

    /// Writes the torques at a state, N·m.
    pub fn drive(&self, state: &State, input: &mut Input) {
        let Law { stance, kp, kd, tau_max, trot, .. } = &self.law;
        let walks = state.time >= trot.start - 1e-9;
        let wave = (TAU * trot.hz * (state.time - trot.start)).sin();
        for (k, &(q, v)) in self.places.iter().enumerate() {
            let first = trot.phase_on.iter().any(|leg| leg == LEGS[k / 3]);
            let lift = if walks { (if first { wave } else { -wave }).max(0.0) } else { 0.0 };
            let target = stance[k % 3] + lift * trot.lift[k % 3];
            let torque = kp * (target - state.q[q]) - kd * state.v[v];
            input.generalized_force[v] = torque.clamp(-tau_max, *tau_max);
        }
    }
}
