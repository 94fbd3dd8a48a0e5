//! Proximal iterations on one island.
//!
//! Around a centre `λ̄` the proximal problem is `λ_c = P_c(λ̄_c − ρ_c u_c)`, `M(v − v^f) = Jᵀλ`, `u = J v + (φ/Δt, 0, 0)`,
//! with `ρ_c = 1/(ε g_c)` and `g_c` the scale of the contact's Delassus block. It has a regular system however redundant the
//! contacts are, and a fixed point of `λ̄ ← λ` solves the contact problem exactly. Everything is computed in differences from
//! `λ̄`, so that the last iterations work with small numbers and reach rounding.

use super::SolverSettings;
use super::island::Island;
use super::mode::{Cones, Mode};
use super::path::{Path, PathOutcome, Shift};
use super::system::ProximalSystem;
use crate::ContactProblem;

/// A proximal iteration that leaves more than this part of the residual calls for another ε.
const SLOW: f64 = 0.1;
/// The velocity is refined where its error times the largest impulse, both relative, exceeds this.
const REFINE: f64 = 1e-12;
/// Newton steps without a better set of modes before they are given up.
const NEWTON_PATIENCE: u32 = 2;
/// Cosine between two changes of the impulses that counts as the same direction.
const PARALLEL: f64 = 0.99;
/// Below this residual changes of the impulses may be rounding, and are not extrapolated.
const NOISE: f64 = 1e-11;
/// The factor between one ε and the next.
const WEIGHT_STEP: f64 = 1e2;
/// Below this residual a slow iteration is a matter of rounding: ε goes up. Above it the impulses still have a long way to
/// go in directions of small Delassus eigenvalues, or a contact that has to slide is still inside its cone: ε goes down.
const ROUNDING_FLOOR: f64 = 1e-10;
/// ε of the last iterations. The rounding of `u` enters the impulses divided by ε: once a small ε has found the impulses in
/// the directions of small eigenvalues, larger ones remove that noise from the others.
const LARGEST_WEIGHT: f64 = 1e-3;

/// Counters of one island's solve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Effort {
    pub factorizations: u32,
    pub mode_changes: u32,
    pub proximal_iterations: u32,
}

/// The solver's memory and, during a solve, its iterate.
#[derive(Clone, Debug, Default)]
pub(crate) struct IslandSolver {
    pub system: ProximalSystem,
    path: Path,
    /// ρ of each contact and of each bilateral row.
    pub weight: Vec<f64>,
    bilateral_weight: Vec<f64>,
    /// Largest diagonal entry of each contact's Delassus block, and of each bilateral row.
    scale: Vec<f64>,
    bilateral_scale: Vec<f64>,
    /// `max|b|` of the island.
    velocity_scale: f64,
    free_velocity: Vec<f64>,
    /// The velocity that goes with `impulse`.
    pub velocity: Vec<f64>,
    /// The centre and, at the end, the solution.
    pub impulse: Vec<[f64; 3]>,
    pub bilateral_impulse: Vec<f64>,
    pub modes: Vec<Mode>,
    /// `u` at the centre.
    slack: Vec<[f64; 3]>,
    bilateral_slack: Vec<f64>,
    /// `λ̄ − ρ u`.
    pub trial: Vec<[f64; 3]>,
    /// Trial impulse of the current solution of the proximal problem.
    pub y: Vec<[f64; 3]>,
    work: Vec<f64>,
    /// Global degrees of freedom, all zero.
    scratch: Vec<f64>,
    /// What the last proximal iteration added to the impulses, and the one before it.
    change: Vec<[f64; 3]>,
    earlier_change: Vec<[f64; 3]>,
    bilateral_change: Vec<f64>,
    /// The best modes of the Newton steps.
    newton_best: Vec<Mode>,
    best: Vec<[f64; 3]>,
    best_bilateral: Vec<f64>,
    best_modes: Vec<Mode>,
    pub effort: Effort,
}

impl IslandSolver {
    /// Reads an island and the start: impulses and modes from a warm start, or zero and open.
    pub fn start(&mut self, problem: &ContactProblem, island: &Island) {
        island.gather(&problem.free_velocity, &mut self.free_velocity);
        self.velocity.resize(island.nv(), 0.0);
        self.work.clear();
        self.work.resize(island.nv(), 0.0);
        self.scratch.resize(problem.nv(), 0.0);
        self.find_scales(problem, island);
        self.effort = Effort::default();
        self.impulse.clear();
        self.impulse.resize(island.contacts.len(), [0.0; 3]);
        self.bilateral_impulse.clear();
        self.bilateral_impulse.resize(island.bilateral.len(), 0.0);
        self.modes.clear();
        self.change.clear();
        self.earlier_change.clear();
        self.bilateral_change.clear();
        self.bilateral_change.resize(island.bilateral.len(), 0.0);
    }

