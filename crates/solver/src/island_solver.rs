//! Proximal iterations on one island.
//!
//! Around a centre `λ̄` the proximal problem is `λ_c = P_c(λ̄_c − ρ_c u_c)`, `M(v − v^f) = Jᵀλ`, `u = J v + (φ/Δt, 0, 0)`,
//! with `ρ_c = 1/(ε g_c)` and `g_c` the scale of the contact's Delassus block. It has a regular system however redundant the
//! contacts are, and a fixed point of `λ̄ ← λ` solves the contact problem exactly. Everything is computed in differences from
//! `λ̄`, so that the last iterations work with small numbers and reach rounding.

use super::SolverSettings;
use super::block_sweeps::BlockSweeps;
use super::impulse_newton::ImpulseNewton;
use super::interior_start::InteriorStart;
use super::island::Island;
#[cfg(test)]
use super::islands::Islands;
use super::path::Path;
use super::sweeps::Sweeps;
use super::system::ProximalSystem;
use signorini_contact::projection::{Cones, Mode};
use signorini_contact::scales::raise;
use signorini_contact::{ContactProblem, SolveReport};

/// Counters of one island's solve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Effort {
    pub factorizations: u32,
    pub mode_changes: u32,
    pub proximal_iterations: u32,
}

impl Effort {
    /// Adds it to what a report counts.
    pub fn add_to(self, report: &mut SolveReport) {
        report.factorizations += self.factorizations;
        report.mode_changes += self.mode_changes;
        report.proximal_iterations += self.proximal_iterations;
    }

    /// Adds that of another attempt.
    pub fn add(&mut self, other: Self) {
        self.factorizations += other.factorizations;
        self.mode_changes += other.mode_changes;
        self.proximal_iterations += other.proximal_iterations;
    }
}

/// The solver's memory and, during a solve, its iterate.
#[derive(Clone, Debug, Default)]
pub(crate) struct IslandSolver {
    pub(super) system: ProximalSystem,
    pub(super) path: Path,
    /// ε, and with it ρ of each contact and of each bilateral row.
    pub(super) epsilon: f64,
    pub(super) weight: Vec<f64>,
    pub(super) bilateral_weight: Vec<f64>,
    /// `max|b|` of the island.
    pub(super) velocity_scale: f64,
    pub(super) free_velocity: Vec<f64>,
    /// The velocity that goes with `impulse`.
    pub(super) velocity: Vec<f64>,
    /// Whether the velocity is that of the centre that is evaluated next.
    pub(super) knows_velocity: bool,
    /// The centre and, at the end, the solution.
    pub(super) impulse: Vec<[f64; 3]>,
    pub(super) bilateral_impulse: Vec<f64>,
    pub(super) modes: Vec<Mode>,
    /// `u` at the centre.
    pub(super) slack: Vec<[f64; 3]>,
    pub(super) bilateral_slack: Vec<f64>,
    /// `λ̄ − ρ u`.
    pub(super) trial: Vec<[f64; 3]>,
    /// Trial impulse of the current solution of the proximal problem.
    pub(super) y: Vec<[f64; 3]>,
    pub(super) work: Vec<f64>,
    /// Sum of the sizes of the momenta that meet in each degree of freedom.
    pub(super) load: Vec<f64>,
    /// What the last proximal iteration added to the impulses, and the one before it.
    pub(super) change: Vec<[f64; 3]>,
    pub(super) earlier_change: Vec<[f64; 3]>,
    pub(super) bilateral_change: Vec<f64>,
    /// The modes before a proximal problem.
    pub(super) earlier_modes: Vec<Mode>,
    /// The best modes of the Newton steps.
    pub(super) newton_best: Vec<Mode>,
    pub(super) best: Vec<[f64; 3]>,
    pub(super) best_bilateral: Vec<f64>,
    pub(super) best_modes: Vec<Mode>,
    /// Units whose rows are proved to contradict each other.
    pub(super) contradiction: Vec<u32>,
    pub(super) magnitude: Vec<f64>,
    pub(super) effort: Effort,
    pub(super) newton: ImpulseNewton,
    pub(super) interior: InteriorStart,
    pub(super) sweeps: Sweeps,
    pub(super) block_sweeps: BlockSweeps,
    /// Whether the modes are those of the trial impulses, which sweeps may improve.
    pub(super) guessed: bool,
    /// Whether the attempt may end early, because Lemke's method has the next turn.
    pub(super) brief: bool,
    /// Whether the attempt goes on from where the one before it ended.
    pub(super) goes_on: bool,
    /// Whether `system` knows the island's structure.
    pub(super) analysed: bool,
}

