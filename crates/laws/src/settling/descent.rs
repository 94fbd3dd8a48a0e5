//! The minimum of a settling step's function on one island: Newton's method with a line search.
//!
//! The function is convex, piecewise quadratic and continuously differentiable. Where a whole Newton step stays on the pieces that it
//! was made for, it ends at the minimum.

use super::SettlingEffort;
use super::law::{BothCones, Law, LawPiece};
use crate::polyhedral::step_length;
use signorini_contact::ContactProblem;
use signorini_contact::WarmStart;
use signorini_contact::vector::dot;
use signorini_solver::{Island, ProximalSystem};

/// The iterate on an island.
#[derive(Clone, Debug, Default)]
pub(super) struct Descent {
    free_velocity: Vec<f64>,
    pub velocity: Vec<f64>,
    /// λ̄, and what bounds friction.
    center: Vec<[f64; 3]>,
    bilateral_center: Vec<f64>,
    law: Vec<Law>,
    /// ρ of each contact and of each bilateral row.
    weight: Vec<f64>,
    pub bilateral_weight: Vec<f64>,
    /// `λ̄ − ρ u` and its projection at the velocity.
    trial: Vec<[f64; 3]>,
    pub impulse: Vec<[f64; 3]>,
    pub bilateral_impulse: Vec<f64>,
    pieces: Vec<LawPiece>,
    factored: Vec<LawPiece>,
    gradient: Vec<f64>,
    step: Vec<f64>,
    /// `J` times the step.
    change: Vec<[f64; 3]>,
    bilateral_change: Vec<f64>,
    momentum: Vec<f64>,
}

impl Descent {
    /// Reads an island, the impulses of the step before and the velocity to begin with.
    pub fn begin(
        &mut self,
        problem: &ContactProblem,
        island: &Island,
        earlier: &WarmStart,
        start: &[f64],
        effort: SettlingEffort,
    ) {
        let SettlingEffort { epsilon, associated, .. } = effort;
        island.gather(&problem.free_velocity, &mut self.free_velocity);
        island.gather(start, &mut self.velocity);
        self.center.clear();
        self.law.clear();
        for &i in &island.units {
            let known = earlier.impulse(i as usize);
            self.center.push(known.unwrap_or([0.0; 3]));
            let bound = known.filter(|_| !associated);
            self.law.push(bound.map_or(Law::Associated, |p| Law::Bounded { normal: p[0] }));
        }
        self.bilateral_center.clear();
        self.bilateral_center.extend(island.bilateral.iter().map(|&k| earlier.bilateral_impulse(k as usize)));
        self.weight.clear();
        self.weight.extend(island.scale.iter().map(|g| 1.0 / (epsilon * g)));
        self.bilateral_weight.clear();
        self.bilateral_weight.extend(island.bilateral_scale.iter().map(|g| 1.0 / (epsilon * g)));
        self.factored.clear();
    }

    /// Goes to the minimum, or as near as so many Newton steps take it; returns the number of factorisations.
    pub fn run(
        &mut self,
        (problem, island): (&ContactProblem, &Island),
        cones: BothCones,
        system: &mut ProximalSystem,
        newton_steps: u32,
    ) -> u32 {
        let (mut whole, mut factorizations) = (false, 0);
        for _ in 0..newton_steps {
            self.evaluate(problem, island, cones);
            // An island of equality constraints alone has no pieces, and is factorised once all the same.
            let same = factorizations > 0 && self.pieces == self.factored;
            if same && whole {
                return factorizations;
            }
            if !same {
                factorizations += 1;
                let (pieces, weight) = (&self.pieces, &self.weight);
                let slope = |c: usize| {
                    let slope = pieces[c].slope(cones, island.units[c] as usize)?;
                    Some(slope.map(|row| row.map(|b| weight[c] * b)))
                };
                if !system.factor_slopes(island, slope) {
                    return factorizations;
                }
                self.factored.clone_from(&self.pieces);
            }
            self.step.clear();
            self.step.extend(self.gradient.iter().map(|g| -g));
            system.solve(island, &mut self.step);
            let length = self.step_length(problem, island, cones);
            self.velocity.iter_mut().zip(&self.step).for_each(|(v, d)| *v += length * d);
            whole = length == 1.0;
        }
        self.evaluate(problem, island, cones);
        factorizations
    }

