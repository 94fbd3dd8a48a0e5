//! A start for the exact iterations of a large island: the convex relaxation, by Newton's method with a line search.
//!
//! With the orthogonal projection onto the circular friction cone `K` in place of the laws' own, the proximal problem is the
//! minimum over `v` of
//!
//! `½ (v − v^f)ᵀ M (v − v^f) + Σ ½ ‖P_K(λ̄_c − ρ_c u_c)‖² / ρ_c`,
//!
//! which is convex and has continuous derivatives: Newton's steps with an exact line search end at it from anywhere. As ε → 0
//! it becomes Anitescu's relaxation (Anitescu 2006), which is the solution where nothing slides. Its impulses and modes are
//! never an answer: the exact iterations begin there.

use super::island::Island;
use super::island_solver::IslandSolver;
use super::mode::Cones;
use crate::ContactProblem;

/// ε of the relaxation, relative to each contact's Delassus block.
const WEIGHT: f64 = 1e-2;
/// Newton steps.
const STEPS: u32 = 25;
/// The steps end when the momentum's error is below this part of the largest impulse.
const TOLERANCE: f64 = 1e-3;
/// Part of its first value to which a line search brings the slope.
const SLOPE: f64 = 0.1;

/// Memory of the convex start.
#[derive(Clone, Debug, Default)]
pub(crate) struct ConvexStart {
    /// `M (v − v^f) − Jᵀ λ`.
    gradient: Vec<f64>,
    /// `M (v − v^f)`, and its change along the direction.
    momentum: Vec<f64>,
    momentum_rate: Vec<f64>,
    direction: Vec<f64>,
    /// `y = λ̄ − ρ u` and its rate along the direction.
    y: Vec<[f64; 3]>,
    rate: Vec<[f64; 3]>,
    bilateral: Vec<f64>,
    bilateral_rate: Vec<f64>,
}

impl IslandSolver {
    /// Moves the centre and the velocity to the relaxation's solution and guesses the modes from it. Needs an evaluated
    /// centre; leaves one. `false` if a system is singular.
    pub(super) fn convex_start(&mut self, problem: &ContactProblem, cones: &Cones, island: &Island) -> bool {
        let mut convex = std::mem::take(&mut self.convex);
        let done = convex.run(self, problem, cones, island);
        self.convex = convex;
        done
    }
}

impl ConvexStart {
    fn run(&mut self, solver: &mut IslandSolver, problem: &ContactProblem, cones: &Cones, island: &Island) -> bool {
        solver.set_weights(island, WEIGHT);
        solver.evaluate_centre(problem, cones, island);
        solver.system.prepare(problem, island, &solver.bilateral_weight);
        self.begin(solver, problem, island);
        if !self.minimise(solver, problem, cones, island) {
            return false;
        }
        for c in 0..island.units.len() {
            solver.impulse[c] = project(cones, island, c, self.y[c]);
        }
        solver.bilateral_impulse.clone_from(&self.bilateral);
        solver.set_bounds(problem, island);
        solver.evaluate_centre(problem, cones, island);
        solver.modes.clear();
        solver.guess_modes(cones, island);
        true
    }

    /// `y` and the momentum at the solver's velocity.
    fn begin(&mut self, solver: &IslandSolver, problem: &ContactProblem, island: &Island) {
        self.y.clear();
        for (c, p) in solver.impulse.iter().enumerate() {
            let (u, rho) = (solver.slack[c], solver.weight[c]);
            let u = island.pushing(c, u);
            self.y.push(std::array::from_fn(|r| p[r] - rho * u[r]));
        }
        self.bilateral.clear();
        for (k, p) in solver.bilateral_impulse.iter().enumerate() {
            self.bilateral.push(p - solver.bilateral_weight[k] * solver.bilateral_slack[k]);
        }
        self.direction.clear();
        self.direction.extend(solver.velocity.iter().zip(&solver.free_velocity).map(|(v, f)| v - f));
        self.momentum.clear();
        self.momentum.resize(island.nv(), 0.0);
        island.multiply_mass(&problem.mass, &self.direction, &mut self.momentum);
    }

    fn minimise(
        &mut self,
        solver: &mut IslandSolver,
        problem: &ContactProblem,
        cones: &Cones,
        island: &Island,
    ) -> bool {
        for _ in 0..STEPS {
            let size = self.find_gradient(cones, island);
            let error = self.gradient.iter().fold(0.0_f64, |m, g| m.max(g.abs()));
            if error <= TOLERANCE * size {
                break;
            }
            solver.effort.factorizations += 1;
            let slope = |c: usize| slope(cones, island, c, self.y[c], solver.weight[c]);
            if !solver.system.factor_slopes(island, slope) {
                return false;
            }
            self.direction.clear();
            self.direction.extend(self.gradient.iter().map(|g| -g));
            solver.system.solve(island, &mut self.direction);
            self.find_rates(solver, problem, island);
            let step = self.line_search(solver, cones, island);
            if step == 0.0 {
                break;
            }
            self.advance(solver, step);
        }
        true
    }

    /// Computes the gradient; returns the largest impulse in it.
    fn find_gradient(&mut self, cones: &Cones, island: &Island) -> f64 {
        self.gradient.clone_from(&self.momentum);
        let mut size = self.momentum.iter().fold(0.0_f64, |m, p| m.max(p.abs()));
        for c in 0..island.units.len() {
            let p = project(cones, island, c, self.y[c]);
            size = size.max(p[0]);
            island.add_impulse(c, p.map(|x| -x), &mut self.gradient);
        }
        for (k, &p) in self.bilateral.iter().enumerate() {
            size = size.max(p.abs());
            island.bilateral_jacobian.add_transposed(k, [-p], &mut self.gradient);
        }
        size
    }

