//! A verdict on a model with what it speaks of.

use signorini_simulation::RestProblem;

use crate::verdict::Stability;

/// A verdict on a model, with the contact problem that it speaks of.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ModelStability {
    /// The problem: contacts, loads, and where its rows come from.
    pub rest: RestProblem,
    /// The verdict.
    pub stability: Stability,
    /// What attracts the bodies at every contact, N ([`Attraction`](crate::Attraction)); part of the loads.
    pub attraction: Vec<f64>,
}
