//! Derivatives of a simulation's steps.

use signorini_simulation::{Simulation, SimulationError};

use crate::StepDerivatives;
use crate::validity::Validity;

impl StepDerivatives {
    /// Makes one step of a simulation and takes its derivative; returns what that is worth.
    ///
    /// # Errors
    /// Those of [`Simulation::step`].
    pub fn step(&mut self, simulation: &mut Simulation) -> Result<&Validity, SimulationError> {
        simulation.step()?;
        let last = simulation.last_step();
        self.compute(last.model, (last.state, last.input), last.settings, last.report, last.workspace);
        Ok(self.validity())
    }
}
