//! Derivatives of a simulation's steps.

use signorini_simulation::{Batch, LaneStop, Simulation, SimulationError};

use crate::StepDerivatives;
use crate::validity::Validity;

impl StepDerivatives {
    /// Makes one step of a simulation and takes its derivative; returns what that is worth.
    ///
    /// # Errors
    /// Those of [`Simulation::step`].
    pub fn step(&mut self, simulation: &mut Simulation) -> Result<&Validity, SimulationError> {
        simulation.step()?;
        self.of_last_step(simulation);
        Ok(self.validity())
    }

    /// Makes one step of every simulation of a batch and takes their derivatives, on the batch's threads; whether none stopped. That of a
    /// simulation that stopped is [`Validity::Refused`] with the reason.
    ///
    /// - `all`: one per simulation
    ///
    /// # Panics
    /// If `all` has not one entry per simulation.
    pub fn step_batch(batch: &mut Batch, all: &mut [Self]) -> bool {
        let went_on = batch.rollout_observed(1, &[], all, |_, simulation, one| one.of_last_step(simulation));
        for (i, stop) in batch.stops() {
            all[i].refuse(match stop {
                LaneStop::NoSolution => "the step has no solution".into(),
                LaneStop::Error(error) => format!("the step was not made: {error}"),
            });
        }
        went_on
    }

    fn of_last_step(&mut self, simulation: &mut Simulation) {
        let last = simulation.last_step();
        self.compute(last.model, (last.state, last.input), last.settings, last.report, last.workspace);
    }
}
