//! Lemke's method, and where it ends without a solution of a tiny problem, all complementary bases.

use crate::{Basis, Enumeration, EnumerationSettings, Lcp, LcpError, Lemke, LemkeSettings, Method, Solution};

/// [`Lemke`] first; if it finds no solution and the problem is small enough, [`Enumeration`].
///
/// A ray of Lemke's method proves that there is no solution only for some classes of matrices. For others (bimatrix games
/// with positive payoffs, say) it can end on a ray although solutions exist; on tiny problems enumeration decides.
/// The attempts of both are in the report.
///
/// # Guarantee
/// That of [`Lemke`], and up to [`max_pairs`](EnumerationSettings::max_pairs) pairs that of [`Enumeration`], for every
/// matrix.
#[derive(Debug)]
pub struct Automatic {
    lemke: Lemke,
    enumeration: Enumeration,
    largest: usize,
}

impl Automatic {
    /// The method with the settings of its two parts.
    ///
    /// # Errors
    /// [`LcpError::Setting`] when a setting is outside its range.
    pub fn new(lemke: LemkeSettings, enumeration: EnumerationSettings) -> Result<Self, LcpError> {
        let largest = enumeration.max_pairs;
        Ok(Self { lemke: Lemke::new(lemke)?, enumeration: Enumeration::new(enumeration)?, largest })
    }
}

impl Method for Automatic {
    fn solve(&mut self, problem: &Lcp, warm: Option<&Basis>) -> Solution {
        let first = self.lemke.solve(problem, warm);
        if first.status.is_solved() || problem.len() > self.largest {
            return first;
        }
        let mut second = self.enumeration.solve(problem, None);
        if !second.status.is_solved() {
            return first;
        }
        second.iterations += first.iterations;
        second.report.attempts.splice(0..0, first.report.attempts);
        second
    }

    fn tolerance(&self) -> f64 {
        self.lemke.tolerance()
    }
}
