//! The proximal map on one island.
//!
//! Around a centre `λ̄` the proximal problem is `λ_c = P_c(λ̄_c − ρ_c u_c)`, `M(v − v^f) = Jᵀλ`, `u = J v + (φ/Δt, 0, 0)`,
//! with `ρ_c = 1/(ε g_c)` and `g_c` the scale of the contact's Delassus block. It has a regular system however redundant the
//! contacts are, and a fixed point of `λ̄ ← λ` solves the contact problem exactly. Everything is computed in differences from
//! `λ̄`, so that the last iterations work with small numbers and reach rounding.

use signorini_contact::projection::Mode;
use signorini_contact::scales::raise;

use super::system::ProximalSystem;
use super::weight::ProximalWeight;
use crate::islands::Island;
use crate::iterate::{Effort, Iterate};
use crate::residual::{RESIDUALS, law_residual};
use crate::task::{SIZES, Task};

/// What of the system is known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Ready {
    #[default]
    Nothing,
    /// Its structure, which is that of the island.
    Analysed,
    /// What it has in common for all modes, for the present ε.
    Prepared,
    /// It is factorised for the modes of the iterate, or updated since then where a path led to them.
    Factored,
}

/// The map around a centre, and the system of its problem.
#[derive(Clone, Debug, Default)]
pub(crate) struct ProximalMap {
    pub system: ProximalSystem,
    ready: Ready,
    /// ε, and with it ρ of each contact and of each bilateral row.
    pub epsilon: f64,
    pub weight: Vec<f64>,
    pub bilateral_weight: Vec<f64>,
    /// `max|b|` of the island.
    pub velocity_scale: f64,
    pub free_velocity: Vec<f64>,
    /// `u` at the centre.
    slack: Vec<[f64; 3]>,
    bilateral_slack: Vec<f64>,
    /// `λ̄ − ρ u`.
    pub trial: Vec<[f64; 3]>,
    /// Trial impulse of the current solution of the proximal problem.
    pub y: Vec<[f64; 3]>,
    /// The change of the velocity in that solution.
    pub step: Vec<f64>,
    correction: Vec<f64>,
    pub effort: Effort,
}

impl ProximalMap {
    /// Forgets another island.
    pub fn begin(&mut self, task: &Task) {
        let island = task.island;
        island.gather(&task.problem.free_velocity, &mut self.free_velocity);
        self.step.clear();
        self.step.resize(island.nv(), 0.0);
        self.velocity_scale = island.velocity_scale.value();
        (self.ready, self.epsilon, self.effort) = (Ready::Nothing, 0.0, Effort::default());
    }

    /// Sets ε; what was prepared for another one is forgotten.
    pub fn set_weights(&mut self, island: &Island, epsilon: f64) {
        if epsilon == self.epsilon {
            return;
        }
        (self.epsilon, self.ready) = (epsilon, self.ready.min(Ready::Analysed));
        self.weight.clear();
        self.weight.extend(island.scale.iter().map(|g| 1.0 / (epsilon * g)));
        self.bilateral_weight.clear();
        let is_of_many_rows_alone = island.units.is_empty() && island.bilateral.len() >= SIZES.large;
        let of_rows = if is_of_many_rows_alone { ProximalWeight::of_constraints_alone(epsilon) } else { epsilon };
        self.bilateral_weight.extend(island.bilateral_scale.iter().map(|g| 1.0 / (of_rows * g)));
    }

    /// Assembles what the system has in common for all modes, unless that is done.
    pub fn prepare(&mut self, task: &Task) {
        if self.ready == Ready::Nothing {
            self.system.analyse(task.problem, task.island);
        }
        if self.ready < Ready::Prepared {
            self.system.prepare(task.problem, task.island, &self.bilateral_weight);
            self.ready = Ready::Prepared;
        }
    }

    /// Notes that the system is factorised for other modes than the iterate's, or for none.
    pub fn change_modes(&mut self) {
        self.ready = self.ready.min(Ready::Prepared);
    }

