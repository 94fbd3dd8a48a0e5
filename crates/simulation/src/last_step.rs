//! The step that a simulation has just made.

use signorini_multibody::{Input, Model, State};

use crate::report::StepReport;
use crate::settings::Settings;
use crate::simulation::Simulation;
use crate::workspace::Workspace;

/// A step with everything that it was made from.
pub struct LastStep<'a> {
    /// The model.
    pub model: &'a Model,
    /// State at the beginning of the step.
    pub state: &'a State,
    /// Input of the step.
    pub input: &'a Input,
    /// Settings of the step.
    pub settings: &'a Settings,
    /// What the step said.
    pub report: &'a StepReport,
    /// Its contacts, its problem and its solution.
    pub workspace: &'a mut Workspace,
}

impl Simulation {
    /// The last step, to be asked for right after [`step`](Self::step): a state or an input that was changed since then is not that of the step.
    pub fn last_step(&mut self) -> LastStep<'_> {
        let Self { model, settings, workspace, state, next, input, report, .. } = self;
        // A step that is made leaves the state it was made from in `next`.
        let state = if report.advanced() { next } else { state };
        LastStep { model, state, input, settings, report, workspace }
    }
}
