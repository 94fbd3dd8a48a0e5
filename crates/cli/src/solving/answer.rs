//! What problems are solved with, and what comes of it.

use signorini::contact::{ConeSolution, ContactSolution, RelaxedSolution, StageCounts, StageRun};

use super::choice::ContactLaw;
use super::denial::Denial;
use crate::results::{Distributions, Ending, Laws, LeastNormResult};

/// How problems are solved.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// A problem is solved when every residual is at most this.
    pub tolerance: f64,
    /// Direction refinement: bound on the residuals of the circular cone's laws.
    pub cone_tolerance: f64,
    /// Whether the impulses of least norm are chosen.
    pub least_norm: bool,
    /// Whether the set of force distributions is described.
    pub ranges: bool,
    /// Whether every stage of the structured solver is followed on every island.
    pub history: bool,
}

/// What a solve gives, whatever the kind of the problem.
pub struct Answer {
    /// Rows of the complementarity problem.
    pub n: usize,
    /// Contacts, where the problem has any.
    pub contacts: Option<usize>,
    /// Method.
    pub method: String,
    /// The friction law solved, where the problem has contacts.
    pub law: Option<ContactLaw>,
    /// How the method ended by its own account.
    pub ending: Ending,
    /// Whether every residual is within its tolerance.
    pub holds: bool,
    /// Residuals of that law.
    pub residual: Laws,
    /// Residuals of the circular cone's laws, beside those of a polygon.
    pub circular_laws: Option<Laws>,
    /// Residuals of the true contact laws, beside those of a relaxation.
    pub contact_laws: Option<Laws>,
    /// Iterations.
    pub iterations: u64,
    /// Wall time of the solve, s.
    pub seconds: f64,
    /// What became of the impulses of least norm.
    pub least_norm: Option<LeastNormResult>,
    /// The set of force distributions.
    pub distributions: Option<Distributions>,
    /// The proof that there is no solution, and what rounding leaves of it.
    pub denial: Option<(Denial, f64)>,
    /// The point found.
    pub point: Point,
}

/// The point that a method ends with.
pub enum Point {
    /// Of a polygon's laws.
    Contact(Box<ContactSolution>),
    /// Of the circular cone's laws.
    Cone(Box<ConeSolution>),
    /// Of the convex relaxation.
    Relaxed(Box<RelaxedSolution>),
    /// Of a complementarity problem.
    Plain(Vec<f64>),
}

impl Point {
    /// What the structured solver's stages did for it.
    pub fn stages(&self) -> StageCounts {
        match self {
            Self::Contact(solution) => solution.report.stages,
            Self::Cone(solution) => solution.report.stages,
            Self::Relaxed(_) | Self::Plain(_) => StageCounts::default(),
        }
    }

    /// What they did on each island, where it was asked for.
    pub fn history(&self) -> &[StageRun] {
        match self {
            Self::Contact(solution) => &solution.history,
            _ => &[],
        }
    }
}

impl Answer {
    /// `solved` where the residuals say so, else the method's own word.
    pub fn status(&self) -> &'static str {
        match self.ending.name {
            _ if self.holds => "solved",
            "solved" => "inaccurate",
            other => other,
        }
    }
}