    fn find_scales(&mut self, problem: &ContactProblem, island: &Island) {
        self.scale.clear();
        self.bilateral_scale.clear();
        self.velocity_scale = 0.0;
        for (k, &i) in island.contacts.iter().enumerate() {
            let g = problem.delassus_diagonal(i as usize, &mut self.scratch).into_iter().fold(0.0, f64::max);
            self.scale.push(if g > 0.0 { g } else { 1.0 });
            let c = island.jacobian.multiply(k, &self.free_velocity);
            let b = (c[0] + problem.gap[i as usize] / problem.timestep).abs().max(c[1].abs()).max(c[2].abs());
            self.velocity_scale = self.velocity_scale.max(b);
        }
        for (k, &i) in island.bilateral.iter().enumerate() {
            let g = problem.bilateral_delassus(i as usize, &mut self.scratch);
            self.bilateral_scale.push(if g > 0.0 { g } else { 1.0 });
            let [c] = island.bilateral_jacobian.multiply(k, &self.free_velocity);
            let b = (c + problem.bilateral_violation[i as usize] / problem.timestep).abs();
            self.velocity_scale = self.velocity_scale.max(b);
        }
    }

    /// Runs proximal iterations from the present centre and modes until the residual (of the contact laws, relative to
    /// the island's velocity scale) is at `settings.polish` or stops falling. Returns the residual of what is in `impulse`.
    pub fn run(
        &mut self,
        problem: &ContactProblem,
        cones: &Cones,
        island: &Island,
        settings: &SolverSettings,
        attempt: u32,
    ) -> f64 {
        let mut epsilon = settings.proximal_weight;
        self.set_weights(problem, island, epsilon);
        let (mut best, mut last, mut slow) = (f64::INFINITY, f64::INFINITY, 0);
        let (mut factored, mut ascending) = (false, false);
        for _ in 0..settings.max_proximal_iterations {
            let residual = self.evaluate_centre(problem, cones, island);
            if residual < best {
                best = residual;
                self.keep_best();
            }
            if best <= settings.polish {
                break;
            }
            // The first slow iteration gives the second change of the impulses that an extrapolation needs.
            slow = if residual > SLOW * last { slow + 1 } else { 0 };
            last = residual;
            if slow == 2 {
                slow = 0;
                if best > NOISE && self.extrapolate(cones, island) {
                    last = f64::INFINITY;
                } else {
                    ascending |= best <= ROUNDING_FLOOR || epsilon <= settings.smallest_proximal_weight;
                    if ascending && epsilon >= LARGEST_WEIGHT {
                        break;
                    }
                    epsilon = if ascending {
                        (epsilon * WEIGHT_STEP).min(LARGEST_WEIGHT)
                    } else {
                        (epsilon / WEIGHT_STEP).max(settings.smallest_proximal_weight)
                    };
                    self.set_weights(problem, island, epsilon);
                    factored = false;
                }
                self.evaluate_centre(problem, cones, island);
            }
            if self.modes.is_empty() {
                self.guess_modes(cones, island);
            }
            if !self.solve_proximal(cones, island, settings, attempt, &mut factored) {
                break;
            }
            self.effort.proximal_iterations += 1;
            self.take_impulses(cones, island);
        }
        factored &= self.modes == self.best_modes;
        self.restore_best();
        self.evaluate_centre(problem, cones, island);
        // The dissipation law multiplies an error of the velocity by the impulse.
        if best * self.largest_impulse() > REFINE {
            self.refine_velocity(cones, island, settings, factored);
        }
        best
    }

    /// The largest impulse in units of the one that changes the lightest contact's velocity by the velocity scale.
    fn largest_impulse(&self) -> f64 {
        let size = self.impulse.iter().map(|p| p[0].max(p[1].abs()).max(p[2].abs())).fold(0.0, f64::max);
        let scale = self.scale.iter().copied().fold(0.0, f64::max);
        if self.velocity_scale > 0.0 { size * scale / self.velocity_scale } else { 0.0 }
    }

