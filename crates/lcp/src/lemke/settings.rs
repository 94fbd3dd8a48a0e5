use derive_setters::Setters;

use crate::LcpError;
use crate::setting::{check_at_least_one, check_small, check_tolerance};

/// Settings of [`Lemke`](crate::Lemke).
///
/// `tie` and `pivot` refer to the equilibrated problem, whose rows, columns and right-hand side have size 1.
#[derive(Clone, Debug, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct LemkeSettings {
    /// Relative residual up to which a point is called solved. Default 1e-10; in (0, 1).
    pub tolerance: f64,
    /// Basic variables within this of zero, relative to the largest, are tied. Default 1e-12; in (0, 1e-4].
    pub tie: f64,
    /// Entries of a transformed column below this, relative to its largest, count as zero. Default 1e-10; in
    /// (0, 1e-4].
    pub pivot: f64,
    /// Updates of the basis between factorisations. Default 50; at least 1.
    pub updates: usize,
    /// Pivots allowed per walk, per complementary pair. Default 20; at least 1.
    pub pivots_per_pair: usize,
    /// Covering vectors tried from `z = 0`. Default 3; at least 1.
    pub covering_vectors: u32,
    /// Whether problems with 1e-8, 1e-6 and 1e-4 added to their diagonals are walked where the problem itself ended beside a solution. Default
    /// true.
    pub regularizes: bool,
}

impl Default for LemkeSettings {
    fn default() -> Self {
        Self {
            tolerance: 1e-10,
            tie: 1e-12,
            pivot: 1e-10,
            updates: 50,
            pivots_per_pair: 20,
            covering_vectors: 3,
            regularizes: true,
        }
    }
}

impl LemkeSettings {
    /// Checks every field against its range.
    ///
    /// # Errors
    /// [`LcpError::Setting`] naming the first field outside its range.
    pub fn validate(&self) -> Result<(), LcpError> {
        check_tolerance(self.tolerance)?;
        check_small("tie", self.tie)?;
        check_small("pivot", self.pivot)?;
        check_at_least_one("updates", self.updates)?;
        check_at_least_one("pivots_per_pair", self.pivots_per_pair)?;
        check_at_least_one("covering_vectors", self.covering_vectors as usize)
    }
}
