//! The structured contact solver: exact, warm-started, island by island, with Lemke's method at the end of its cascade.
//!
//! The walk of a problem is in [`ContactSolver`]: [islands](Islands) → the ones that the start solves already → the cascade of
//! stages, one table, on each of the others → the verdict, which is the certificate's. Where the certificate does not hold, the
//! islands that lack something have a second look. What was tried, how often it ended an island, and on request the residuals on
//! the way and the time of every stage are in the report of the solution.
//!
//! ```
//! use signorini_contact::{ContactProblem, FrictionPolygon, certify};
//! use signorini_multibody::BlockDiagonal;
//! use signorini_solver::{ContactSolver, SolverSettings};
//!
//! // A particle of 1 kg with coordinates (height, x, y) that would fall with 2 m/s and slide with 3 m/s, μ = 1/4, on a plane.
//! let mass = BlockDiagonal::from_dense(3, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0])?;
//! let mut problem = ContactProblem::new(mass, vec![-2.0, 3.0, 0.0], 0.01)?;
//! let columns = [(0, [1.0, 0.0, 0.0]), (1, [0.0, 1.0, 0.0]), (2, [0.0, 0.0, 1.0])];
//! problem.push_contact(columns, 0.0, 0.25, &FrictionPolygon::regular(4, 0.0)?);
//!
//! let solution = ContactSolver::new(SolverSettings::default())?.solve(&problem, None);
//! assert!(certify(&problem, &solution).holds(1e-12));
//! // The fall takes 2 N·s, of which friction has a quarter.
//! assert!((solution.velocity[1] - 2.5).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod bilateral_basis;
mod contact_solver;
mod contact_sweeps;
mod continuation;
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
pub use task::Patience;