    /// Continues the last change of the impulses to where it leads; whether that is far.
    ///
    /// When two changes in a row have the same direction, the iteration follows one eigenvector, with the ratio `r` of
    /// their sizes: the changes to come add up to `r/(1 − r)` times the last one. Where `r` is 1, contacts that stick
    /// contradict each other by a little, and every iteration adds the same self-balanced impulses until one of them
    /// slides or opens. Both end at the latest where a contact leaves its mode.
    fn extrapolate(&mut self, cones: &Cones, island: &Island) -> bool {
        let (mut product, mut last, mut earlier) = (0.0, 0.0, 0.0);
        for (a, b) in self.change.iter().zip(&self.earlier_change) {
            for r in 0..3 {
                product += a[r] * b[r];
                last += a[r] * a[r];
                earlier += b[r] * b[r];
            }
        }
        let parallel = self.change.len() == self.earlier_change.len()
            && product > PARALLEL * (last * earlier).sqrt()
            && self.change.len() == self.y.len();
        if !parallel {
            return false;
        }
        let ratio = (last / earlier).sqrt();
        let mut times = if ratio < 1.0 { ratio / (1.0 - ratio) } else { f64::INFINITY };
        for (c, &i) in island.contacts.iter().enumerate() {
            cones.facets(i as usize, self.modes[c], self.y[c], |facet| {
                let dot = |x: [f64; 3]| facet.normal[0] * x[0] + facet.normal[1] * x[1] + facet.normal[2] * x[2];
                let slope = dot(self.change[c]);
                if slope < 0.0 {
                    times = times.min(dot(self.y[c]).max(0.0) / -slope);
                }
            });
        }
        if !times.is_finite() || times < 1.0 {
            return false;
        }
        for (p, d) in self.impulse.iter_mut().zip(&self.change) {
            for r in 0..3 {
                p[r] += times * d[r];
            }
        }
        for (p, d) in self.bilateral_impulse.iter_mut().zip(&self.bilateral_change) {
            *p += times * d;
        }
        self.change.clear();
        true
    }

    /// The velocity of the solution, one more fixed-mode correction beyond what the impulses can express: where impulses
    /// are large against the masses they move, `v^f + M⁻¹Jᵀλ` cancels, while `v + δv` satisfies the contact rows to rounding.
    fn refine_velocity(&mut self, cones: &Cones, island: &Island, settings: &SolverSettings, mut factored: bool) {
        if self.modes.is_empty() || !self.solve_modes(cones, island, &mut factored) {
            return;
        }
        if self.violations(cones, island, settings) == 0 {
            self.velocity.iter_mut().zip(&self.work).for_each(|(v, d)| *v += d);
        }
    }

    /// Moves the contact impulses to the projections of `y`.
    fn take_impulses(&mut self, cones: &Cones, island: &Island) {
        std::mem::swap(&mut self.change, &mut self.earlier_change);
        self.change.clear();
        for (c, &i) in island.contacts.iter().enumerate() {
            let mode = cones.mode_at(i as usize, self.y[c]);
            let p = cones.project(i as usize, mode, self.y[c]);
            self.change.push(std::array::from_fn(|r| p[r] - self.impulse[c][r]));
            self.impulse[c] = p;
        }
    }

    fn set_weights(&mut self, problem: &ContactProblem, island: &Island, epsilon: f64) {
        self.weight.clear();
        self.weight.extend(self.scale.iter().map(|g| 1.0 / (epsilon * g)));
        self.bilateral_weight.clear();
        self.bilateral_weight.extend(self.bilateral_scale.iter().map(|g| 1.0 / (epsilon * g)));
        self.system.prepare(problem, island, &self.bilateral_weight);
    }

    fn keep_best(&mut self) {
        self.best.clone_from(&self.impulse);
        self.best_bilateral.clone_from(&self.bilateral_impulse);
        self.best_modes.clone_from(&self.modes);
    }

    fn restore_best(&mut self) {
        self.impulse.clone_from(&self.best);
        self.bilateral_impulse.clone_from(&self.best_bilateral);
        self.modes.clone_from(&self.best_modes);
    }

