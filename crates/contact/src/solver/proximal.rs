//! The proximal iterations of an island: centre after centre, with ε where it helps.

use super::SolverSettings;
use super::island::Island;
use super::island_solver::IslandSolver;
use super::mode::Cones;
use crate::ContactProblem;

/// A proximal iteration that leaves more than this part of the residual calls for another ε.
const SLOW: f64 = 0.1;
/// The velocity is refined where its error times the largest impulse, both relative, exceeds this.
const REFINE: f64 = 1e-12;
/// Cosine between two changes of the impulses that counts as the same direction.
const PARALLEL: f64 = 0.99;
/// Below this residual changes of the impulses may be rounding, and are not extrapolated.
const NOISE: f64 = 1e-11;
/// The factor between one ε and the next.
const WEIGHT_STEP: f64 = 1e2;
/// Below this residual a slow iteration is a matter of rounding: ε goes up. Above it the impulses still have a long way to
/// go in directions of small Delassus eigenvalues, or a contact that has to slide is still inside its cone: ε goes down.
const ROUNDING_FLOOR: f64 = 2e-11;
/// Below this one, another ε is not worth its factorisation.
const NEARLY_POLISHED: f64 = 3e-12;
/// Contacts from which an island begins with the convex relaxation if one lies outside its mode; a smaller one is swept.
const LARGE: usize = 64;
/// ε of the last iterations. The rounding of `u` enters the impulses divided by ε: once a small ε has found the impulses in
/// the directions of small eigenvalues, larger ones remove that noise from the others.
const LARGEST_WEIGHT: f64 = 1e-3;

impl IslandSolver {
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
        self.set_weights(island, epsilon);
        let (mut best, mut last, mut slow) = (f64::INFINITY, f64::INFINITY, 0);
        let (mut prepared, mut factored, mut ascending, mut polished) = (false, false, false, false);
        for _ in 0..settings.max_proximal_iterations {
            let residual = self.evaluate_centre(problem, cones, island);
            if residual < best {
                best = residual;
                self.keep_best();
            }
            polished = best <= settings.polish;
            if polished {
                break;
            }
            // The first slow iteration gives the second change of the impulses that an extrapolation needs.
            slow = if residual > SLOW * last { slow + 1 } else { 0 };
            last = residual;
            if slow > 0 && best > NOISE && (self.is_contradiction(island) || self.is_jam(cones, island)) {
                break;
            }
            if slow == 2 {
                slow = 0;
                if best > NOISE && self.extrapolate(cones, island) {
                    last = f64::INFINITY;
                } else {
                    ascending |= best <= ROUNDING_FLOOR || epsilon <= settings.smallest_proximal_weight;
                    if ascending && (epsilon >= LARGEST_WEIGHT || best <= NEARLY_POLISHED) {
                        break;
                    }
                    epsilon = if ascending {
                        (epsilon * WEIGHT_STEP).min(LARGEST_WEIGHT)
                    } else {
                        (epsilon / WEIGHT_STEP).max(settings.smallest_proximal_weight)
                    };
                    self.set_weights(island, epsilon);
                    (prepared, factored) = (false, false);
                }
                self.evaluate_centre(problem, cones, island);
            }
            let cold = self.modes.is_empty();
            if cold {
                self.guess_modes(cones, island);
                self.guessed = attempt == 0 && island.units.len() < LARGE;
            }
            self.prepare_system(problem, island, &mut prepared);
            if cold && attempt == 0 && self.is_far_from_start(cones, island, settings, &mut factored) {
                self.convex_start(problem, cones, island);
                self.set_weights(island, epsilon);
                self.evaluate_centre(problem, cones, island);
                (prepared, factored) = (false, false);
                self.prepare_system(problem, island, &mut prepared);
            }
            if !self.solve_proximal(problem, cones, island, settings, attempt, &mut factored) {
                break;
            }
            self.effort.proximal_iterations += 1;
            self.take_impulses(cones, island);
        }
        // A polished centre is the best one, and evaluated.
        if !polished {
            factored &= self.modes == self.best_modes;
            self.restore_best();
            self.evaluate_centre(problem, cones, island);
        }
        // The dissipation law multiplies an error of the velocity by the impulse.
        if best * self.largest_impulse(island) > REFINE {
            self.prepare_system(problem, island, &mut prepared);
            self.refine_velocity(cones, island, settings, factored);
        }
        best
    }

    /// Whether Newton's steps leave contacts of a large island outside their modes: a better start is worth more than a path
    /// from there.
    fn is_far_from_start(
        &mut self,
        cones: &Cones,
        island: &Island,
        settings: &SolverSettings,
        factored: &mut bool,
    ) -> bool {
        island.units.len() >= LARGE
            && self.take_newton_steps(cones, island, settings, settings.newton_iterations, factored)
            && self.violations(cones, island, settings) > 0
    }

    /// Assembles what the system has in common for all modes, unless that is done for the present ε.
    fn prepare_system(&mut self, problem: &ContactProblem, island: &Island, prepared: &mut bool) {
        if !self.analysed {
            self.system.analyse(island);
            self.analysed = true;
        }
        if !*prepared {
            self.system.prepare(problem, island, &self.bilateral_weight);
            *prepared = true;
        }
    }

    /// The largest impulse in units of the one that changes the lightest contact's velocity by the velocity scale.
    fn largest_impulse(&self, island: &Island) -> f64 {
        let size = self.impulse.iter().map(|p| p[0].max(p[1].abs()).max(p[2].abs())).fold(0.0, f64::max);
        let scale = island.scale.iter().copied().fold(0.0, f64::max);
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
        for (c, &i) in island.units.iter().enumerate() {
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
    pub(super) fn refine_velocity(
        &mut self,
        cones: &Cones,
        island: &Island,
        settings: &SolverSettings,
        mut factored: bool,
    ) {
        if self.modes.is_empty() || !self.solve_modes(cones, island, &mut factored) {
            return;
        }
        if self.violations(cones, island, settings) == 0 {
            self.velocity.iter_mut().zip(&self.work).for_each(|(v, d)| *v += d);
        }
    }
}