    /// Computes `v`, `u` and the trial impulses at the centre; returns the residual of the contact laws there, relative to the velocity
    /// scale.
    pub fn evaluate_centre(&mut self, task: &Task, iterate: &mut Iterate) -> f64 {
        let (cones, island) = (task.cones, task.island);
        self.slack.clear();
        if is_pushed(iterate) {
            if iterate.velocity.is_empty() {
                self.find_velocity(task, iterate);
            }
            self.slack.extend((0..island.units.len()).map(|c| island.slack(c, &iterate.velocity)));
        } else {
            iterate.velocity.clone_from(&self.free_velocity);
            self.slack.extend_from_slice(&island.free_slack);
        }
        let mut worst = 0.0_f64;
        self.trial.clear();
        for (c, &i) in island.units.iter().enumerate() {
            let (u, p, rho) = (self.slack[c], iterate.impulse[c], self.weight[c]);
            raise(&mut worst, law_residual(cones, i as usize, p, island.pushing(c, u), island.residual_scale));
            self.trial.push(std::array::from_fn(|r| p[r] - rho * u[r]));
        }
        island.bind(&mut self.trial);
        self.bilateral_slack.clear();
        for (k, offset) in island.bilateral_offset.iter().enumerate() {
            let [c] = island.bilateral_jacobian.multiply(k, &iterate.velocity);
            let u = c + offset;
            raise(&mut worst, u.abs());
            self.bilateral_slack.push(u);
        }
        if self.velocity_scale > 0.0 { worst / self.velocity_scale } else { 0.0 }
    }

    /// `v = v^f + M⁻¹ Jᵀ λ`.
    fn find_velocity(&mut self, task: &Task, iterate: &mut Iterate) {
        let (island, v) = (task.island, &mut iterate.velocity);
        v.resize(island.nv(), 0.0);
        for (c, p) in iterate.impulse.iter().enumerate() {
            island.add_impulse(c, *p, v);
        }
        for (k, p) in iterate.bilateral.iter().enumerate() {
            island.bilateral_jacobian.add_transposed(k, [*p], v);
        }
        island.solve_mass(&task.problem.mass_factor, v);
        v.iter_mut().zip(&self.free_velocity).for_each(|(v, f)| *v += f);
    }

    /// Sets the modes to those in which the trial impulses at the centre lie.
    pub fn guess_modes(&self, task: &Task, modes: &mut Vec<Mode>) {
        modes.clear();
        let trials = task.island.units.iter().zip(&self.trial);
        modes.extend(trials.map(|(&i, &y)| task.cones.mode_at(i as usize, y)));
    }

    /// Factorises if need be and solves with the modes fixed; `false` if the system is singular.
    pub fn solve_modes(&mut self, task: &Task, iterate: &Iterate) -> bool {
        if self.ready < Ready::Factored {
            self.effort.factorizations += 1;
            if !self.system.factor(task.island, task.cones, &iterate.modes, &self.weight) {
                return false;
            }
            self.ready = Ready::Factored;
        }
        self.solve_shifted(task, iterate, |_| ([0.0; 3], [0.0; 3]));
        if self.system.is_updated() {
            self.refine(task, iterate);
        }
        task.island.bind(&mut self.y);
        true
    }

    /// Takes from the solution what the rounding of updates left in its momentum balance, `M δv = Jᵀ(P(y) − λ̄)`.
    fn refine(&mut self, task: &Task, iterate: &Iterate) {
        let (island, correction) = (task.island, &mut self.correction);
        correction.clear();
        correction.resize(island.nv(), 0.0);
        island.multiply_mass(&task.problem.mass, &self.step, correction);
        correction.iter_mut().for_each(|p| *p = -*p);
        for (c, &i) in island.units.iter().enumerate() {
            let p = task.cones.project(i as usize, iterate.modes[c], self.y[c]);
            let d = std::array::from_fn(|r| p[r] - iterate.impulse[c][r]);
            island.add_impulse(c, d, correction);
        }
        for (k, (rho, u)) in self.bilateral_weight.iter().zip(&self.bilateral_slack).enumerate() {
            let [du] = island.bilateral_jacobian.multiply(k, &self.step);
            island.bilateral_jacobian.add_transposed(k, [-rho * (u + du)], correction);
        }
        self.system.solve(island, correction);
        for (c, y) in self.y.iter_mut().enumerate() {
            let u = island.jacobian.multiply(c, correction);
            (0..3).for_each(|r| y[r] -= self.weight[c] * u[r]);
        }
        self.step.iter_mut().zip(correction).for_each(|(v, d)| *v += *d);
    }

    /// Notes that the system was updated to the iterate's modes by a path that has arrived there.
    pub fn arrive(&mut self) {
        self.ready = Ready::Factored;
    }

