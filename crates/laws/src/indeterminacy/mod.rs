//! Indeterminate contact impulses: the set of all that solve the problem with the same velocity, and one choice among them.
//!
//! Where contacts are redundant (a box on four points, a table with four legs, a ball in a groove), `v⁺` may be unique while
//! the impulses are not. At a fixed `v⁺` complementarity decides which impulses may be positive, and what is left is a
//! polyhedron: [`force_distributions`] gives its dimension and the range of every impulse in it, [`least_norm_impulses`] the
//! point of least norm.

mod distributions;
mod faces;
mod least_norm;
mod ranges;
mod row_space;
mod simplex;

pub use distributions::force_distributions;
pub use least_norm::{LeastNorm, LeastNormOutcome, LeastNormReport, least_norm_impulses};
pub use ranges::{ForceDistributions, ImpulseRange, SelfStress};
pub use simplex::LinearProgramResidual;