    /// The largest `ε g |λ − λ̄|`, m/s.
    pub fn slack(&self) -> f64 {
        let mut most = 0.0_f64;
        for ((p, center), rho) in self.impulse.iter().zip(&self.center).zip(&self.weight) {
            most = (0..3).map(|r| (p[r] - center[r]).abs() / rho).fold(most, f64::max);
        }
        for ((p, center), rho) in self.bilateral_impulse.iter().zip(&self.bilateral_center).zip(&self.bilateral_weight)
        {
            most = most.max((p - center).abs() / rho);
        }
        most
    }

    /// Trial impulses, impulses and the gradient `M (v − v^f) − Jᵀλ` at the velocity.
    fn evaluate(&mut self, problem: &ContactProblem, island: &Island, cones: BothCones) {
        self.trial.clear();
        self.impulse.clear();
        self.pieces.clear();
        self.bilateral_impulse.clear();
        self.momentum.clear();
        self.momentum.extend(self.velocity.iter().zip(&self.free_velocity).map(|(v, f)| v - f));
        self.gradient.clear();
        self.gradient.resize(self.velocity.len(), 0.0);
        island.multiply_mass(&problem.mass, &self.momentum, &mut self.gradient);
        for (c, &i) in island.units.iter().enumerate() {
            let u = island.slack(c, &self.velocity);
            let y = std::array::from_fn(|r| self.center[c][r] - self.weight[c] * u[r]);
            let (p, piece) = self.law[c].project(cones, i as usize, y);
            self.trial.push(y);
            self.impulse.push(p);
            self.pieces.push(piece);
            island.jacobian.add_transposed(c, p.map(|p| -p), &mut self.gradient);
        }
        for (k, offset) in island.bilateral_offset.iter().enumerate() {
            let [rate] = island.bilateral_jacobian.multiply(k, &self.velocity);
            let p = self.bilateral_center[k] - self.bilateral_weight[k] * (rate + offset);
            self.bilateral_impulse.push(p);
            island.bilateral_jacobian.add_transposed(k, [-p], &mut self.gradient);
        }
    }

    /// The part of the step after which the slope of the function along it has nearly vanished.
    fn step_length(&mut self, problem: &ContactProblem, island: &Island, cones: BothCones) -> f64 {
        self.change.clear();
        self.change.extend((0..island.units.len()).map(|c| island.jacobian.multiply(c, &self.step)));
        self.bilateral_change.clear();
        let rows = 0..island.bilateral.len();
        self.bilateral_change.extend(rows.map(|k| island.bilateral_jacobian.multiply(k, &self.step)[0]));
        self.momentum.clear();
        self.momentum.resize(self.velocity.len(), 0.0);
        island.multiply_mass(&problem.mass, &self.step, &mut self.momentum);
        let (mut constant, mut rising) = (0.0, 0.0);
        for (k, m) in self.momentum.iter().enumerate() {
            constant += m * (self.velocity[k] - self.free_velocity[k]);
            rising += m * self.step[k];
        }
        let slope = |t: f64| {
            let mut sum = constant + t * rising;
            for (c, &i) in island.units.iter().enumerate() {
                let (y, u, rho) = (self.trial[c], self.change[c], self.weight[c]);
                let moved = std::array::from_fn(|r| y[r] - t * rho * u[r]);
                sum -= dot(self.law[c].project(cones, i as usize, moved).0, u);
            }
            for (k, u) in self.bilateral_change.iter().enumerate() {
                sum -= (self.bilateral_impulse[k] - t * self.bilateral_weight[k] * u) * u;
            }
            sum
        };
        step_length(slope)
    }
}
