//! What is judged: a model in a state with what touches, and what is asked of it.

use signorini_multibody::{ContactPoint, Input, Model, State};
use signorini_simulation::{RestProblem, SimulationError, rest_problem, rest_problem_at};

use crate::attraction;
use crate::model::ModelStability;
use crate::settings::StabilitySettings;
use crate::verdict::judge;

/// A configuration at rest: a model in a state under its loads. Contacts are found from its shapes, or known ([`Assembly`](crate::Assembly)).
#[derive(Clone, Debug)]
pub struct Configuration<'a> {
    pub(crate) model: &'a Model,
    pub(crate) state: State,
    pub(crate) input: Input,
    /// Contact points that are known, with what attracts the bodies at each, N.
    points: Option<(&'a [ContactPoint], &'a [f64])>,
}

/// The problem of a configuration, with what attracts the bodies at every contact, N.
pub(crate) type Built = (RestProblem, Vec<f64>);

impl<'a> Configuration<'a> {
    /// A model in a state.
    ///
    /// - `state`: its velocity is taken as zero
    /// - `input`: controls and applied forces, part of the loads
    pub fn new(model: &'a Model, state: &State, input: &Input) -> Self {
        Self { model, state: state.clone(), input: input.clone(), points: None }
    }

    pub(crate) fn of_points(model: &'a Model, points: &'a [ContactPoint], attraction: &'a [f64]) -> Self {
        Self { model, state: State::new(model), input: Input::default(), points: Some((points, attraction)) }
    }

    /// The problem of another model of the same structure, or under another input; whatever is asked begins with one.
    pub(crate) fn problem(
        &self,
        model: &Model,
        input: &Input,
        settings: &StabilitySettings,
    ) -> Result<Built, SimulationError> {
        settings.validate()?;
        let (simulation, state) = (&settings.simulation, &self.state);
        let mut rest = match self.points {
            None => rest_problem(model, state, input, simulation, settings.contact_tolerance)?,
            Some((points, _)) => rest_problem_at(model, state, input, simulation, points)?,
        };
        let known = self.points.map_or(&[][..], |(_, attraction)| attraction);
        let forces = attraction::attract(model, &mut rest, known, &settings.attraction)?;
        Ok((rest, forces))
    }

    /// Does it stand under its loads?
    ///
    /// # Errors
    /// [`SimulationError`] as [`rest_problem`]; [`SimulationError::Problem`] as [`judge`].
    pub fn stability(&self, settings: &StabilitySettings) -> Result<ModelStability, SimulationError> {
        let (rest, attraction) = self.problem(self.model, &self.input, settings)?;
        let stability = judge(&rest.problem, settings)?;
        Ok(ModelStability { rest, stability, attraction })
    }
}

/// Judges a model at rest in a configuration: does it stand under its loads?
///
/// - `state`: its velocity is taken as zero
/// - `input`: controls and applied forces, part of the loads
///
/// # Errors
/// As [`Configuration::stability`].
pub fn stability(
    model: &Model,
    state: &State,
    input: &Input,
    settings: &StabilitySettings,
) -> Result<ModelStability, SimulationError> {
    Configuration::new(model, state, input).stability(settings)
}
