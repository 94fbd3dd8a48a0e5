//! Problems solved by any method of the library: what `solve` and `compare` share.

mod answer;
mod choice;
mod contact;
mod plain;

pub use answer::{Answer, Options, Point};
pub use choice::{ContactLaw, SolverChoice};
pub use contact::{solve_contact, with_directions};
pub use plain::{frictional_impulses, polygonal, solve_frictional, solve_lcp, solve_mixed};

use signorini::contact::problem_file::ProblemFile;

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
