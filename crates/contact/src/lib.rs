//! Contact with dry friction as a linear complementarity problem: the formulation as data, and no solver.
//!
//! The way through this crate: contact frames and friction polygons → [`ContactProblem`] (plain data: `M`, `v^f`, `Δt`, `J_N`,
//! `J_T`, `φ`, `μ`, `D`) → the mixed and the standard LCP; and from what any solver claims → [`ContactSolution`] → [`certify`].
//! A researcher with matrices of their own starts at [`ContactProblem`], and with `ContactSolver` of `signorini-solver`.
//!
//! ```
//! use signorini_contact::{ContactProblem, ContactSolution, FrictionPolygon, certify};
//! use signorini_multibody::BlockDiagonal;
//!
//! // A particle of 1 kg with coordinates (height, x, y) that would fall with 2 m/s and slide with 3 m/s, μ = 1/4, on a plane.
//! let mass = BlockDiagonal::from_dense(3, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0])?;
//! let mut problem = ContactProblem::new(mass, vec![-2.0, 3.0, 0.0], 0.01)?;
//! let columns = [(0, [1.0, 0.0, 0.0]), (1, [0.0, 1.0, 0.0]), (2, [0.0, 0.0, 1.0])];
//! problem.push_contact(columns, 0.0, 0.25, &FrictionPolygon::regular(4, 0.0)?);
//!
//! // Claimed, by whomever: 2 N·s stop the fall, friction takes μ λ_N = 0.5 N·s along −x, the third of the four directions.
//! let mut claimed = ContactSolution::default();
//! claimed.velocity = vec![0.0, 2.5, 0.0];
//! claimed.lambda_n = vec![2.0];
//! claimed.alpha = vec![0.0, 0.0, 0.5, 0.0];
//! claimed.beta = vec![2.5];
//! assert!(certify(&problem, &claimed).holds(1e-14));
//! claimed.alpha[2] = 0.6;
//! assert!(certify(&problem, &claimed).friction > 0.03);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! What a solver needs besides: [`projection`] onto the friction cones, [`circular`] for those that are round, [`recovery`] of
//! `α`, `β` and modes from impulses, the data's [`scales`], and the [`certificate`] in memory at hand. What proves that something at
//! rest stays or must move is in [`statics`].

mod assemble;
pub mod certificate;
pub mod circular;
mod contradiction;
mod error;
mod frame;
mod friction_group;
mod frictional_certificate;
mod jacobian;
// Small change of the crates above; no part of the interface.
#[doc(hidden)]
pub mod lists;
mod momentum;
mod outcome;
mod polygon;
mod problem;
pub mod problem_file;
pub mod projection;
pub mod recovery;
mod residuals;
pub mod scales;
mod solution;
pub mod spread;
mod stages;
pub mod statics;
mod unsupported;
#[doc(hidden)]
pub mod vector;
mod warm_start;

pub use assemble::Layout;
pub use certificate::certify;
pub use circular::{
    ConeGap, ConeReport, ConeSolution, ConeStart, ConeStatus, ConeWarmStart, certify_cone, cone_gaps,
    velocity_error_bound,
};
pub use contradiction::GapContradiction;
pub use error::ProblemError;
pub use frame::ContactFrame;
pub use friction_group::{FrictionBound, FrictionGroups};
pub use jacobian::SparseRows;
pub use outcome::{SolveReport, SolveStatus};
pub use polygon::{FrictionPolygon, MOST_DIRECTIONS};
pub use problem::ContactProblem;
pub use residuals::{Certificate, LackingRow, ResidualSpread};
pub use solution::{ContactMode, ContactSolution};
pub use spread::residual_spread;
pub use stages::{StageCount, StageCounts, StageKind, StageOutcome, StageRun};
pub use unsupported::UnsupportedFriction;
pub use warm_start::WarmStart;
