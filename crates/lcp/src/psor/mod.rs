//! Projected successive overrelaxation, with a subspace step.

mod hypotheses;

use derive_setters::Setters;

use crate::equilibrate::Scaled;
use crate::incumbent::Incumbent;
use crate::linalg::dot;
use crate::polish::Polish;
use crate::setting::{check_at_least_one, check_tolerance};
use crate::{Attempt, Basis, Lcp, LcpError, Method, Outcome, Report, Solution, Start, Status};

/// Sweeps between two looks at the residual, which costs as much as a sweep.
const SWEEPS_PER_CHECK: usize = 4;

/// Settings of [`Psor`].
#[derive(Clone, Debug, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct PsorSettings {
    /// Relative residual up to which a point is called solved. Default 1e-10; in (0, 1).
    pub tolerance: f64,
    /// The relaxation parameter ω; 1 is projected Gauss–Seidel. Default 1; in (0, 2).
    pub relaxation: f64,
    /// Sweeps allowed. Default 10 000; at least 1.
    pub sweeps: usize,
    /// Whether the linear system of the positive variables is solved once they stop changing, which takes the last
    /// digits in one step. Default true.
    pub subspace: bool,
}

impl Default for PsorSettings {
    fn default() -> Self {
        Self { tolerance: 1e-10, relaxation: 1.0, sweeps: 10_000, subspace: true }
    }
}

impl PsorSettings {
    /// Checks every field against its range.
    ///
    /// # Errors
    /// [`LcpError::Setting`] naming the first field outside its range.
    pub fn validate(&self) -> Result<(), LcpError> {
        check_tolerance(self.tolerance)?;
        if !(self.relaxation > 0.0 && self.relaxation < 2.0) {
            let value = self.relaxation;
            return Err(LcpError::Setting { setting: "relaxation", value, range: "between 0 and 2, both excluded" });
        }
        check_at_least_one("sweeps", self.sweeps)
    }
}

/// Projected successive overrelaxation (PSOR): `z_i ← max(0, z_i − ω w_i / a_ii)`, row after row; with ω = 1 projected
/// Gauss–Seidel.
///
/// # Guarantee
/// The iterates converge to a solution, if there is one, for symmetric positive semidefinite matrices with a positive
/// diagonal and any ω in (0, 2), and for H₊-matrices (diagonally dominant after a scaling of columns, with a positive
/// diagonal) for ω ≤ 1 and for ω below a limit greater than 1. Both classes are tested before the first sweep, in any
/// scaling of rows and columns; for other matrices the answer is [`Status::Refused`] with the row at fault. Where there
/// is no solution, or convergence is slow, the answer is [`Status::IterationLimit`].
///
/// # Cost
/// O(n³) once for the tests of the matrix, O(n²) per sweep, O(k³) per subspace step with k positive `z`.
///
/// # Source
/// Cryer (1971); Mangasarian (1977); Luo, Tseng (1991), *On the convergence of a matrix splitting algorithm for the
/// symmetric monotone LCP*; Ahn (1981) for H₊; Cottle, Pang, Stone, *The Linear Complementarity Problem* (2009), §5.2 to
/// §5.4. The subspace step: Morales, Nocedal, Smelyanskiy (2008).
#[derive(Clone, Debug, Default)]
pub struct Psor {
    settings: PsorSettings,
    scaled: Scaled,
    polish: Polish,
}

impl Psor {
    /// The method with these settings.
    ///
    /// # Errors
    /// [`LcpError::Setting`] when a setting is outside its range.
    pub fn new(settings: PsorSettings) -> Result<Self, LcpError> {
        settings.validate()?;
        Ok(Self { settings, ..Self::default() })
    }

    /// Sweeps until the residual is small enough or none are left.
    fn sweep(&mut self, best: &mut Incumbent, start: Start, factorizations: usize) -> Attempt {
        let problem = best.problem;
        let mut z = best.z.clone();
        let (mut last, mut tried) = (Basis::default(), Basis::default());
        let mut attempt =
            Attempt { start, outcome: Outcome::IterationLimit, pivots: 0, factorizations, residual: None };
        while attempt.pivots < self.settings.sweeps {
            self.relax(problem, &mut z);
            attempt.pivots += 1;
            if !attempt.pivots.is_multiple_of(SWEEPS_PER_CHECK) && attempt.pivots < self.settings.sweeps {
                continue;
            }
            let basis = Basis { z_basic: z.iter().map(|&z| z > 0.0).collect() };
            let mut residual = best.offer(z.clone(), &basis).value;
            let settled = basis == last || residual <= self.settings.tolerance;
            if self.settings.subspace && settled && basis != tried {
                attempt.factorizations += 1;
                residual = best.offer_basis(&mut self.polish, &basis).map_or(residual, |polished| polished.value);
                tried.clone_from(&basis);
            }
            last = basis;
            attempt.residual = Some(best.residual.value);
            if best.residual.within(self.settings.tolerance) {
                attempt.outcome = Outcome::Complementary;
                break;
            }
            if residual.is_infinite() {
                break;
            }
        }
        attempt
    }

    fn relax(&self, problem: &Lcp, z: &mut [f64]) {
        for i in 0..z.len() {
            let row = problem.A().row(i);
            let w = dot(row, z) + problem.b()[i];
            z[i] = (z[i] - self.settings.relaxation * w / row[i]).max(0.0);
        }
    }
}

impl Method for Psor {
    /// Solves the problem, from the point of the basis `warm` where one is given and fits.
    fn solve(&mut self, problem: &Lcp, warm: Option<&Basis>) -> Solution {
        let mut best = Incumbent::new(problem);
        let mut report = Report::default();
        let tolerance = self.settings.tolerance;
        if best.residual.value == 0.0 {
            return best.into_solution(tolerance, Status::Solved, 0, report);
        }
        self.scaled.load(problem.A(), problem.b(), problem.scaling());
        if let Err(refusal) = hypotheses::check(&self.scaled, self.settings.relaxation) {
            return best.into_solution(tolerance, Status::Refused(refusal), 0, report);
        }
        let warm = warm.filter(|warm| warm.z_basic.len() == problem.len());
        let start = if warm.is_some() { Start::Warm } else { Start::Zero };
        if let Some(warm) = warm {
            best.offer_basis(&mut self.polish, warm);
        }
        let attempt = if best.residual.within(tolerance) {
            let residual = Some(best.residual.value);
            Attempt { start, outcome: Outcome::Complementary, pivots: 0, factorizations: 1, residual }
        } else {
            self.sweep(&mut best, start, usize::from(warm.is_some()))
        };
        let sweeps = attempt.pivots;
        report.attempts.push(attempt);
        best.into_solution(tolerance, Status::IterationLimit, sweeps, report)
    }

    fn tolerance(&self) -> f64 {
        self.settings.tolerance
    }
}
