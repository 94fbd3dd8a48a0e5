//! The structured contact solver: exact, warm-started, island by island, with Lemke's method at the end of its cascade.
//!
//! The walk of a problem is in [`ContactSolver`]: [islands](Islands) → the ones that the start solves already → the cascade of
//! stages, one table, on each of the others → the verdict, which is the certificate's. Where the certificate does not hold, the
//! islands that lack something have a second look. What was tried, how often it ended an island, and on request the residuals on
//! the way and the time of every stage are in the report of the solution.

mod bilateral_basis;
mod contact_solver;
mod interior;
mod islands;
mod iterate;
mod lcp_route;
mod pool;
mod proximal;
mod residual;
mod settings;
mod stages;
mod task;
#[cfg(test)]
mod testing;
mod verdict;

pub use bilateral_basis::BilateralBasis;
pub use contact_solver::ContactSolver;
pub use islands::{Island, Islands};
pub use lcp_route::solve_as_lcp;
pub use proximal::ProximalSystem;
pub use settings::SolverSettings;
