//! Semismooth Newton methods, globalised by the Fischer–Burmeister merit function.

mod map;

use derive_setters::Setters;
use map::{Jacobian, Point};

use crate::equilibrate::Scaled;
use crate::incumbent::Incumbent;
use crate::linalg::{Lu, dot};
use crate::polish::Polish;
use crate::setting::{check_at_least_one, check_tolerance};
use crate::{Attempt, Basis, Lcp, LcpError, Method, Outcome, Report, Solution, Start, Status};

/// Merit values that a step may be compared with: the largest of the last ones.
const MEMORY: usize = 5;
/// Armijo's parameter.
const DESCENT: f64 = 1e-4;
/// Halvings of a step before its direction is given up.
const HALVINGS: usize = 30;
/// A gradient this small relative to the map, whose data have size 1, is zero.
const FLAT: f64 = 1e-9;
/// Relative pivots below this make a Newton matrix singular.
const NEARLY_SINGULAR: f64 = 1e-14;

/// The map whose zero Newton's method looks for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum NewtonMap {
    /// `√(z² + w²) − z − w`: the map of the merit function itself, smooth but for `z = w = 0`.
    #[default]
    FischerBurmeister,
    /// `min(z, w)`: each step solves the linear system of one complementary basis.
    Minimum,
}

/// Settings of [`SemismoothNewton`].
#[derive(Clone, Debug, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct SemismoothNewtonSettings {
    /// Relative residual up to which a point is called solved. Default 1e-10; in (0, 1).
    pub tolerance: f64,
    /// The map. Default [`NewtonMap::FischerBurmeister`].
    pub map: NewtonMap,
    /// Steps allowed. Default 200; at least 1.
    pub steps: usize,
}

impl Default for SemismoothNewtonSettings {
    fn default() -> Self {
        Self { tolerance: 1e-10, map: NewtonMap::default(), steps: 200 }
    }
}

impl SemismoothNewtonSettings {
    /// Checks every field against its range.
    ///
    /// # Errors
    /// [`LcpError::Setting`] naming the first field outside its range.
    pub fn validate(&self) -> Result<(), LcpError> {
        check_tolerance(self.tolerance)?;
        check_at_least_one("steps", self.steps)
    }
}

/// A semismooth Newton method with a line search on the Fischer–Burmeister merit function `Ψ = ½ Σ φ(z_i, w_i)²`.
///
/// A Newton direction of the chosen map is taken where it descends; else a regularised least-squares direction of the
/// Fischer–Burmeister map; else the negative gradient of `Ψ`. When the signs of the pairs have settled, the linear
/// system of their basis is solved in the original data.
///
/// # Guarantee
/// Every accumulation point of the iterates is stationary for `Ψ`. For P₀-matrices, hence for positive semidefinite
/// ones, a stationary point is a solution, and for R₀-matrices (`0 ≤ z ⟂ A z ≥ 0` for `z = 0` only) the iterates are
/// bounded: the method solves every problem whose matrix is both, P-matrices in particular. Convergence is locally
/// quadratic where the generalised Jacobian is regular. Elsewhere it may stop at a stationary point that is no
/// solution, which is [`Status::Stationary`], or run out of steps.
///
/// # Cost
/// O(n³) per step.
///
/// # Source
/// Fischer (1992); De Luca, Facchinei, Kanzow (1996), *A semismooth equation approach to the solution of nonlinear
/// complementarity problems*; Facchinei, Pang (2003), §9.1; Kanzow (2004) for `min` with this merit function.
#[derive(Clone, Debug, Default)]
pub struct SemismoothNewton {
    settings: SemismoothNewtonSettings,
    scaled: Scaled,
    polish: Polish,
    lu: Lu,
    point: Point,
    trial: Point,
    jacobian: Jacobian,
    newton: Jacobian,
    gradient: Vec<f64>,
    direction: Vec<f64>,
}

/// The three directions, in the order in which they are tried.
#[derive(Clone, Copy)]
enum StepKind {
    Newton,
    LeastSquares,
    Gradient,
}

impl SemismoothNewton {
    /// The method with these settings.
    ///
    /// # Errors
    /// [`LcpError::Setting`] when a setting is outside its range.
    pub fn new(settings: SemismoothNewtonSettings) -> Result<Self, LcpError> {
        settings.validate()?;
        Ok(Self { settings, ..Self::default() })
    }

    fn iterate(&mut self, best: &mut Incumbent, attempt: &mut Attempt) -> Status {
        let mut merits = [f64::NEG_INFINITY; MEMORY];
        let (mut last, mut tried) = (Basis::default(), Basis::default());
        self.point.evaluate(&self.scaled);
        loop {
            self.offer(best, attempt, &mut last, &mut tried);
            if best.residual.within(self.settings.tolerance) {
                attempt.outcome = Outcome::Complementary;
                return Status::Solved;
            }
            self.jacobian.fischer_burmeister(&self.scaled, &self.point);
            self.jacobian.transposed_times(&self.scaled, &self.point.phi, &mut self.gradient);
            let gradient = self.gradient.iter().fold(0.0f64, |max, x| max.max(x.abs()));
            let gradient = gradient / (2.0 * self.point.merit).sqrt();
            if self.point.merit == 0.0 {
                attempt.outcome = Outcome::Complementary;
                return Status::Inaccurate;
            }
            if attempt.pivots >= self.settings.steps {
                attempt.outcome = Outcome::IterationLimit;
                return Status::IterationLimit;
            }
            merits[attempt.pivots % MEMORY] = self.point.merit;
            let reference = merits.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let directions = [StepKind::Newton, StepKind::LeastSquares, StepKind::Gradient];
            let moves = gradient > FLAT && directions.into_iter().any(|kind| self.try_step(kind, reference, attempt));
            if !moves {
                attempt.outcome = Outcome::Stationary;
                return Status::Stationary { gradient };
            }
            attempt.pivots += 1;
        }
    }

