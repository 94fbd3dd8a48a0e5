//! Semismooth Newton iterations on the proximal form of the circular-cone laws.
//!
//! Around a centre `λ̄` the proximal problem is `λ_c = P_c(λ̄_c − ρ_c u_c)`, `u = q + W λ`, with `ρ_c = 1/(ε g_c)`, `g_c` the
//! scale of the contact's block of `W`, and `P` Alart and Curnier's projection. Its Newton matrix is regular however
//! redundant the contacts are, and a fixed point of `λ̄ ← λ` solves the laws exactly. A larger ε takes shorter and safer steps.

use super::ConeSettings;
use super::system::{Block, ContactSystem, Triple};
use signorini_contact::circular::CoulombLaw;

/// A proximal iteration that leaves more than this part of the residual asks for a smaller ε.
const SLOW: f64 = 0.1;
/// The factor between one ε and the next.
const EPSILON_STEP: f64 = 30.0;
/// Trial lengths of a Newton step: 1, 1/2, … 1/2⁷.
const HALVINGS: i32 = 7;
/// A step is taken if it leaves at most this part of the merit, times what a full Newton step promises.
const SUFFICIENT: f64 = 1e-3;
/// The proximal problem is solved when its own residual is this part of the one of the laws …
const INNER: f64 = 1e-2;
/// … or this part of the velocity scale over ε, which is what the rounding of `u` leaves in `ρ u`.
const INNER_FLOOR: f64 = 1e-15;

/// Counters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct NewtonEffort {
    pub proximal_iterations: u32,
    pub newton_iterations: u32,
    pub factorizations: u32,
}

/// The iterate and memory of the method.
#[derive(Clone, Debug, Default)]
pub(super) struct Newton {
    /// The start and, at the end, the best impulses met.
    pub impulse: Vec<Triple>,
    pub effort: NewtonEffort,
    center: Vec<Triple>,
    best: Vec<Triple>,
    u: Vec<Triple>,
    du: Vec<Triple>,
    r: Vec<Triple>,
    weight: Vec<f64>,
    slopes: Vec<Block>,
}

impl Newton {
    /// Takes impulses of contacts and friction groups as the start.
    pub fn begin_at(&mut self, contacts: &[Triple], groups: &[[f64; 2]]) {
        self.impulse.clear();
        self.impulse.extend_from_slice(contacts);
        self.impulse.extend(groups.iter().map(|[a, b]| [0.0, *a, *b]));
    }

    /// Runs from `impulse` until the residual is at `settings.polish` or stops falling. Returns the residual of what is in
    /// `impulse`: the natural map of formulation §9 and the bilateral rows, relative to the velocity scale.
    pub fn run(&mut self, system: &mut impl ContactSystem, laws: &[CoulombLaw], settings: &ConeSettings) -> f64 {
        let mut epsilon = settings.proximal_weight;
        let (mut best, mut last, mut failures) = (f64::INFINITY, f64::INFINITY, 0);
        for i in 0..laws.len() {
            let y = with_bound(&laws[i], self.impulse[i], |contact| self.impulse[contact][0]);
            self.impulse[i] = laws[i].project(y);
        }
        for _ in 0..settings.max_proximal_iterations {
            let residual = self.residual(system, laws);
            if residual < best {
                best = residual;
                self.best.clone_from(&self.impulse);
                system.keep_best();
            }
            if best <= settings.polish || failures > settings.max_failures {
                break;
            }
            if residual > SLOW * last {
                failures += u32::from(residual >= last);
                epsilon = (epsilon / EPSILON_STEP).max(settings.smallest_proximal_weight);
            }
            last = residual;
            self.effort.proximal_iterations += 1;
            self.set_epsilon(system, epsilon);
            let floor = INNER_FLOOR / epsilon;
            if !self.solve_proximal(system, laws, settings, (INNER * residual).max(floor)) {
                failures += 1;
                epsilon = (epsilon * EPSILON_STEP).min(1.0);
                last = f64::INFINITY;
            }
            for i in 0..laws.len() {
                self.impulse[i] = laws[i].project(self.trial(laws, i, self.u[i]));
            }
        }
        // Where numbers overflow nothing was best: what is kept there belongs to another problem.
        if best.is_finite() {
            self.impulse.clone_from(&self.best);
            system.restore_best();
        }
        best
    }

    fn set_epsilon(&mut self, system: &mut impl ContactSystem, epsilon: f64) {
        self.weight.clear();
        self.weight.extend((0..system.len()).map(|i| 1.0 / (epsilon * system.scale(i))));
        system.set_epsilon(epsilon);
    }

    /// Evaluates the velocities of `impulse` and the residual of the laws.
    pub fn residual(&mut self, system: &mut impl ContactSystem, laws: &[CoulombLaw]) -> f64 {
        let bilateral = system.evaluate(&self.impulse, &mut self.u);
        let (g, s) = (system.largest_scale(), system.velocity_scale());
        let units = self.impulse.iter().zip(&self.u).zip(laws);
        let worst = units.fold(bilateral, |worst, ((p, u), law)| {
            let r = match law.bound() {
                None => law.natural_map(*p, *u, g),
                Some(bound) => law.group_natural_map(*p, *u, bound.at(|contact| self.impulse[contact][0]), g),
            };
            if r.is_nan() { f64::INFINITY } else { worst.max(r) }
        });
        if s > 0.0 { worst / s } else { worst }
    }

