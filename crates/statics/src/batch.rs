//! Many placements of one model, on all cores.

use rayon::prelude::*;
use signorini_contact::statics::Verdict;
use signorini_multibody::{Input, Model, State};
use signorini_simulation::SimulationError;

use crate::configuration::Configuration;
use crate::question::SafetyQuestion;
use crate::settings::StabilitySettings;

/// What became of one placement.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Placement {
    /// The verdict.
    pub verdict: Verdict,
    /// The worst residual of its proof.
    pub residual: f64,
    /// Contacts that touch.
    pub contacts: usize,
    /// The deepest overlap that was taken as touching, m or rad: a placement with a large one is none.
    pub deepest_overlap: f64,
    /// Where the limit that was asked for lies at least ([`Safety::holds`](crate::Safety::holds)); not a number where none was asked for.
    pub margin: f64,
}

/// Judges placements of a model, each as [`stability`](crate::stability()), on all cores.
///
/// - `states`: a configuration each; velocities are taken as zero
/// - `question`: the margin that is wanted of those that do not move
/// - `progress`: called from any thread when a placement is judged
///
/// A placement that cannot be judged has its error; the others do not care.
pub fn placements(
    model: &Model,
    states: &[State],
    input: &Input,
    settings: &StabilitySettings,
    question: Option<&SafetyQuestion>,
    progress: impl Fn() + Sync,
) -> Vec<Result<Placement, SimulationError>> {
    let judged = |state: &State| {
        let configuration = Configuration::new(model, state, input);
        let found = configuration.stability(settings)?;
        let (rest, found) = (found.rest, found.stability);
        let verdict = found.verdict();
        let margin = match question.filter(|_| verdict != Verdict::MustMove) {
            Some(question) => configuration.safety(settings, question)?.holds,
            None => f64::NAN,
        };
        Ok(Placement {
            verdict,
            residual: found.worst(),
            contacts: rest.problem.contact_count(),
            deepest_overlap: rest.deepest_overlap,
            margin,
        })
    };
    states
        .par_iter()
        .map(|state| {
            let placement = judged(state);
            progress();
            placement
        })
        .collect()
}