    /// Puts the factorisation for the iterate's modes aside, which are about to change.
    pub fn put_aside(&mut self) {
        self.system.exchange();
        self.change_modes();
    }

    /// Takes the factorisation that was put aside last, for whose modes the iterate's were exchanged.
    pub fn take_back(&mut self) {
        self.system.exchange();
        self.ready = Ready::Factored;
    }

    /// Factorises for modes that a path has reached, whatever is known; `false` if the system is singular.
    pub fn refactor(&mut self, task: &Task, iterate: &Iterate) -> bool {
        self.effort.factorizations += 1;
        self.system.factor(task.island, task.cones, &iterate.modes, &self.weight)
    }

    /// Solves with the modes fixed, `H δv = Jᵀ(B (y₀ + s) − o − λ̄)` and `y = y₀ + s − ρ J δv`, for the shift and offset `(s, o)` of
    /// each contact, which are zero but on a path.
    pub fn solve_shifted(&mut self, task: &Task, iterate: &Iterate, shifted: impl Fn(usize) -> ([f64; 3], [f64; 3])) {
        let island = task.island;
        self.step.fill(0.0);
        for (c, &i) in island.units.iter().enumerate() {
            let (s, o) = shifted(c);
            let y0 = self.trial[c];
            let p = task.cones.project(i as usize, iterate.modes[c], std::array::from_fn(|r| y0[r] + s[r]));
            let d = std::array::from_fn(|r| p[r] - o[r] - iterate.impulse[c][r]);
            island.add_impulse(c, d, &mut self.step);
        }
        for (k, u) in self.bilateral_slack.iter().enumerate() {
            island.bilateral_jacobian.add_transposed(k, [-self.bilateral_weight[k] * u], &mut self.step);
        }
        self.system.solve(island, &mut self.step);
        self.y.clear();
        for (c, y0) in self.trial.iter().enumerate() {
            let u = island.jacobian.multiply(c, &self.step);
            let (s, _) = shifted(c);
            self.y.push(std::array::from_fn(|r| y0[r] + s[r] - self.weight[c] * u[r]));
        }
    }

    /// How the impulse of a bilateral row changes in the present solution.
    pub fn bilateral_change(&self, island: &Island, k: usize) -> f64 {
        let [du] = island.bilateral_jacobian.multiply(k, &self.step);
        -self.bilateral_weight[k] * (self.bilateral_slack[k] + du)
    }

    /// The impulse that changes contact `c`'s velocity by the island's velocity scale.
    pub fn typical_impulse(&self, island: &Island, c: usize) -> f64 {
        (self.velocity_scale / island.scale[c]).max(f64::MIN_POSITIVE)
    }

    /// Whether contact `c`'s trial impulse lies outside its mode's cone by more than the tolerance.
    pub fn is_violated(&self, task: &Task, iterate: &Iterate, c: usize) -> bool {
        let (y, mode, unit) = (self.y[c], iterate.modes[c], task.island.units[c] as usize);
        if mode == Mode::Stick && task.cones.is_well_inside(unit, y) {
            return false;
        }
        // An open contact that would close by less than what is exact stays open: among those that follow from others last digits would decide. In
        // a large island that led to impulses whose last digits keep it from rest (a drone jammed by 200 contacts: ten times the time of a step).
        let is_left = mode == Mode::Open && !task.is_large();
        let exact = if is_left { RESIDUALS.exact / self.epsilon } else { 0.0 };
        let most = task.settings.mode_tolerance.max(exact) * self.typical_impulse(task.island, c);
        let mut violated = false;
        task.cones.facets(unit, mode, |facet| {
            let f = facet.normal;
            let outside = -(f[0] * y[0] + f[1] * y[1] + f[2] * y[2]);
            violated |= outside > 0.0 && outside > most * (f[0] * f[0] + f[1] * f[1] + f[2] * f[2]).sqrt();
        });
        violated
    }

    /// How many contacts lie outside their modes' cones.
    pub fn violations(&self, task: &Task, iterate: &Iterate) -> usize {
        (0..iterate.modes.len()).filter(|&c| self.is_violated(task, iterate, c)).count()
    }
}

/// Whether any impulse is not zero.
fn is_pushed(iterate: &Iterate) -> bool {
    iterate.impulse.iter().any(|p| *p != [0.0; 3]) || iterate.bilateral.iter().any(|p| *p != 0.0)
}
