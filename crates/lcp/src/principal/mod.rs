//! Cottle and Dantzig's principal pivoting with a factorised active block.

mod settings;
mod walk;

pub use settings::PrincipalPivotingSettings;
use walk::{End, Limits, Walk};

use crate::direction::{Direction, certificate};
use crate::equilibrate::Scaled;
use crate::incumbent::Incumbent;
use crate::linalg::Lu;
use crate::polish::Polish;
use crate::{Attempt, Basis, Farkas, Lcp, LcpError, Method, Outcome, Refusal, Report, Solution, Start, Status};

/// Cottle and Dantzig's principal pivoting method: one pair after another is put in order, without an artificial
/// variable.
///
/// # Guarantee
/// For sufficient matrices, which all positive semidefinite ones (symmetric or not) and all P-matrices are, it ends at
/// a solution or proves that there is none: [`Status::Infeasible`] with Farkas multipliers. Ties go to the least index,
/// which for these matrices excludes cycles. Whether a matrix is sufficient is not tested beforehand; a pivot whose
/// signs exclude it ends the method with [`Status::Refused`]. A matrix that is not sufficient may still be solved.
///
/// # Cost
/// O(n·k) per pivot with k basic `z`, plus O(k³) every [`updates`](PrincipalPivotingSettings::updates) pivots. At most
/// n major cycles; the number of pivots in one is exponential at worst and few in practice.
///
/// # Source
/// Dantzig, Cottle (1967); Cottle (1990), *The principal pivoting method revisited*; Cottle, Chang (1992), least-index
/// rule; Cottle, Pang, Stone, *The Linear Complementarity Problem* (2009), §4.3 and §4.9.
#[derive(Clone, Debug, Default)]
pub struct PrincipalPivoting {
    settings: PrincipalPivotingSettings,
    scaled: Scaled,
    walk: Walk,
    polish: Polish,
    lu: Lu,
}

impl PrincipalPivoting {
    /// The method with these settings.
    ///
    /// # Errors
    /// [`LcpError::Setting`] when a setting is outside its range.
    pub fn new(settings: PrincipalPivotingSettings) -> Result<Self, LcpError> {
        settings.validate()?;
        Ok(Self { settings, ..Self::default() })
    }

    /// One walk; returns the status it suggests.
    fn attempt(&mut self, best: &mut Incumbent, report: &mut Report, start: Start, from: &Basis) -> Status {
        let settings = &self.settings;
        let limits = Limits {
            pivots: settings.pivots_per_pair * best.problem.len() + 100,
            updates: settings.updates,
            tie: settings.tie,
            pivot: settings.pivot,
        };
        let end = self.walk.run(&self.scaled, &from.z_basic, limits);
        let mut residual = None;
        let (outcome, status) = match end {
            End::Complementary => {
                residual = Some(self.finish(best));
                (Outcome::Complementary, Status::Inaccurate)
            }
            End::Unbounded(pair) => (Outcome::Ray, self.unbounded(best.problem, pair)),
            End::Refused(refusal) => (Outcome::Refused, Status::Refused(refusal)),
            End::Cycle => (Outcome::Cycle, Status::IterationLimit),
            End::Limit => (Outcome::IterationLimit, Status::IterationLimit),
            End::Singular => (Outcome::Singular, Status::Singular),
        };
        let (pivots, factorizations) = (self.walk.pivots, self.walk.factorizations);
        report.attempts.push(Attempt { start, outcome, pivots, factorizations, residual });
        status
    }

    /// Solves the basis of the walk afresh from the original data.
    fn finish(&mut self, best: &mut Incumbent) -> f64 {
        let n = self.scaled.n;
        let basis = Basis { z_basic: self.walk.nonbasic.iter().map(|&variable| variable < n).collect() };
        let mut z = vec![0.0; n];
        for (&variable, &x) in self.walk.basis.head.iter().zip(&self.walk.x).filter(|(variable, _)| **variable >= n) {
            z[variable - n] = self.scaled.unscaled_z(variable - n, x);
        }
        let polished = best.offer_basis(&mut self.polish, &basis).map_or(f64::INFINITY, |residual| residual.value);
        if polished <= self.settings.tolerance {
            return polished;
        }
        best.offer(z, &basis).value.min(polished)
    }

