use crate::method::check_tolerance;
use crate::polish::Polish;
use crate::{Attempt, Basis, Lcp, LcpError, Method, Outcome, Report, Solution, Start, Status};

/// Settings of [`Enumeration`].
#[derive(Clone, Debug, PartialEq)]
pub struct EnumerationSettings {
    /// Relative residual up to which a point is called solved. Default 1e-10; in (0, 1).
    pub tolerance: f64,
    /// Largest number of pairs accepted; the work is 2ⁿ factorisations. Default 16; at most 24.
    pub max_pairs: usize,
}

impl Default for EnumerationSettings {
    fn default() -> Self {
        Self { tolerance: 1e-10, max_pairs: 16 }
    }
}

/// Solves every complementary basis of a tiny problem: slow, simple, and therefore the oracle of the tests.
///
/// It finds every solution whose basis matrix `A_SS` is regular. Of a singular one it tries the point near the
/// least-norm solution of `A_SS z_S = −b_S` only, so that [`Status::NoSolution`] is a proof where `A` has no
/// singular principal submatrix.
#[derive(Clone, Debug, Default)]
pub struct Enumeration {
    settings: EnumerationSettings,
    polish: Polish,
}

impl Enumeration {
    /// The method with these settings.
    ///
    /// # Errors
    /// [`LcpError::Setting`] when a setting is outside its range.
    pub fn new(settings: EnumerationSettings) -> Result<Self, LcpError> {
        check_tolerance(settings.tolerance)?;
        if settings.max_pairs > 24 {
            let value = settings.max_pairs as f64;
            return Err(LcpError::Setting { setting: "max_pairs", value, range: "at most 24" });
        }
        Ok(Self { settings, polish: Polish::default() })
    }

    /// All basic solutions, each once, in the order of the bases read as binary numbers.
    ///
    /// Returns an empty list when the problem has more than [`max_pairs`](EnumerationSettings::max_pairs) pairs.
    pub fn all(&mut self, problem: &Lcp) -> Vec<Solution> {
        let mut found: Vec<Solution> = Vec::new();
        for code in self.codes(problem) {
            if let Some(solution) = self.solve_basis(problem, code) {
                let scale = problem.scaling().z();
                let distance = |other: &Solution| {
                    (0..problem.len()).fold(0.0f64, |max, i| max.max(scale[i] * (other.z[i] - solution.z[i]).abs()))
                };
                let size = problem.b().iter().fold(0.0f64, |max, b| max.max(b.abs()));
                if found.iter().all(|other| distance(other) > 1e-8 * size) {
                    found.push(solution);
                }
            }
        }
        found
    }

    fn codes(&self, problem: &Lcp) -> std::ops::Range<u32> {
        if problem.len() > self.settings.max_pairs { 0..0 } else { 0..1 << problem.len() }
    }

    fn solve_basis(&mut self, problem: &Lcp, code: u32) -> Option<Solution> {
        let n = problem.len();
        let basis = Basis { z_basic: (0..n).map(|i| code >> i & 1 == 1).collect() };
        let mut z = vec![0.0; n];
        let active = basis.active();
        if !self.polish.solve_active(problem.A(), problem.b(), problem.scaling(), &active, &active, &mut z) {
            return None;
        }
        z.iter_mut().for_each(|z| *z = z.max(0.0));
        let residual = problem.residual(&z);
        residual.within(self.settings.tolerance).then(|| Solution {
            w: problem.w(&z),
            z,
            status: Status::Solved,
            basis,
            iterations: code as usize + 1,
            residual,
            report: report(code as usize + 1, Some(residual.value)),
        })
    }
}

impl Method for Enumeration {
    /// The first basic solution; `warm` is not used.
    fn solve(&mut self, problem: &Lcp, _warm: Option<&Basis>) -> Solution {
        let n = problem.len();
        let codes = self.codes(problem);
        let tried = codes.len();
        if let Some(solution) = codes.into_iter().find_map(|code| self.solve_basis(problem, code)) {
            return solution;
        }
        let z = vec![0.0; n];
        let status = match tried {
            0 => Status::TooLarge { limit: self.settings.max_pairs },
            _ => Status::NoSolution,
        };
        Solution {
            w: problem.w(&z),
            residual: problem.residual(&z),
            z,
            status,
            basis: Basis::slack(n),
            iterations: tried,
            report: report(tried, None),
        }
    }

    fn tolerance(&self) -> f64 {
        self.settings.tolerance
    }
}

fn report(bases: usize, residual: Option<f64>) -> Report {
    let attempt = Attempt {
        start: Start::Enumeration,
        outcome: Outcome::Complementary,
        pivots: 0,
        factorizations: bases,
        residual,
    };
    Report { attempts: vec![attempt] }
}
