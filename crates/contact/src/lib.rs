//! Contact with dry friction as a linear complementarity problem.
//!
//! The way through this crate: contact frames and friction polygons → [`ContactProblem`] (plain data: `M`, `v^f`, `Δt`, `J_N`,
//! `J_T`, `φ`, `μ`, `D`) → the structured [`ContactSolver`], or the mixed and the standard LCP for any method of
//! `signorini-lcp` → [`ContactSolution`] → [`certify`]. A researcher with matrices of their own starts at [`ContactProblem`].
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

mod assemble;
mod bilateral_basis;
mod certificate;
mod cone;
mod error;
mod frame;
mod friction_group;
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
mod scales;
mod settling;
mod solution;
mod solver;
mod unsupported;
mod vector;

pub use assemble::Layout;
pub use bilateral_basis::BilateralBasis;
pub use certificate::{Certificate, certify};
pub use cone::{
    CircularConeSolver, ConeCertificate, ConeGap, ConeReport, ConeSettings, ConeSolution, ConeStart, ConeStatus,
    ConeWarmStart, DirectionRefiner, RefinementReport, align_directions, certify_cone, cone_gaps, velocity_error_bound,
};
pub use error::ProblemError;
pub use frame::ContactFrame;
pub use friction_group::{FrictionBound, FrictionGroups};
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
pub use settling::{SettlingEffort, SettlingSolver, SettlingStep};
pub use solution::{ContactMode, ContactSolution};
pub use solver::{ContactSolver, SolveReport, SolveStatus, SolverSettings, WarmStart};
pub use unsupported::UnsupportedFriction;