impl IslandSolver {
    /// Reads an island and the start: impulses and modes from a warm start, or zero and open.
    pub fn start(&mut self, problem: &ContactProblem, island: &Island) {
        island.gather(&problem.free_velocity, &mut self.free_velocity);
        self.velocity.resize(island.nv(), 0.0);
        self.knows_velocity = false;
        self.work.clear();
        self.work.resize(island.nv(), 0.0);
        self.velocity_scale = island.velocity_scale.value();
        self.analysed = false;
        self.effort = Effort::default();
        self.impulse.clear();
        self.impulse.resize(island.units.len(), [0.0; 3]);
        self.set_bounds(problem, island);
        self.bilateral_impulse.clear();
        self.bilateral_impulse.resize(island.bilateral.len(), 0.0);
        self.modes.clear();
        self.contradiction.clear();
        self.guessed = false;
        self.change.clear();
        self.earlier_change.clear();
        self.bilateral_change.clear();
        self.bilateral_change.resize(island.bilateral.len(), 0.0);
    }

    /// Sets the first component of the friction groups' impulses to what bounds them.
    pub(super) fn set_bounds(&mut self, problem: &ContactProblem, island: &Island) {
        for c in island.contact_count..island.units.len() {
            let j = island.units[c] as usize - problem.contact_count();
            self.impulse[c][0] = problem.friction_groups.bound[j].constant();
        }
        island.bind(&mut self.impulse);
    }

    /// Moves the contact impulses to the projections of `y`.
    pub(super) fn take_impulses(&mut self, cones: &Cones, island: &Island) {
        std::mem::swap(&mut self.change, &mut self.earlier_change);
        self.change.clear();
        for (c, &i) in island.units.iter().enumerate() {
            let mode = cones.mode_at(i as usize, self.y[c]);
            let p = cones.project(i as usize, mode, self.y[c]);
            self.change.push(std::array::from_fn(|r| p[r] - self.impulse[c][r]));
            self.impulse[c] = p;
        }
    }

    pub(super) fn set_weights(&mut self, island: &Island, epsilon: f64) {
        self.epsilon = epsilon;
        self.weight.clear();
        self.weight.extend(island.scale.iter().map(|g| 1.0 / (epsilon * g)));
        self.bilateral_weight.clear();
        self.bilateral_weight.extend(island.bilateral_scale.iter().map(|g| 1.0 / (epsilon * g)));
    }

    pub(super) fn keep_best(&mut self) {
        self.best.clone_from(&self.impulse);
        self.best_bilateral.clone_from(&self.bilateral_impulse);
        self.best_modes.clone_from(&self.modes);
    }

    pub(super) fn restore_best(&mut self) {
        self.impulse.clone_from(&self.best);
        self.bilateral_impulse.clone_from(&self.best_bilateral);
        self.modes.clone_from(&self.best_modes);
    }