    /// How `y` and the momentum change along the direction.
    fn find_rates(&mut self, solver: &IslandSolver, problem: &ContactProblem, island: &Island) {
        self.rate.clear();
        for c in 0..island.units.len() {
            let u = island.pushing(c, island.jacobian.multiply(c, &self.direction));
            self.rate.push(u.map(|u| -solver.weight[c] * u));
        }
        self.bilateral_rate.clear();
        for (k, rho) in solver.bilateral_weight.iter().enumerate() {
            let [u] = island.bilateral_jacobian.multiply(k, &self.direction);
            self.bilateral_rate.push(-rho * u);
        }
        self.momentum_rate.clear();
        self.momentum_rate.resize(island.nv(), 0.0);
        island.multiply_mass(&problem.mass, &self.direction, &mut self.momentum_rate);
    }

    /// The minimum along the direction: the zero of a slope that grows with the step.
    fn line_search(&self, solver: &IslandSolver, cones: &Cones, island: &Island) -> f64 {
        let first = self.slope_at(0.0, solver, cones, island);
        if first >= 0.0 {
            return 0.0;
        }
        let (mut low, mut low_slope) = (0.0, first);
        let (mut high, mut high_slope) = (1.0, self.slope_at(1.0, solver, cones, island));
        if high_slope.abs() <= -SLOPE * first {
            return 1.0;
        }
        while high_slope < 0.0 {
            if high >= 16.0 {
                return high;
            }
            (low, low_slope) = (high, high_slope);
            high *= 2.0;
            high_slope = self.slope_at(high, solver, cones, island);
        }
        for _ in 0..12 {
            let part = (low_slope / (low_slope - high_slope)).clamp(0.05, 0.95);
            let middle = low + part * (high - low);
            let slope = self.slope_at(middle, solver, cones, island);
            if slope.abs() <= -SLOPE * first {
                return middle;
            }
            if slope < 0.0 {
                (low, low_slope) = (middle, slope);
            } else {
                (high, high_slope) = (middle, slope);
            }
        }
        0.5 * (low + high)
    }

    fn slope_at(&self, step: f64, solver: &IslandSolver, cones: &Cones, island: &Island) -> f64 {
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut slope = dot(&self.momentum, &self.direction) + step * dot(&self.momentum_rate, &self.direction);
        for c in 0..island.units.len() {
            let (y, rate) = (self.y[c], self.rate[c]);
            let p = project(cones, island, c, std::array::from_fn(|r| y[r] + step * rate[r]));
            slope += (p[0] * rate[0] + p[1] * rate[1] + p[2] * rate[2]) / solver.weight[c];
        }
        for (k, rho) in solver.bilateral_weight.iter().enumerate() {
            slope += (self.bilateral[k] + step * self.bilateral_rate[k]) * self.bilateral_rate[k] / rho;
        }
        slope
    }

    fn advance(&mut self, solver: &mut IslandSolver, step: f64) {
        for (y, rate) in self.y.iter_mut().zip(&self.rate) {
            *y = std::array::from_fn(|r| y[r] + step * rate[r]);
        }
        let along = |x: &mut [f64], rate: &[f64]| x.iter_mut().zip(rate).for_each(|(x, r)| *x += step * r);
        along(&mut self.bilateral, &self.bilateral_rate);
        along(&mut self.momentum, &self.momentum_rate);
        along(&mut solver.velocity, &self.direction);
    }
}

/// The orthogonal projection of unit `c`: of a contact onto the circular cone `‖λ_T‖ ≤ μ λ_N`, of a friction group onto its
/// polygon at the bound of the start.
fn project(cones: &Cones, island: &Island, c: usize, y: [f64; 3]) -> [f64; 3] {
    let i = island.units[c] as usize;
    if c >= island.contact_count {
        return cones.project(i, cones.mode_at(i, y), y);
    }
    let (mu, [a, b]) = (cones.friction(i), cones.admissible(i, [y[1], y[2]]));
    let t = a.hypot(b);
    if t <= mu * y[0] {
        return [y[0], a, b];
    }
    let n = (y[0] + mu * t) / (1.0 + mu * mu);
    if n <= 0.0 {
        return [0.0; 3];
    }
    let s = mu * n / t;
    [n, s * a, s * b]
}

/// Its slope times ρ; none where it is 0.
fn slope(cones: &Cones, island: &Island, c: usize, y: [f64; 3], rho: f64) -> Option<[[f64; 3]; 3]> {
    let i = island.units[c] as usize;
    if c >= island.contact_count {
        let b = cones.slope(i, cones.mode_at(i, y));
        return Some(std::array::from_fn(|r| std::array::from_fn(|k| if k == 0 { 0.0 } else { rho * b[r][k] })));
    }
    let (mu, [a, b]) = (cones.friction(i), cones.admissible(i, [y[1], y[2]]));
    let t = a.hypot(b);
    let n = (y[0] + mu * t) / (1.0 + mu * mu);
    if t <= mu * y[0] {
        let [[aa, ab], [_, bb]] = [cones.admissible(i, [1.0, 0.0]), cones.admissible(i, [0.0, 1.0])];
        return (y[0] > 0.0).then_some([[rho, 0.0, 0.0], [0.0, rho * aa, rho * ab], [0.0, rho * ab, rho * bb]]);
    }
    if n <= 0.0 {
        return None;
    }
    let along = [1.0, mu * a / t, mu * b / t];
    let across = [0.0, -b / t, a / t];
    let (f, g) = (rho / (1.0 + mu * mu), rho * mu * n / t);
    let g = if cones.admissible(i, [across[1], across[2]]) == [0.0; 2] { 0.0 } else { g };
    Some(std::array::from_fn(|r| std::array::from_fn(|c| f * along[r] * along[c] + g * across[r] * across[c])))
}