    /// Computes `v`, `u` and the trial impulses at the centre; returns the residual of the contact laws there.
    fn evaluate_centre(&mut self, problem: &ContactProblem, cones: &Cones, island: &Island) -> f64 {
        self.work.fill(0.0);
        for (c, p) in self.impulse.iter().enumerate() {
            island.jacobian.add_transposed(c, *p, &mut self.work);
        }
        for (k, p) in self.bilateral_impulse.iter().enumerate() {
            island.bilateral_jacobian.add_transposed(k, [*p], &mut self.work);
        }
        island.solve_mass(&problem.mass_factor, &mut self.work);
        for ((v, f), d) in self.velocity.iter_mut().zip(&self.free_velocity).zip(&self.work) {
            *v = f + d;
        }
        let mut worst = 0.0_f64;
        self.slack.clear();
        self.trial.clear();
        for (c, &i) in island.contacts.iter().enumerate() {
            let mut u = island.jacobian.multiply(c, &self.velocity);
            u[0] += problem.gap[i as usize] / problem.timestep;
            let (p, rho, g) = (self.impulse[c], self.weight[c], self.scale[c]);
            worst = worst.max(law_residual(cones, i as usize, p, u, g));
            self.slack.push(u);
            self.trial.push(std::array::from_fn(|r| p[r] - rho * u[r]));
        }
        self.bilateral_slack.clear();
        for (k, &i) in island.bilateral.iter().enumerate() {
            let [c] = island.bilateral_jacobian.multiply(k, &self.velocity);
            let u = c + problem.bilateral_violation[i as usize] / problem.timestep;
            worst = worst.max(u.abs());
            self.bilateral_slack.push(u);
        }
        if self.velocity_scale > 0.0 { worst / self.velocity_scale } else { 0.0 }
    }

    /// The modes in which the trial impulses at the centre lie.
    fn guess_modes(&mut self, cones: &Cones, island: &Island) {
        let modes = island.contacts.iter().zip(&self.trial).map(|(&i, &y)| cones.mode_at(i as usize, y));
        self.modes.extend(modes);
    }

    /// Solves the proximal problem around the centre: modes, `y`, bilateral impulses. `false` if neither Newton's
    /// iterations nor the paths found its modes.
    ///
    /// The paths of the first round start from the modes at hand. Later rounds start with every contact open: the matrix
    /// of the proximal problem is strictly copositive, so that this path, which is Lemke's in other coordinates, cannot end
    /// on a ray.
    fn solve_proximal(
        &mut self,
        cones: &Cones,
        island: &Island,
        settings: &SolverSettings,
        attempt: u32,
        factored: &mut bool,
    ) -> bool {
        for round in 0..settings.max_rounds {
            let newton = if round == 0 && attempt == 0 { settings.newton_iterations } else { 0 };
            if !self.take_newton_steps(cones, island, settings, newton, factored) {
                return false;
            }
            if self.violations(cones, island, settings) == 0 {
                self.take_bilateral(island);
                return true;
            }
            *factored = false;
            let seed = attempt * settings.max_rounds + round;
            if !self.follow_path(cones, island, settings, Shift::Violated, seed) {
                self.modes.fill(Mode::Open);
                if !self.solve_modes(cones, island, factored) {
                    return false;
                }
                *factored = false;
                if !self.follow_path(cones, island, settings, Shift::All, seed) {
                    return false;
                }
            }
        }
        false
    }

    /// Newton steps on all modes at once; ends at the modes that left the fewest contacts outside their modes, factorised and
    /// solved. `false` if a system is singular.
    fn take_newton_steps(
        &mut self,
        cones: &Cones,
        island: &Island,
        settings: &SolverSettings,
        steps: u32,
        factored: &mut bool,
    ) -> bool {
        let (mut fewest, mut since) = (usize::MAX, 0);
        for _ in 0..=steps {
            if !self.solve_modes(cones, island, factored) {
                return false;
            }
            let violations = self.violations(cones, island, settings);
            since = if violations < fewest { 0 } else { since + 1 };
            if violations < fewest {
                fewest = violations;
                self.newton_best.clone_from(&self.modes);
            }
            if violations == 0 || since > NEWTON_PATIENCE {
                break;
            }
            self.take_modes_of_trial(cones, island);
            *factored = false;
        }
        if self.modes != self.newton_best || !*factored {
            self.modes.clone_from(&self.newton_best);
            *factored = false;
        }
        self.solve_modes(cones, island, factored)
    }

    fn follow_path(
        &mut self,
        cones: &Cones,
        island: &Island,
        settings: &SolverSettings,
        shift: Shift,
        seed: u32,
    ) -> bool {
        let mut path = std::mem::take(&mut self.path);
        let outcome = path.follow(self, cones, island, settings, shift, seed);
        self.path = path;
        outcome == PathOutcome::Reached
    }

    /// Factorises if need be and solves with the modes fixed.
    fn solve_modes(&mut self, cones: &Cones, island: &Island, factored: &mut bool) -> bool {
        if !*factored {
            self.effort.factorizations += 1;
            if !self.system.factor(island, cones, &self.modes, &self.weight) {
                return false;
            }
            *factored = true;
        }
        self.solve_fixed_modes(cones, island);
        true
    }