    /// Computes `v`, `u` and the trial impulses at the centre; returns the residual of the contact laws there.
    pub(super) fn evaluate_centre(&mut self, problem: &ContactProblem, cones: &Cones, island: &Island) -> f64 {
        let pushed = self.impulse.iter().any(|p| *p != [0.0; 3]) || self.bilateral_impulse.iter().any(|p| *p != 0.0);
        self.slack.clear();
        let known = std::mem::take(&mut self.knows_velocity);
        if pushed {
            if !known {
                self.find_velocity(problem, island);
            }
            self.slack.extend((0..island.units.len()).map(|c| island.slack(c, &self.velocity)));
        } else {
            self.velocity.copy_from_slice(&self.free_velocity);
            self.slack.extend_from_slice(&island.free_slack);
        }
        let mut worst = 0.0_f64;
        self.trial.clear();
        for (c, &i) in island.units.iter().enumerate() {
            let (u, p, rho) = (self.slack[c], self.impulse[c], self.weight[c]);
            raise(&mut worst, law_residual(cones, i as usize, p, island.pushing(c, u), island.residual_scale));
            self.trial.push(std::array::from_fn(|r| p[r] - rho * u[r]));
        }
        island.bind(&mut self.trial);
        self.bilateral_slack.clear();
        for (k, offset) in island.bilateral_offset.iter().enumerate() {
            let [c] = island.bilateral_jacobian.multiply(k, &self.velocity);
            let u = c + offset;
            raise(&mut worst, u.abs());
            self.bilateral_slack.push(u);
        }
        if self.velocity_scale > 0.0 { worst / self.velocity_scale } else { 0.0 }
    }

    /// `v = v^f + M⁻¹ Jᵀ λ`.
    fn find_velocity(&mut self, problem: &ContactProblem, island: &Island) {
        self.work.fill(0.0);
        for (c, p) in self.impulse.iter().enumerate() {
            island.add_impulse(c, *p, &mut self.work);
        }
        for (k, p) in self.bilateral_impulse.iter().enumerate() {
            island.bilateral_jacobian.add_transposed(k, [*p], &mut self.work);
        }
        island.solve_mass(&problem.mass_factor, &mut self.work);
        for ((v, f), d) in self.velocity.iter_mut().zip(&self.free_velocity).zip(&self.work) {
            *v = f + d;
        }
    }

    /// The modes in which the trial impulses at the centre lie.
    pub(super) fn guess_modes(&mut self, cones: &Cones, island: &Island) {
        let modes = island.units.iter().zip(&self.trial).map(|(&i, &y)| cones.mode_at(i as usize, y));
        self.modes.extend(modes);
    }

    /// The modes of what stands: everything sticks. Where a stack falls as one, the trial impulses at the free velocity say that all
    /// contacts but the lowest are open.
    pub(super) fn guess_standing(&mut self, cones: &Cones, island: &Island) {
        let standing = |i: usize| if cones.friction(i) > 0.0 { Mode::Stick } else { Mode::Closed };
        self.modes.extend(island.units.iter().map(|&i| standing(i as usize)));
    }

