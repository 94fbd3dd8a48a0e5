//! Lexicographic Lemke with a factorised basis.
//!
//! Contact problems are always degenerate: tolerances in the ratio test, not the method, are where Lemke's method
//! fails in practice. Here the problem is equilibrated by powers of two; the basis is kept as factors, never as a
//! rounded tableau; ties are resolved lexicographically; a small pivot or a ray is believed only after a fresh,
//! refined factorisation; and the complementary basis found is solved afresh from the original data. When the
//! result fails its residual, the walk is repeated from elsewhere, and the report says so.

mod path;
mod settings;

use path::{Limits, Path, Walk};
pub use settings::LemkeSettings;

use crate::direction::Direction;
use crate::equilibrate::Scaled;
use crate::fingerprint::mix;
use crate::incumbent::Incumbent;
use crate::polish::Polish;
use crate::{Attempt, Basis, Lcp, LcpError, Method, Outcome, Report, Solution, Start, Status};

/// Diagonal entries of the equilibrated matrix below this count as zero.
const NO_DIAGONAL: f64 = 1e-9;

/// From this one on, covering vectors have entries from 1/WIDE to WIDE: a path that leads elsewhere.
const WIDE_FROM: u32 = 3;
const WIDE: f64 = 64.0;

/// Lemke's complementary pivoting method.
///
/// # Guarantee
/// For copositive-plus matrices, which all positive semidefinite and all strictly copositive ones are, it ends at a
/// solution or on a ray that proves infeasibility ([`Status::Infeasible`] where the ray itself is the proof; else
/// [`infeasibility`](crate::infeasibility) finds one); for P-matrices at the solution; for copositive matrices at a solution if
/// `bᵀz ≥ 0` for every `z` with `0 ≤ z ⟂ A z ≥ 0`, which covers contact problems without penetration. For other
/// matrices it may end on a ray although there is a solution.
///
/// # Cost
/// O(n·k) per pivot with k basic `z`, plus O(k³) every [`updates`](LemkeSettings::updates) pivots.
///
/// # Source
/// Lemke (1965); Cottle, Pang, Stone, *The Linear Complementarity Problem* (2009), §4.4 and §4.9.
#[derive(Clone, Debug, Default)]
pub struct Lemke {
    settings: LemkeSettings,
    scaled: Scaled,
    path: Path,
    polish: Polish,
    cover: Vec<f64>,
    perturbation: Vec<f64>,
}

/// The best point so far and what is known about the problem.
struct Search<'a> {
    best: Incumbent<'a>,
    ray: Option<Direction>,
    status: Option<Status>,
    pivots: usize,
    report: Report,
}

impl Lemke {
    /// The method with these settings.
    ///
    /// # Errors
    /// [`LcpError::Setting`] when a setting is outside its range.
    pub fn new(settings: LemkeSettings) -> Result<Self, LcpError> {
        settings.validate()?;
        Ok(Self { settings, ..Self::default() })
    }

    /// The method with other settings and the same memory.
    ///
    /// # Errors
    /// [`LcpError::Setting`] when a setting is outside its range.
    pub fn set(&mut self, settings: LemkeSettings) -> Result<(), LcpError> {
        settings.validate()?;
        self.settings = settings;
        Ok(())
    }

    fn load(&mut self, problem: &Lcp) {
        self.scaled.load(problem.A(), problem.b(), problem.scaling());
    }

    /// The caller's basis: one factorisation, and only if that is not the answer, pivots from there.
    fn try_warm(&mut self, search: &mut Search, warm: &Basis) {
        let residual = self.finish(search, warm.clone(), None);
        let outcome = if search.status.is_some() { Outcome::Complementary } else { Outcome::Rejected };
        search.note(Start::Warm, outcome, None, residual);
    }

    /// Walks once and keeps the result if it is the best.
    fn attempt(&mut self, search: &mut Search, start: Start, from: &Basis, seed: u32, tie: f64) {
        let n = search.best.problem.len();
        self.choose_vectors(n, seed);
        let limits = Limits {
            pivots: self.settings.pivots_per_pair * n + 100,
            updates: self.settings.updates,
            tie,
            pivot: self.settings.pivot,
            confirm: seed < WIDE_FROM || search.ray.is_none(),
        };
        let walk = self.path.walk(&self.scaled, &from.z_basic, &self.cover, &self.perturbation, limits);
        let residual = match walk.outcome {
            Outcome::Complementary => {
                let (basis, z) = self.end_point(n);
                self.finish(search, basis, Some(z))
            }
            Outcome::Ray => {
                if limits.confirm {
                    self.keep_ray(search, &walk);
                }
                None
            }
            _ => None,
        };
        search.note(start, walk.outcome, Some(walk), residual);
    }

    /// Covering vector and perturbation number `seed`; number 0 has the covering vector of ones, later ones differ the more from it.
    fn choose_vectors(&mut self, n: usize, seed: u32) {
        let uniform = |stream: u32, i: usize| {
            let bits = mix(u64::from(stream) << 32 | i as u64) >> 11;
            1.0 + bits as f64 / (1u64 << 53) as f64
        };
        // Rows without a diagonal are bounds on other variables (friction, say): how far these are relaxed at the
        // start decides how long the path is.
        let bound_weight = [1.0, 8.0, 0.125][seed as usize % 3];
        self.cover.clear();
        for i in 0..n {
            let weight = if self.scaled.column(i)[i].abs() < NO_DIAGONAL { bound_weight } else { 1.0 };
            self.cover.push(match seed {
                0 => 1.0,
                1..WIDE_FROM => weight * uniform(2 * seed, i),
                _ => WIDE.powf(2.0 * uniform(2 * seed, i) - 3.0),
            });
        }
        self.perturbation.clear();
        self.perturbation.extend((0..n).map(|i| uniform(2 * seed + 1, i)));
    }

