//! Linear complementarity problems, from their data to a checked solution.
//!
//! - [`Lcp`]: find `z` with `0 ≤ z ⟂ w = A z + b ≥ 0`; [`MixedLcp`]: the same with free variables on rows `w = 0`.
//! - [`Residual`]: how far a point is from a solution, independent of units. Methods, tests and benchmarks all
//!   judge by this one number, computed from the original data.
//! - [`Method`]: an algorithm. [`Lemke`] is lexicographic Lemke with a factorised basis, made for degenerate
//!   problems; [`Enumeration`] tries all complementary bases of a tiny problem and serves as oracle.
//!   [`Automatic`] is Lemke with enumeration behind it.
//! - [`Solution`]: point, [`Status`], [`Basis`] for the next warm start, and a [`Report`] of what was done.
//!
//! ```
//! use signorini_lcp::{Lcp, Lemke, Matrix, Method};
//!
//! let A = Matrix::new(2, 2, vec![2.0, 1.0, 1.0, 2.0])?;
//! let problem = Lcp::new(A, vec![-5.0, -6.0])?;
//! let solution = Lemke::default().solve(&problem, None);
//! assert!(solution.status.is_solved());
//! assert!((solution.z[0] - 4.0 / 3.0).abs() < 1e-12);
//! # Ok::<(), signorini_lcp::LcpError>(())
//! ```
#![allow(non_snake_case)] // matrices keep the letters of the formulas

mod automatic;
mod direction;
mod enumeration;
mod equilibrate;
mod error;
mod factored_basis;
mod fingerprint;
mod incumbent;
mod infeasibility;
mod lemke;
pub mod linalg;
mod matrix;
mod method;
mod mixed;
mod newton;
mod pieces;
mod polish;
mod principal;
mod problem;
mod psor;
mod refusal;
mod residual;
mod solution;

pub use automatic::Automatic;
pub use enumeration::{Enumeration, EnumerationSettings, SolutionSet};
pub use error::LcpError;
pub use lemke::{Lemke, LemkeSettings};
pub use matrix::Matrix;
pub use method::{Method, MethodKind};
pub use newton::{NewtonMap, SemismoothNewton, SemismoothNewtonSettings};
pub use principal::{PrincipalPivoting, PrincipalPivotingSettings};
pub use problem::{Lcp, MixedLcp};
pub use psor::{Psor, PsorSettings};
pub use refusal::Refusal;
pub use residual::{Residual, Scaling};
pub use solution::{Attempt, Basis, Farkas, Outcome, Ray, Report, Solution, Start, Status};
