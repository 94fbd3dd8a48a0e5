//! Millions of small random contact problems, solved one after another from the solution before, and judged by code that shares
//! nothing with the solver.
//!
//! [`sequence`] makes the problems of a seed, [`Judge`] says how far a claimed solution is from the laws, [`examine`] what there
//! is to say about a problem that was not solved, and [`run`](run()) does all of it on several threads. A seed gives the same problems
//! and the same outcomes wherever it runs.

mod examine;
mod generate;
mod judge;
mod run;
mod tally;

pub use examine::{Finding, examine, promised};
pub use generate::{FAMILIES, MOST_ROWS, Sequence, Step, sequence};
pub use judge::Judge;
pub use run::{Limits, run};
pub use tally::{Outcome, Tally, Trial, print_tables};
