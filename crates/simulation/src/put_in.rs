//! What the corrections of a step put into its motion, and what it is found with.

use signorini_contact::SparseRows;
use signorini_contact::projection::Cones;

use crate::smallest_change::SmallestChange;

/// What corrections put in, and what it is found with.
#[derive(Clone, Debug, Default)]
pub(crate) struct PutIn {
    /// The rows that ask for something or hold something, and their rates, m/s or rad/s.
    pub rows: SparseRows<1>,
    pub rates: Vec<f64>,
    pub cones: Cones,
    pub smallest: SmallestChange,
    /// The velocity of the trees that corrections move, `[nv]`.
    pub moved: Vec<f64>,
    /// The smallest change that makes the corrections, `[nv]`.
    pub change: Vec<f64>,
    /// The velocity without it, or after the step without corrections, `[nv]`.
    pub without: Vec<f64>,
    /// The kinetic energy of that step, J, where it was asked for.
    pub energy_without: Option<f64>,
}