    /// Factorises if need be and solves with the modes fixed.
    pub(super) fn solve_modes(&mut self, cones: &Cones, island: &Island, factored: &mut bool) -> bool {
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

    /// Solution of the proximal problem with the modes fixed: `H δv = Jᵀ(B y₀ − λ̄)`, `y = y₀ − ρ J δv`.
    pub(super) fn solve_fixed_modes(&mut self, cones: &Cones, island: &Island) {
        self.solve_shifted(cones, island, 1.0, |_| ([0.0; 3], [0.0; 3]));
        island.bind(&mut self.y);
    }

    /// The same for data shifted by `remaining` times a path's shift: `y` as it is on the path.
    pub fn place_on_path(
        &mut self,
        cones: &Cones,
        island: &Island,
        (shift, offset): (&[[f64; 3]], &[[f64; 3]]),
        remaining: f64,
        bilateral_part: f64,
    ) {
        let shifted = |c: usize| (shift[c].map(|s| remaining * s), offset[c].map(|o| remaining * o));
        self.solve_shifted(cones, island, bilateral_part, shifted);
    }

    /// `H δv = Jᵀ(B (y₀ + s) − o − λ̄)`, `y = y₀ + s − ρ J δv` for the shift and offset `(s, o)` of each contact.
    pub(super) fn solve_shifted(
        &mut self,
        cones: &Cones,
        island: &Island,
        bilateral_part: f64,
        shifted: impl Fn(usize) -> ([f64; 3], [f64; 3]),
    ) {
        self.work.fill(0.0);
        for (c, &i) in island.units.iter().enumerate() {
            let (s, o) = shifted(c);
            let y0 = self.trial[c];
            let p = cones.project(i as usize, self.modes[c], std::array::from_fn(|r| y0[r] + s[r]));
            let d = std::array::from_fn(|r| p[r] - o[r] - self.impulse[c][r]);
            island.add_impulse(c, d, &mut self.work);
        }
        let mut work = std::mem::take(&mut self.work);
        self.add_bilateral_pull(island, bilateral_part, &mut work);
        self.work = work;
        self.system.solve(island, &mut self.work);
        self.y.clear();
        for (c, y0) in self.trial.iter().enumerate() {
            let u = island.jacobian.multiply(c, &self.work);
            let (s, _) = shifted(c);
            self.y.push(std::array::from_fn(|r| y0[r] + s[r] - self.weight[c] * u[r]));
        }
    }

    /// Adds `part` of what the violated bilateral rows pull with.
    pub(super) fn add_bilateral_pull(&self, island: &Island, part: f64, momentum: &mut [f64]) {
        for (k, u) in self.bilateral_slack.iter().enumerate() {
            island.bilateral_jacobian.add_transposed(k, [-self.bilateral_weight[k] * part * u], momentum);
        }
    }

    /// Moves the bilateral impulses to the solution whose `δv` is in `work`.
    pub(super) fn take_bilateral(&mut self, island: &Island) {
        for k in 0..self.bilateral_impulse.len() {
            let [du] = island.bilateral_jacobian.multiply(k, &self.work);
            self.bilateral_change[k] = -self.bilateral_weight[k] * (self.bilateral_slack[k] + du);
            self.bilateral_impulse[k] += self.bilateral_change[k];
        }
    }

    /// The impulse that changes contact `c`'s velocity by the island's velocity scale.
    pub fn typical_impulse(&self, island: &Island, c: usize) -> f64 {
        (self.velocity_scale / island.scale[c]).max(f64::MIN_POSITIVE)
    }

    /// Whether contact `c`'s trial impulse lies outside its mode's cone by more than the tolerance.
    pub(super) fn is_violated(&self, cones: &Cones, island: &Island, settings: &SolverSettings, c: usize) -> bool {
        let y = self.y[c];
        if self.modes[c] == Mode::Stick && cones.is_well_inside(island.units[c] as usize, y) {
            return false;
        }
        let most = settings.mode_tolerance * self.typical_impulse(island, c);
        let mut violated = false;
        cones.facets(island.units[c] as usize, self.modes[c], |facet| {
            let f = facet.normal;
            let outside = -(f[0] * y[0] + f[1] * y[1] + f[2] * y[2]);
            violated |= outside > 0.0 && outside > most * (f[0] * f[0] + f[1] * f[1] + f[2] * f[2]).sqrt();
        });
        violated
    }

    /// How many contacts lie outside their modes' cones.
    pub(super) fn violations(&self, cones: &Cones, island: &Island, settings: &SolverSettings) -> usize {
        (0..self.modes.len()).filter(|&c| self.is_violated(cones, island, settings, c)).count()
    }
}

/// Distance from the laws of one contact in velocity units: `g |λ − P(λ − u/g)|` for the projection of the cone, and the
/// natural map of the normal pair.
pub(super) fn law_residual(cones: &Cones, i: usize, p: [f64; 3], u: [f64; 3], g: f64) -> f64 {
    let mut residual = (g * p[0]).min(u[0]).abs();
    let q = if p[0] <= 0.0 {
        [0.0; 3]
    } else {
        let y = [p[0], p[1] - u[1] / g, p[2] - u[2] / g];
        cones.project(i, cones.mode_at(i, y), y)
    };
    raise(&mut residual, g * (p[1] - q[1]).abs());
    raise(&mut residual, g * (p[2] - q[2]).abs());
    residual
}

/// A problem of one island, read and assembled, and a solver that has started on it.
#[cfg(test)]
pub(super) fn started_on(problem: &ContactProblem) -> (Cones, Islands, IslandSolver) {
    let (mut cones, mut islands) = (Cones::default(), Islands::default());
    cones.prepare(problem);
    islands.find(problem);
    islands.assemble(problem, |_| true);
    let [island] = islands.all() else { panic!("{} islands", islands.all().len()) };
    let mut solver = IslandSolver::default();
    solver.start(problem, island);
    (cones, islands, solver)
}
