//! Linear complementarity problems, from their data to a checked solution.
//!
//! - [`Lcp`]: find `z` with `0 ≤ z ⟂ w = A z + b ≥ 0`; [`MixedLcp`]: the same with free variables on rows `w = 0`.
//! - [`Residual`]: how far a point is from a solution, independent of units. Methods, tests and benchmarks all
//!   judge by this one number, computed from the original data.
//! - [`Method`]: an algorithm; [`MethodKind`] has them by name.
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
//!
//! # Which method?
//!
//! | method | is sure to end with the answer for | cost | source |
//! |---|---|---|---|
//! | [`Lemke`] | copositive-plus (so all positive semidefinite), P, strictly copositive matrices; copositive ones where `bᵀz ≥ 0` for every `0 ≤ z ⟂ A z ≥ 0` | O(n·k) per pivot, about n pivots | Cottle, Pang, Stone (2009), §4.4 |
//! | [`PrincipalPivoting`] | sufficient matrices: positive semidefinite (symmetric or not), P | O(n·k) per pivot; no artificial variable | ibid. §4.3; Cottle, Chang (1992) |
//! | [`Psor`] | symmetric positive semidefinite with a positive diagonal; H₊ | O(n²) per sweep, linear convergence | ibid. §5.3, §5.4; Luo, Tseng (1991) |
//! | [`SemismoothNewton`] | matrices that are P₀ and R₀, P among them | O(n³) per step, some ten steps | De Luca, Facchinei, Kanzow (1996) |
//! | [`Enumeration`] | every matrix, small n; also all solutions | 2ⁿ factorisations | ibid. §1.4 |
//! | [`Automatic`] | what [`Lemke`] is sure of, and every matrix for small n | that of the two | |
//!
//! n is the number of pairs, k the number of positive `z`. "The answer" of the first two is a solution, or for positive
//! semidefinite matrices the proof that there is none. The theorems are about exact arithmetic; in floating point an
//! answer is called [`Status::Solved`] if and only if its residual in the original data is within the tolerance, and
//! [`Status::Infeasible`] only with multipliers that were checked.
//!
//! Whether a problem meets the hypotheses need not be known. [`Psor`] tests its own beforehand, [`PrincipalPivoting`]
//! notices on the way, and both answer [`Status::Refused`] with the hypothesis and its place:
//!
//! ```
//! use signorini_lcp::{Lcp, Matrix, Method, Psor, Refusal, Status};
//!
//! // A bound has no diagonal entry, so relaxation would divide by zero in row 1.
//! let problem = Lcp::new(Matrix::new(2, 2, vec![1.0, -1.0, 1.0, 0.0])?, vec![0.5, -1.0])?;
//! let status = Psor::default().solve(&problem, None).status;
//! assert_eq!(status, Status::Refused(Refusal::Diagonal { row: 1, value: 0.0 }));
//! # Ok::<(), signorini_lcp::LcpError>(())
//! ```
//!
//! # Convex quadratic programs
//!
//! Minimise `½ xᵀH x + cᵀx` subject to `G x ≥ h`: with multipliers `y` it is the mixed problem
//! `H x − Gᵀy + c = 0`, `0 ≤ y ⟂ G x − h ≥ 0`, in which every method eliminates the free `x` first.
//!
//! ```
//! use signorini_lcp::{Matrix, MethodKind, MixedLcp, solve_mixed};
//!
//! // The point nearest to (2, 1) with x₁ + x₂ ≤ 1: (1, 0).
//! let A = Matrix::new(3, 3, vec![1.0, 0.0, 1.0, 0.0, 1.0, 1.0, -1.0, -1.0, 0.0])?;
//! let problem = MixedLcp::new(A, vec![-2.0, -1.0, 1.0], vec![true, true, false])?;
//! for kind in MethodKind::all() {
//!     let solution = solve_mixed(&problem, &mut *kind.build()?, None);
//!     assert!(solution.status.is_solved(), "{kind}");
//!     assert!((solution.z[0] - 1.0).abs() < 1e-12 && solution.z[1].abs() < 1e-12, "{kind}");
//! }
//! # Ok::<(), signorini_lcp::LcpError>(())
//! ```
//!
//! # No solution, one, or many
//!
//! ```
//! use signorini_lcp::{Enumeration, Lcp, Matrix, Method, PrincipalPivoting, Status};
//!
//! // z₁ − z₂ ≥ 1 and z₂ − z₁ ≥ 1: their sum is the proof that this is impossible.
//! let A = Matrix::new(2, 2, vec![1.0, -1.0, -1.0, 1.0])?;
//! let squeezed = Lcp::new(A.clone(), vec![-1.0, -1.0])?;
//! let Status::Infeasible(proof) = PrincipalPivoting::default().solve(&squeezed, None).status else { panic!() };
//! assert_eq!(proof.y[0], proof.y[1]);
//!
//! // A bimatrix game with three equilibria.
//! let game = Matrix::new(4, 4, vec![0., 0., 10., 20., 0., 0., 30., 15., 10., 20., 0., 0., 30., 15., 0., 0.])?;
//! let set = Enumeration::default().solution_set(&Lcp::new(game, vec![-1.0; 4])?)?;
//! assert!(set.points.len() == 3 && set.is_finite());
//!
//! // z₁ = z₂ + 1 on a whole ray.
//! let set = Enumeration::default().solution_set(&Lcp::new(A, vec![-1.0, 1.0])?)?;
//! assert!(!set.is_finite());
//! # Ok::<(), signorini_lcp::LcpError>(())
//! ```
//!
//! # Units
//!
//! `z_i` and `w_i` may have any units: all methods work on the problem equilibrated by powers of two, which is exact.
//! What "small" means is for the caller to say by a [`Scaling`]; where nothing is known, [`equilibrated`].
#![allow(non_snake_case)] // matrices keep the letters of the formulas

mod alternative;
mod automatic;
mod direction;
mod enumeration;
mod equilibrate;
mod exclude;
mod factored_basis;
mod fingerprint;
mod incumbent;
mod lemke;
pub mod linalg;
mod method;
mod method_kind;
mod mixed;
mod newton;
mod pieces;
mod polish;
mod principal;
mod psor;
mod setting;
mod solution;

pub use alternative::Alternative;
pub use automatic::Automatic;
pub use enumeration::{Enumeration, EnumerationSettings, SolutionSet};
pub use equilibrate::equilibrated;
pub use exclude::{Existence, decide, exclude, infeasibility, tractable_cases};
pub use lemke::{Lemke, LemkeSettings};
pub use method::Method;
pub use method_kind::MethodKind;
pub use mixed::solve_mixed;
pub use newton::{NewtonMap, SemismoothNewton, SemismoothNewtonSettings};
pub use principal::{PrincipalPivoting, PrincipalPivotingSettings};
pub use psor::{Psor, PsorSettings};
pub use solution::{Attempt, Basis, Farkas, Outcome, Ray, Report, Solution, Start, Status};

pub use signorini_complementarity::{
    ExcludedCase, Exclusion, Lcp, LcpError, Matrix, MixedLcp, PairCase, Refusal, Residual, Scaling,
};
