//! Contact with dry friction as a linear complementarity problem.
//!
//! The way through this crate: contact frames and friction polygons → [`ContactProblem`] (plain data: `M`, `v^f`, `Δt`, `J_N`,
//! `J_T`, `φ`, `μ`, `D`) → the structured [`ContactSolver`], or the mixed and the standard LCP for any method of
//! `signorini-lcp` → [`ContactSolution`] → [`certify`]. A researcher with matrices of their own starts at [`ContactProblem`].

mod assemble;
mod certificate;
mod error;
mod frame;
mod frictional_certificate;
mod indeterminacy;
mod jacobian;
mod lcp_route;
mod polygon;
mod polyhedral;
mod problem;
pub mod problem_file;
mod recovery;
mod relaxation;
mod solution;
mod solver;

pub use assemble::Layout;
pub use certificate::{Certificate, certify};
pub use error::ProblemError;
pub use frame::ContactFrame;
pub use indeterminacy::{
    ForceDistributions, ImpulseRange, LeastNorm, LeastNormOutcome, LeastNormReport, LinearProgramResidual, SelfStress,
    force_distributions, least_norm_impulses,
};
pub use jacobian::SparseRows;
pub use lcp_route::solve_as_lcp;
pub use polygon::FrictionPolygon;
pub use problem::ContactProblem;
pub use relaxation::{
    ConvexRelaxation, RelaxationCertificate, RelaxationReport, RelaxationStatus, RelaxedSolution, certify_relaxation,
};
pub use solution::{ContactMode, ContactSolution};
pub use solver::{ContactSolver, SolveReport, SolveStatus, SolverSettings, WarmStart};