    /// Damped Newton steps on the proximal problem around `impulse`; whether they reached `tolerance`.
    fn solve_proximal(
        &mut self,
        system: &mut impl ContactSystem,
        laws: &[CoulombLaw],
        settings: &ConeSettings,
        tolerance: f64,
    ) -> bool {
        self.center.clone_from(&self.impulse);
        system.recentre();
        let target = tolerance * system.velocity_scale();
        let mut merit = self.discrepancy(system, laws);
        for _ in 0..settings.max_newton_iterations {
            if merit.worst <= target {
                return true;
            }
            self.effort.newton_iterations += 1;
            if !self.factor(system, laws) {
                return false;
            }
            system.solve(&self.r, &mut self.du);
            merit = self.search_line(system, laws, merit);
            if !merit.sum.is_finite() {
                return false;
            }
        }
        merit.worst <= target
    }

    /// Takes the first trial length whose merit falls, else the best of them.
    fn search_line(&mut self, system: &mut impl ContactSystem, laws: &[CoulombLaw], before: Merit) -> Merit {
        // δλ = r − ρ B δu is what the linearised projection makes of the step.
        for i in 0..self.r.len() {
            let b = &self.slopes[i];
            let du = self.du[i];
            for k in 0..3 {
                self.r[i][k] -= b[k][0] * du[0] + b[k][1] * du[1] + b[k][2] * du[2];
            }
        }
        let (mut best, mut best_length) = (f64::INFINITY, 1.0);
        for k in 0..=HALVINGS {
            let t = 0.5_f64.powi(k);
            let merit = self.trial_merit(system, laws, t);
            if merit < best {
                (best, best_length) = (merit, t);
            }
            if merit <= (1.0 - SUFFICIENT * t) * before.sum {
                break;
            }
        }
        let t = best_length;
        for i in 0..self.r.len() {
            for k in 0..3 {
                self.u[i][k] += t * self.du[i][k];
                self.impulse[i][k] += t * self.r[i][k];
            }
        }
        system.step(t);
        self.discrepancy(system, laws)
    }

    /// Sum of squares of `g (P(y) − λ)` after the part `t` of the step.
    fn trial_merit(&self, system: &impl ContactSystem, laws: &[CoulombLaw], t: f64) -> f64 {
        let mut sum = 0.0;
        for i in 0..laws.len() {
            let u: Triple = std::array::from_fn(|k| self.u[i][k] + t * self.du[i][k]);
            let p = laws[i].project(self.trial(laws, i, u));
            let g = system.scale(i);
            for k in 0..3 {
                let d = g * (p[k] - self.impulse[i][k] - t * self.r[i][k]);
                sum += d * d;
            }
        }
        sum
    }

    /// `λ̄ − ρ u` of unit `i` at its velocity `u`; of a friction group with the bound that its contact's normal impulse gives.
    fn trial(&self, laws: &[CoulombLaw], i: usize, u: Triple) -> Triple {
        let y = std::array::from_fn(|k| self.center[i][k] - self.weight[i] * u[k]);
        // A group's first velocity is that of its contact's normal.
        with_bound(&laws[i], y, |contact| (self.center[contact][0] - self.weight[contact] * u[0]).max(0.0))
    }

    /// Fills `r = P(λ̄ − ρ u) − λ`.
    fn discrepancy(&mut self, system: &impl ContactSystem, laws: &[CoulombLaw]) -> Merit {
        let mut merit = Merit { sum: 0.0, worst: 0.0 };
        self.r.clear();
        for i in 0..laws.len() {
            let p = laws[i].project(self.trial(laws, i, self.u[i]));
            let g = system.scale(i);
            let r: Triple = std::array::from_fn(|k| p[k] - self.impulse[i][k]);
            for x in r {
                merit.sum += g * g * x * x;
                merit.worst = merit.worst.max(g * x.abs());
            }
            self.r.push(r);
        }
        merit
    }

    /// One more linear solve at the pieces of the best impulses: the change of the velocities that their rounding hides.
    /// `false` if there is none to be had.
    pub fn correct(&mut self, system: &mut impl ContactSystem, laws: &[CoulombLaw], settings: &ConeSettings) -> bool {
        self.set_epsilon(system, settings.proximal_weight);
        self.residual(system, laws);
        self.center.clone_from(&self.impulse);
        system.recentre();
        self.discrepancy(system, laws);
        if !self.factor(system, laws) {
            return false;
        }
        system.solve(&self.r, &mut self.du);
        true
    }

    /// Factorises the Newton matrix for the slopes `ρ B` at the present velocities.
    fn factor(&mut self, system: &mut impl ContactSystem, laws: &[CoulombLaw]) -> bool {
        self.slopes.clear();
        for i in 0..laws.len() {
            let rho = self.weight[i];
            let slope = laws[i].slope(self.trial(laws, i, self.u[i]));
            // The radius of a group follows its contact's normal impulse, whose slope is in that contact's block.
            let by_normal = match laws[i].bound() {
                None => rho,
                Some(bound) => bound.normal().map_or(0.0, |(contact, c)| c * self.slopes[contact][0][0]),
            };
            self.slopes.push(slope.map(|[n, t_1, t_2]| [by_normal * n, rho * t_1, rho * t_2]));
        }
        self.effort.factorizations += 1;
        system.factor(&self.slopes)
    }
}

/// How far `λ` is from `P(λ̄ − ρ u)`, in velocities.
#[derive(Clone, Copy, Debug)]
struct Merit {
    sum: f64,
    worst: f64,
}

/// `y` with the bound of a friction group in the first place, where `normal` gives the normal impulses of contacts.
fn with_bound(law: &CoulombLaw, y: Triple, normal: impl Fn(usize) -> f64) -> Triple {
    law.bound().map_or(y, |bound| [bound.at(normal), y[1], y[2]])
}