    fn take_modes_of_trial(&mut self, cones: &Cones, island: &Island) {
        for (c, &i) in island.contacts.iter().enumerate() {
            let mode = cones.mode_at(i as usize, self.y[c]);
            self.effort.mode_changes += u32::from(mode != self.modes[c]);
            self.modes[c] = mode;
        }
    }

    /// Solution of the proximal problem with the modes fixed: `H δv = Jᵀ(B y₀ − λ̄)`, `y = y₀ − ρ J δv`.
    fn solve_fixed_modes(&mut self, cones: &Cones, island: &Island) {
        self.solve_shifted(cones, island, |_| ([0.0; 3], [0.0; 3]));
    }

    /// The same for data shifted by `remaining` times a path's shift: `y` as it is on the path.
    pub fn place_on_path(
        &mut self,
        cones: &Cones,
        island: &Island,
        shift: &[[f64; 3]],
        offset: &[[f64; 3]],
        remaining: f64,
    ) {
        self.solve_shifted(cones, island, |c| (shift[c].map(|s| remaining * s), offset[c].map(|o| remaining * o)));
    }

    /// `H δv = Jᵀ(B (y₀ + s) − o − λ̄)`, `y = y₀ + s − ρ J δv` for the shift and offset `(s, o)` of each contact.
    fn solve_shifted(&mut self, cones: &Cones, island: &Island, shifted: impl Fn(usize) -> ([f64; 3], [f64; 3])) {
        self.work.fill(0.0);
        for (c, &i) in island.contacts.iter().enumerate() {
            let (s, o) = shifted(c);
            let y0 = self.trial[c];
            let p = cones.project(i as usize, self.modes[c], std::array::from_fn(|r| y0[r] + s[r]));
            let d = std::array::from_fn(|r| p[r] - o[r] - self.impulse[c][r]);
            island.jacobian.add_transposed(c, d, &mut self.work);
        }
        for (k, u) in self.bilateral_slack.iter().enumerate() {
            island.bilateral_jacobian.add_transposed(k, [-self.bilateral_weight[k] * u], &mut self.work);
        }
        self.system.solve(island, &mut self.work);
        self.y.clear();
        for (c, y0) in self.trial.iter().enumerate() {
            let u = island.jacobian.multiply(c, &self.work);
            let (s, _) = shifted(c);
            self.y.push(std::array::from_fn(|r| y0[r] + s[r] - self.weight[c] * u[r]));
        }
    }

    /// Moves the bilateral impulses to the solution whose `δv` is in `work`.
    fn take_bilateral(&mut self, island: &Island) {
        for k in 0..self.bilateral_impulse.len() {
            let [du] = island.bilateral_jacobian.multiply(k, &self.work);
            self.bilateral_change[k] = -self.bilateral_weight[k] * (self.bilateral_slack[k] + du);
            self.bilateral_impulse[k] += self.bilateral_change[k];
        }
    }

    /// How far contact `c`'s trial impulse lies outside its mode's cone, relative to its typical size; ≤ 0 inside.
    pub fn violation(&self, cones: &Cones, island: &Island, c: usize) -> f64 {
        let y = self.y[c];
        let mut worst = f64::NEG_INFINITY;
        cones.facets(island.contacts[c] as usize, self.modes[c], y, |facet| {
            let f = facet.normal;
            let length = (f[0] * f[0] + f[1] * f[1] + f[2] * f[2]).sqrt();
            worst = worst.max(-(f[0] * y[0] + f[1] * y[1] + f[2] * y[2]) / length);
        });
        worst / self.typical_impulse(c)
    }

    /// The impulse that changes contact `c`'s velocity by the island's velocity scale.
    pub fn typical_impulse(&self, c: usize) -> f64 {
        (self.velocity_scale / self.scale[c]).max(f64::MIN_POSITIVE)
    }

    /// How many contacts lie outside their modes' cones.
    fn violations(&self, cones: &Cones, island: &Island, settings: &SolverSettings) -> usize {
        (0..self.modes.len()).filter(|&c| self.violation(cones, island, c) > settings.mode_tolerance).count()
    }
}

/// Distance from the laws of one contact in velocity units: `g |λ − P(λ − u/g)|` for the projection of the cone, and the
/// natural map of the normal pair.
fn law_residual(cones: &Cones, i: usize, p: [f64; 3], u: [f64; 3], g: f64) -> f64 {
    let normal = (g * p[0]).min(u[0]).abs();
    let y = [p[0], p[1] - u[1] / g, p[2] - u[2] / g];
    let mode = cones.mode_at(i, y);
    let q = cones.project(i, mode, y);
    normal.max(g * (p[1] - q[1]).abs()).max(g * (p[2] - q[2]).abs())
}