    /// Offers the point, and the solution of the basis of its signs once these have settled.
    fn offer(&mut self, best: &mut Incumbent, attempt: &mut Attempt, last: &mut Basis, tried: &mut Basis) {
        let point = &self.point;
        let basis = Basis::from_signs(&point.z, &point.w);
        let z = point.z.iter().enumerate().map(|(j, &z)| self.scaled.unscaled_z(j, z)).collect();
        let residual = best.offer(z, &basis);
        let settled = basis == *last || residual.within(self.settings.tolerance);
        if settled && basis != *tried {
            attempt.factorizations += 1;
            best.offer_basis(&mut self.polish, &basis);
            tried.clone_from(&basis);
        }
        *last = basis;
        attempt.residual = Some(best.residual.value);
    }

    /// Moves along a direction if it descends enough.
    fn try_step(&mut self, kind: StepKind, reference: f64, attempt: &mut Attempt) -> bool {
        let found = match kind {
            StepKind::Newton => self.newton_direction(attempt),
            StepKind::LeastSquares => self.least_squares_direction(attempt),
            StepKind::Gradient => {
                self.direction.clear();
                self.direction.extend(self.gradient.iter().map(|x| -x));
                true
            }
        };
        let slope = dot(&self.gradient, &self.direction);
        let length = dot(&self.direction, &self.direction);
        let gradient = dot(&self.gradient, &self.gradient);
        // A negligible angle to the level set counts as no descent.
        let descends = slope < 0.0 && slope * slope > 1e-16 * length * gradient && length.is_finite();
        if !found || !descends {
            return false;
        }
        let mut step = 1.0;
        for _ in 0..HALVINGS {
            self.trial.move_from(&self.point, &self.direction, step, &self.scaled);
            if self.trial.merit <= reference + DESCENT * step * slope {
                std::mem::swap(&mut self.point, &mut self.trial);
                return true;
            }
            step *= 0.5;
        }
        false
    }

    /// The Newton direction of the chosen map; false where its matrix is singular.
    fn newton_direction(&mut self, attempt: &mut Attempt) -> bool {
        let jacobian = match self.settings.map {
            NewtonMap::FischerBurmeister => &self.jacobian,
            NewtonMap::Minimum => {
                self.newton.minimum(&self.point);
                &self.newton
            }
        };
        jacobian.fill(&self.scaled, self.lu.start(self.scaled.n));
        attempt.factorizations += 1;
        if self.lu.factorize() < NEARLY_SINGULAR {
            return false;
        }
        self.direction.clear();
        match self.settings.map {
            NewtonMap::FischerBurmeister => self.direction.extend(self.point.phi.iter().map(|x| -x)),
            NewtonMap::Minimum => {
                self.direction.extend(self.point.z.iter().zip(&self.point.w).map(|(z, w)| -z.min(*w)))
            }
        }
        self.lu.solve(&mut self.direction);
        true
    }

    /// `(HᵀH + νI) d = −∇Ψ` with `H` of the Fischer–Burmeister map, a descent direction for every ν > 0.
    fn least_squares_direction(&mut self, attempt: &mut Attempt) -> bool {
        let n = self.scaled.n;
        let mut H = vec![0.0; n * n];
        self.jacobian.fill(&self.scaled, &mut H);
        let columns: Vec<f64> = (0..n * n).map(|k| H[k % n * n + k / n]).collect();
        let damping = 1e-4 * (2.0 * self.point.merit).sqrt().min(1.0);
        for (k, x) in self.lu.start(n).iter_mut().enumerate() {
            let (i, j) = (k / n, k % n);
            let diagonal = if i == j { damping } else { 0.0 };
            *x = dot(&columns[i * n..(i + 1) * n], &columns[j * n..(j + 1) * n]) + diagonal;
        }
        attempt.factorizations += 1;
        if self.lu.factorize() == 0.0 {
            return false;
        }
        self.direction.clear();
        self.direction.extend(self.gradient.iter().map(|x| -x));
        self.lu.solve(&mut self.direction);
        true
    }
}

impl Method for SemismoothNewton {
    /// Solves the problem, from the point of the basis `warm` where one is given and fits.
    fn solve(&mut self, problem: &Lcp, warm: Option<&Basis>) -> Solution {
        let mut best = Incumbent::new(problem);
        let mut report = Report::default();
        let tolerance = self.settings.tolerance;
        if best.residual.value == 0.0 {
            return best.into_solution(tolerance, Status::Solved, 0, report);
        }
        let warm = warm.filter(|warm| warm.z_basic.len() == problem.len());
        let start = if warm.is_some() { Start::Warm } else { Start::Zero };
        let mut attempt =
            Attempt { start, outcome: Outcome::Complementary, pivots: 0, factorizations: 0, residual: None };
        if let Some(warm) = warm {
            attempt.factorizations = 1;
            attempt.residual = best.offer_basis(&mut self.polish, warm).map(|residual| residual.value);
        }
        let mut status = Status::Solved;
        if !best.residual.within(tolerance) {
            self.scaled.load(problem.A(), problem.b(), problem.scaling());
            self.point.z.clear();
            let scaled = &self.scaled;
            self.point.z.extend(best.z.iter().enumerate().map(|(j, z)| z / scaled.unscaled_z(j, 1.0)));
            status = self.iterate(&mut best, &mut attempt);
        }
        let steps = attempt.pivots;
        report.attempts.push(attempt);
        best.into_solution(tolerance, status, steps, report)
    }

    fn tolerance(&self) -> f64 {
        self.settings.tolerance
    }
}
