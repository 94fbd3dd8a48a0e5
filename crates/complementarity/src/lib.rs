//! Linear complementarity problems as data, and how far a point is from solving them. No solver: those are in `signorini-lcp`,
//! which re-exports all of this.
//!
//! - [`Lcp`]: find `z` with `0 ≤ z ⟂ w = A z + b ≥ 0`; [`MixedLcp`]: the same with free variables on rows `w = 0`.
//! - [`Residual`]: how far a point is from a solution, independent of units, computed from the original data.
//! - [`Exclusion`]: a proof that a problem has no solution, judged by its data.
//! - [`Scaling`]: the weights that put all variables in one unit.
//!
//! ```
//! use signorini_complementarity::{Lcp, Matrix};
//!
//! let A = Matrix::new(2, 2, vec![2.0, 1.0, 1.0, 2.0])?;
//! let problem = Lcp::new(A, vec![-5.0, -6.0])?;
//! assert!(problem.residual(&[4.0 / 3.0, 7.0 / 3.0]).within(1e-12));
//! # Ok::<(), signorini_complementarity::LcpError>(())
//! ```
#![allow(non_snake_case)] // matrices keep the letters of the formulas

mod error;
mod exclusion;
mod matrix;
mod problem;
mod refusal;
mod residual;

pub use error::LcpError;
pub use exclusion::{ExcludedCase, Exclusion, PairCase};
pub use matrix::{Matrix, dot};
pub use problem::{Lcp, MixedLcp};
pub use refusal::Refusal;
pub use residual::{Residual, Scaling};