    /// What follows when the driving variable of `pair` grows without bound.
    fn unbounded(&mut self, problem: &Lcp, pair: usize) -> Status {
        let (row, multipliers) = self.row(pair);
        if let Some(farkas) = multipliers.and_then(|y| self.proof(y)) {
            return Status::Infeasible(farkas);
        }
        // In a sufficient matrix the row has the signs opposite to those of the column, and proves infeasibility.
        let refusal = row.map(|(col, value)| Status::Refused(Refusal::NotSufficient { row: pair, col, value }));
        let entering = self.walk.nonbasic[pair];
        let direction = || Direction::of(&self.scaled, &self.walk.basis, &self.walk.driving, entering);
        refusal
            .or_else(|| {
                direction().map(|direction| Status::Ray(direction.unscaled(&self.scaled, problem.scaling().z())))
            })
            .unwrap_or(Status::Inaccurate)
    }

    fn proof(&self, mut y: Vec<f64>) -> Option<Farkas> {
        let size = y.iter().fold(0.0f64, |max, y| max.max(y.abs()));
        let nearly_nonnegative = y.iter().all(|y| *y >= -self.settings.pivot * size);
        y.iter_mut().for_each(|y| *y = y.max(0.0));
        if nearly_nonnegative { certificate(&self.scaled, &y) } else { None }
    }

    /// The row of the basic variable of `pair` in the current principal transform: the largest positive entry in it,
    /// if any, and the combination of the original rows that it is, `None` for both where the block is singular.
    ///
    /// With the active block `K` and `v = K⁻ᵀ r` for the row `r` of the pair in its columns (a unit vector if the pair
    /// is active), `w_r − vᵀw_α` is the row when the pair is not active, and `−vᵀw_α` when it is.
    fn row(&mut self, pair: usize) -> (Option<(usize, f64)>, Option<Vec<f64>>) {
        let n = self.scaled.n;
        let active: Vec<usize> = (0..n).filter(|&i| self.walk.nonbasic[i] < n).collect();
        let k = active.len();
        let is_active = self.walk.nonbasic[pair] < n;
        let transposed = self.lu.start(k);
        for (row, &j) in transposed.chunks_exact_mut(k.max(1)).zip(&active) {
            row.iter_mut().zip(&active).for_each(|(entry, &i)| *entry = self.scaled.column(j)[i]);
        }
        if k > 0 && self.lu.factorize() == 0.0 {
            return (None, None);
        }
        let in_columns =
            |&j: &usize| if is_active { f64::from(u8::from(j == pair)) } else { self.scaled.column(j)[pair] };
        let mut v: Vec<f64> = active.iter().map(in_columns).collect();
        self.lu.solve(&mut v);
        let mut y = vec![0.0; n];
        active.iter().zip(&v).for_each(|(&i, v)| y[i] = -v);
        if !is_active {
            y[pair] = 1.0;
        }
        let entry = |j: usize| match self.walk.nonbasic[j] < n {
            true => -y[j],
            false => crate::linalg::dot(self.scaled.column(j), &y),
        };
        let size = y.iter().fold(0.0f64, |max, y| max.max(y.abs()));
        let largest = (0..n).filter(|&j| j != pair).map(|j| (j, entry(j))).max_by(|a, b| a.1.total_cmp(&b.1));
        (largest.filter(|(_, value)| *value > self.settings.pivot * size), Some(y))
    }
}

impl Method for PrincipalPivoting {
    fn solve(&mut self, problem: &Lcp, warm: Option<&Basis>) -> Solution {
        let n = problem.len();
        let mut best = Incumbent::new(problem);
        let mut report = Report::default();
        let tolerance = self.settings.tolerance;
        let mut status = Status::Solved;
        if best.residual.value > 0.0 {
            self.scaled.load(problem.A(), problem.b(), problem.scaling());
            if let Some(warm) = warm.filter(|warm| warm.z_basic.len() == n) {
                status = self.attempt(&mut best, &mut report, Start::Advanced, warm);
            }
            let settled = best.residual.within(tolerance) || matches!(status, Status::Infeasible(_));
            if report.attempts.is_empty() || !settled {
                status = self.attempt(&mut best, &mut report, Start::Zero, &Basis::slack(n));
            }
        }
        let pivots = report.attempts.iter().map(|attempt| attempt.pivots).sum();
        best.into_solution(tolerance, status, pivots, report)
    }

    fn tolerance(&self) -> f64 {
        self.settings.tolerance
    }
}
