//! Problems solved by any method of the library: what `solve` and `compare` share.

mod answer;
mod choice;
mod contact;
mod denial;
mod plain;

pub use answer::{Answer, Options, Point};
pub use choice::{ContactLaw, SolverChoice};
pub use contact::{solve_contact, with_directions};
pub use denial::Denial;
pub use plain::{frictional_impulses, solve_frictional, solve_lcp, solve_mixed};
