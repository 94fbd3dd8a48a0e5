//! The verdict on a model in a state.

use signorini_multibody::{Input, Model, State};
use signorini_simulation::{RestProblem, SimulationError, rest_problem};

use crate::settings::StabilitySettings;
use crate::verdict::{Stability, judge};

/// A verdict on a model, with the contact problem that it speaks of.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ModelStability {
    /// The problem: contacts, loads, and where its rows come from.
    pub rest: RestProblem,
    /// The verdict.
    pub stability: Stability,
}

/// Judges a model at rest in a configuration: does it stand under its loads?
///
/// - `state`: its velocity is taken as zero
/// - `input`: controls and applied forces, part of the loads
///
/// # Errors
/// [`SimulationError`] as [`rest_problem`]; [`SimulationError::Problem`] as [`judge`].
pub fn stability(
    model: &Model,
    state: &State,
    input: &Input,
    settings: &StabilitySettings,
) -> Result<ModelStability, SimulationError> {
    let rest = rest_problem(model, state, input, &settings.simulation, settings.contact_tolerance)?;
    let stability = judge(&rest.problem, settings)?;
    Ok(ModelStability { rest, stability })
}
