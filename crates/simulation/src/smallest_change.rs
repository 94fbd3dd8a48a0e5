//! Storage for the smallest change of velocity that makes the corrections of a step.

use signorini_contact::SparseRows;
use signorini_solver::BilateralBasis;

/// The smallest change of velocity that makes corrections, and what it is found with.
#[derive(Clone, Debug, Default)]
pub(crate) struct SmallestChange {
    /// The rows that ask for something or hold something, and their rates, m/s or rad/s.
    pub rows: SparseRows<1>,
    pub rates: Vec<f64>,
    pub basis: BilateralBasis,
    /// The velocity of the trees that corrections move, `[nv]`.
    pub moved: Vec<f64>,
    /// `[nv]`.
    pub change: Vec<f64>,
    /// The velocity without it, `[nv]`.
    pub without: Vec<f64>,
}
