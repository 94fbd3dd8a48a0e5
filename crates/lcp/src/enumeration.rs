use derive_setters::Setters;

use crate::equilibrate::Scaled;
use crate::pieces::Piece;
use crate::polish::Polish;
use crate::setting::check_tolerance;
use crate::{Attempt, Basis, Lcp, LcpError, Lemke, Method, Outcome, Report, Residual, Solution, Start, Status};

/// Bases with a relative pivot below this are looked at as singular ones.
const MAYBE_SINGULAR: f64 = 1e-8;

/// Settings of [`Enumeration`].
#[derive(Clone, Debug, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
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

/// All solutions of a tiny problem, as [`Enumeration::solution_set`] finds them.
///
/// The solutions of one complementary basis are a convex polyhedron, so the set is a union of at most 2ⁿ of these: of
/// single points, or of continua.
///
/// Source: Cottle, Pang, Stone (2009), §1.4 (complementary cones).
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SolutionSet {
    /// Different solutions, in the order of their bases read as binary numbers: every solution that is alone in its
    /// basis, and one of every basis that has a continuum.
    pub points: Vec<Solution>,
    /// The bases that have a continuum of solutions; two of each were found and checked.
    pub continua: Vec<Basis>,
}

impl SolutionSet {
    /// Whether `points` are all solutions there are.
    pub fn is_finite(&self) -> bool {
        self.continua.is_empty()
    }
}

/// Tries every complementary basis of a tiny problem: slow, simple, and therefore the oracle of the tests.
///
/// # Guarantee
/// For every matrix, up to rounding: it finds a solution if there is one. Where the matrix `A_αα` of a basis is
/// singular, the solutions of the basis are a polyhedron, and a projection on it decides whether it is empty.
///
/// # Cost
/// 2ⁿ factorisations; a singular basis costs a convex problem with up to n pairs besides.
///
/// # Source
/// Cottle, Pang, Stone, *The Linear Complementarity Problem* (2009), §1.4 and §4.1; Murty (1988), §1.3.
#[derive(Clone, Debug, Default)]
pub struct Enumeration {
    settings: EnumerationSettings,
    scaled: Scaled,
    polish: Polish,
    lemke: Lemke,
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
        Ok(Self { settings, ..Self::default() })
    }

    /// All solutions: see [`SolutionSet`].
    ///
    /// # Errors
    /// [`LcpError::TooManyPairs`] when the problem has more pairs than
    /// [`max_pairs`](EnumerationSettings::max_pairs).
    pub fn solution_set(&mut self, problem: &Lcp) -> Result<SolutionSet, LcpError> {
        let Some(codes) = self.codes(problem) else {
            return Err(LcpError::TooManyPairs { found: problem.len(), limit: self.settings.max_pairs });
        };
        self.load(problem);
        let mut set = SolutionSet { points: Vec::new(), continua: Vec::new() };
        let size = problem.b().iter().fold(0.0f64, |max, b| max.max(b.abs()));
        let near = |a: &Solution, b: &Solution| {
            let apart = |(i, s): (usize, &f64)| s * (a.z[i] - b.z[i]).abs();
            problem.scaling().z().iter().enumerate().map(apart).fold(0.0, f64::max) <= 1e-8 * size
        };
        for code in codes {
            let Some(solution) = self.solve_basis(problem, code) else {
                continue;
            };
            if self.is_continuum(problem, &solution.basis) {
                set.continua.push(solution.basis.clone());
            }
            if !set.points.iter().any(|other| near(other, &solution)) {
                set.points.push(solution);
            }
        }
        Ok(set)
    }

    fn load(&mut self, problem: &Lcp) {
        self.scaled.load(problem.A(), problem.b(), problem.scaling());
    }

    fn codes(&self, problem: &Lcp) -> Option<std::ops::Range<u32>> {
        (problem.len() <= self.settings.max_pairs).then(|| 0..1 << problem.len())
    }

    /// A solution of the basis with this binary number.
    fn solve_basis(&mut self, problem: &Lcp, code: u32) -> Option<Solution> {
        let n = problem.len();
        let basis = Basis { z_basic: (0..n).map(|i| code >> i & 1 == 1).collect() };
        let active = basis.active();
        let mut z = vec![0.0; n];
        let polished = self.polish.solve_active(problem.A(), problem.b(), problem.scaling(), &active, &active, &mut z);
        let (z, residual) = match polished.then_some(z).and_then(|z| self.accepted(problem, z)) {
            Some(found) => found,
            None if self.polish.smallest_pivot < MAYBE_SINGULAR => {
                let piece = Piece::of(&self.scaled, &active)?;
                let point = piece.point(&self.scaled, &mut self.lemke)?;
                self.accepted(problem, point)?
            }
            None => return None,
        };
        let tried = code as usize + 1;
        let report = report(tried, Some(residual.value));
        Some(Solution { w: problem.w(&z), z, status: Status::Solved, basis, iterations: tried, residual, report })
    }

    /// The point without rounding below zero, if it solves the problem.
    fn accepted(&self, problem: &Lcp, mut z: Vec<f64>) -> Option<(Vec<f64>, Residual)> {
        z.iter_mut().for_each(|z| *z = z.max(0.0));
        let residual = problem.residual(&z);
        residual.within(self.settings.tolerance).then_some((z, residual))
    }

    /// Whether a basis has two different solutions, and hence all between them.
    fn is_continuum(&mut self, problem: &Lcp, basis: &Basis) -> bool {
        let extremes =
            Piece::of(&self.scaled, &basis.active()).and_then(|piece| piece.extremes(&self.scaled, &mut self.lemke));
        extremes.is_some_and(|ends| ends.into_iter().all(|z| self.accepted(problem, z).is_some()))
    }
}

impl Method for Enumeration {
    /// The first solution; `warm` is not used.
    fn solve(&mut self, problem: &Lcp, _warm: Option<&Basis>) -> Solution {
        let n = problem.len();
        let codes = self.codes(problem);
        let tried = codes.as_ref().map_or(0, ExactSizeIterator::len);
        if codes.is_some() {
            self.load(problem);
        }
        if let Some(found) = codes.into_iter().flatten().find_map(|code| self.solve_basis(problem, code)) {
            return found;
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
