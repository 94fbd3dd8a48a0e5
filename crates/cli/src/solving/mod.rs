//! Problems solved by any method of the library: what `solve` and `compare` share.

mod choice;
mod contact;
mod plain;

pub use choice::{ContactLaw, SolverChoice};
pub use contact::{solve_contact, with_directions};
pub use plain::{frictional_impulses, polygonal, solve_frictional, solve_lcp, solve_mixed};

use signorini::contact::problem_file::ProblemFile;
use signorini::contact::{ConeSolution, ContactSolution, RelaxedSolution};

use crate::results::{Distributions, Ending, Laws, LeastNormResult};

/// Friction directions of a frictional problem where none are asked for.
pub const DEFAULT_DIRECTIONS: usize = 8;

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

/// The name of a problem's kind, as in the field `kind` of its file.
pub fn kind_of(problem: &ProblemFile) -> &'static str {
    match problem {
        ProblemFile::Lcp(_) => "lcp",
        ProblemFile::MixedLcp(_) => "mlcp",
        ProblemFile::Contact(_) => "contact",
        ProblemFile::Frictional(problem) if problem.dimension == 2 => "frictional2d",
        ProblemFile::Frictional(_) => "frictional3d",
        _ => "unknown",
    }
}
