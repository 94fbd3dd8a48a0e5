//! The task of the batch of robots that `benchmarks/batch/compare.py` writes.

use std::error::Error;
use std::f64::consts::TAU;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};

use serde::Deserialize;
use signorini::multibody::State;

/// A robot with servos whose targets swing about a stance: every simulation a little quicker than the one before it.
#[derive(Clone, Debug, Deserialize)]
pub struct BatchTask {
    /// The model file.
    pub model: PathBuf,
    /// Configuration at the start, `[nq]`.
    pub start: Vec<f64>,
    timestep: f64,
    /// Targets at rest, rad.
    stance: Vec<f64>,
    /// How far each target swings away from it in one half of the wave, rad.
    lift: Vec<f64>,
    /// 1 for those that swing in the first half of the wave, −1 for the others.
    phase: Vec<f64>,
    /// Frequency of the first simulation, and what each adds, Hz.
    hz: [f64; 2],
}

impl BatchTask {
    /// Reads a task.
    ///
    /// # Errors
    /// The file cannot be read or is none.
    pub fn read(path: &Path) -> Result<Self, Box<dyn Error>> {
        Ok(serde_json::from_str(&std::fs::read_to_string(path)?)?)
    }

    /// Targets of so many simulations, rad, `[simulations, steps, motors]`; `first`: index of the first step.
    pub fn controls(&self, simulations: usize, first: usize, steps: usize) -> Vec<f64> {
        let mut controls = Vec::with_capacity(simulations * steps * self.stance.len());
        for i in 0..simulations {
            let hz = self.hz[0] + i as f64 * self.hz[1];
            for k in first..first + steps {
                let wave = (TAU * hz * self.timestep * k as f64).sin();
                let motors = self.stance.iter().zip(&self.lift).zip(&self.phase);
                controls.extend(motors.map(|((rest, lift), phase)| rest + (phase * wave).max(0.0) * lift));
            }
        }
        controls
    }
}

/// A number that differs where a bit of a state does.
pub fn hash_of<'a>(states: impl Iterator<Item = &'a State>) -> u64 {
    let mut hasher = DefaultHasher::new();
    for state in states {
        state.q.iter().chain(&state.v).for_each(|x| x.to_bits().hash(&mut hasher));
    }
    hasher.finish()
}