    /// Basis and point at the end of the walk.
    fn end_point(&self, n: usize) -> (Basis, Vec<f64>) {
        let mut basis = Basis::slack(n);
        let mut z = vec![0.0; n];
        for (&variable, &x) in self.path.basis.head.iter().zip(&self.path.x) {
            if (n..2 * n).contains(&variable) {
                basis.z_basic[variable - n] = true;
                z[variable - n] = self.scaled.unscaled_z(variable - n, x);
            }
        }
        (basis, z)
    }

    /// Solves the basis afresh from the original data and keeps the better of that point and the pivoted one.
    fn finish(&mut self, search: &mut Search, basis: Basis, pivoted: Option<Vec<f64>>) -> Option<f64> {
        let tolerance = self.settings.tolerance;
        let solved = search.best.offer_basis(&mut self.polish, &basis);
        let mut best = solved.map(|residual| residual.value);
        if let Some(z) = pivoted.filter(|_| !solved.is_some_and(|residual| residual.within(tolerance))) {
            let residual = search.best.offer(z, &basis).value;
            best = Some(best.unwrap_or(f64::INFINITY).min(residual));
        }
        if best.is_some_and(|residual| residual <= tolerance) {
            search.status = Some(Status::Solved);
        }
        best
    }

    fn keep_ray(&mut self, search: &mut Search, walk: &Walk) {
        let Some(direction) = Direction::of(&self.scaled, &self.path.basis, &self.path.a, walk.entering) else {
            return;
        };
        search.status = direction.certificate(&self.scaled).map(Status::Infeasible);
        search.ray.get_or_insert(direction);
    }

    /// The attempts, from the cheapest to the most patient, until one settles the problem.
    fn run(&mut self, search: &mut Search, warm: Option<&Basis>) {
        let n = search.best.problem.len();
        let warm = warm.filter(|warm| warm.z_basic.len() == n);
        if let Some(warm) = warm {
            self.try_warm(search, warm);
            if search.status.is_some() {
                return;
            }
        }
        self.load(search.best.problem);
        if let Some(warm) = warm {
            self.attempt(search, Start::Advanced, warm, 0, self.settings.tie);
        }
        self.run_cold(search);
        // Regularisation helps against ties that were not resolved, not against a ray or a long path.
        let helps = |outcome: &Outcome| search.ended(*outcome);
        if self.settings.regularizes && [Outcome::Complementary, Outcome::Cycle, Outcome::Singular].iter().any(helps) {
            self.run_regularized(search);
        }
    }

    fn run_cold(&mut self, search: &mut Search) {
        let slack = Basis::slack(search.best.problem.len());
        for covering in 0..self.settings.covering_vectors {
            if search.status.is_some() {
                return;
            }
            // Other ties are seen when the tolerance is another.
            let tie = self.settings.tie * [1.0, 1e-2, 1e2][covering as usize % 3];
            self.attempt(search, Start::Cold { covering }, &slack, covering, tie);
            if search.status.is_none() && search.ended(Outcome::Complementary) {
                // A basis taken for feasible within the tie tolerance is repaired with a finer one.
                let basis = search.best.basis.clone();
                self.attempt(search, Start::Advanced, &basis, covering, 1e-3 * tie);
            }
        }
    }

    fn run_regularized(&mut self, search: &mut Search) {
        let slack = Basis::slack(search.best.problem.len());
        for exponent in [-8, -6, -4] {
            if search.status.is_some() {
                return;
            }
            self.scaled.add_diagonal(10f64.powi(exponent));
            self.attempt(search, Start::Regularized { exponent }, &slack, 0, self.settings.tie);
            self.load(search.best.problem);
        }
    }
}

impl Method for Lemke {
    fn solve(&mut self, problem: &Lcp, warm: Option<&Basis>) -> Solution {
        let mut search =
            Search { best: Incumbent::new(problem), ray: None, status: None, pivots: 0, report: Report::default() };
        if search.best.residual.value == 0.0 {
            search.status = Some(Status::Solved);
        } else {
            self.run(&mut search, warm);
        }
        search.into_solution(&self.scaled, self.settings.tolerance)
    }

    fn tolerance(&self) -> f64 {
        self.settings.tolerance
    }
}

impl Search<'_> {
    fn note(&mut self, start: Start, outcome: Outcome, walk: Option<Walk>, residual: Option<f64>) {
        let (pivots, factorizations) = walk.map_or((0, 1), |walk| (walk.pivots, walk.factorizations));
        self.pivots += pivots;
        self.report.attempts.push(Attempt { start, outcome, pivots, factorizations, residual });
    }

    /// Whether a walk on the problem itself (not a regularised one) ended so.
    fn ended(&self, outcome: Outcome) -> bool {
        let regularized = |start| matches!(start, Start::Regularized { .. });
        self.report.attempts.iter().any(|attempt| attempt.outcome == outcome && !regularized(attempt.start))
    }

    fn into_solution(mut self, scaled: &Scaled, tolerance: f64) -> Solution {
        let otherwise = match (self.status.take(), &self.ray) {
            (Some(status), _) => status,
            (None, _) if self.ended(Outcome::Complementary) => Status::Inaccurate,
            (None, Some(direction)) => Status::Ray(direction.unscaled(scaled, self.best.problem.scaling().z())),
            (None, None) if self.ended(Outcome::IterationLimit) || self.ended(Outcome::Cycle) => Status::IterationLimit,
            (None, None) => Status::Singular,
        };
        self.best.into_solution(tolerance, otherwise, self.pivots, self.report)
    }
}
