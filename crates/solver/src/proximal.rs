//! The proximal iterations of an island: centre after centre, with ε where it helps.

use super::SolverSettings;
use super::attempts::CLOSER_LARGE;
use super::interior_start::{InteriorLaw, may_lag};
use super::island::Island;
use super::island_solver::IslandSolver;
use super::weight::ProximalWeight;
use signorini_contact::ContactProblem;
use signorini_contact::projection::Cones;

/// A proximal iteration that leaves more than this part of the residual calls for another ε.
const SLOW: f64 = 0.1;
/// The velocity is refined where its error, relative to the data, exceeds this: bodies at rest must not creep …
const REFINE: f64 = 2e-13;
/// … or where that times the largest impulse, also relative, exceeds this.
pub(super) const REFINE_LARGE: f64 = 1e-10;
/// Cosine between two changes of the impulses that counts as the same direction.
const PARALLEL: f64 = 0.99;
/// Below this residual changes of the impulses may be rounding, and are not extrapolated.
const NOISE: f64 = 1e-11;
/// An extrapolation has to leave less than this part of the residual of the last one.
const EXTRAPOLATED: f64 = 0.5;
/// A brief attempt that is this far from a solution ends where it came no nearer by an extrapolation, or where no contact will leave
/// its mode however often the last change is added: the impulses grow for ever.
const FAR: f64 = 1e-3;
/// A patient attempt has so many times the iterations of a small island.
const PATIENCE: u32 = 4;
/// Contacts and groups from which an island is large: a path from modes that are far from the
/// solution's would wander. A smaller one is swept where it is cold.
pub(super) const LARGE: usize = 64;

/// Contacts and groups from which a factorisation costs more than the few mode changes of a path.
pub(super) const COSTLY: usize = 512;

/// The first patient attempt on a large island: on contacts alone, two attempts before it have other starts.
pub(super) fn first_patient(island: &Island) -> u32 {
    if may_lag(island) { 3 } else { 1 }
}

/// Whether an attempt on an island is a patient one.
pub(super) fn is_patient(island: &Island, attempt: u32) -> bool {
    island.units.len() >= LARGE && attempt >= first_patient(island)
}

/// Whether the velocity that impulses give needs no refinement: the residual of the laws is rounding, and the dissipation law, which
/// multiplies an error of the velocity by the impulse, does not see it.
pub(super) fn is_exact(residual: f64, largest_impulse: f64) -> bool {
    residual <= REFINE && residual * largest_impulse <= REFINE_LARGE
}

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
        let large = island.units.len() >= LARGE;
        let patient = is_patient(island, attempt);
        let mut weight = ProximalWeight::new(settings, large, patient);
        let restarts = large && attempt > 0;
        if restarts || self.goes_on {
            weight.begin_large();
        }
        if restarts && !self.goes_on {
            if patient {
                self.sweep_blocks(problem, cones, island, settings);
            } else {
                self.analyse_system(problem, island);
                let law = if attempt == 1 { InteriorLaw::Opened } else { InteriorLaw::Associated };
                self.interior_start(problem, cones, island, law);
            }
        }
        self.set_weights(island, weight.epsilon);
        let (mut best, mut last, mut slow, mut extrapolated) = (f64::INFINITY, f64::INFINITY, 0, f64::INFINITY);
        let (mut prepared, mut factored, mut polished) = (false, false, false);
        let iterations = settings.max_proximal_iterations
            * match (large, patient) {
                (_, true) => PATIENCE,
                (true, false) => 2,
                (false, false) => 1,
            };
        for _ in 0..iterations {
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
            slow = if residual > SLOW * last && !weight.is_falling() { slow + 1 } else { 0 };
            last = residual;
            // What is accepted, also at a second look, and does not get better is paid for with factorisations.
            if slow > 0 && island.units.len() >= COSTLY && best <= CLOSER_LARGE * settings.accept {
                break;
            }
            if slow > 0 && best > NOISE && self.is_contradiction(island, settings.tolerance) {
                break;
            }
            if slow == 2 {
                slow = 0;
                if self.brief && extrapolated < f64::INFINITY && best > FAR.max(EXTRAPOLATED * extrapolated) {
                    break;
                }
                let goes_on = best > NOISE && best < EXTRAPOLATED * extrapolated;
                let times = if goes_on { self.times_to_go(cones, island) } else { 0.0 };
                if self.brief && best > FAR && times == f64::INFINITY {
                    break;
                }
                if times.is_finite() && times >= 1.0 {
                    self.extrapolate(times);
                    (last, extrapolated) = (f64::INFINITY, best);
                } else if !weight.change(best, last) {
                    break;
                } else {
                    self.set_weights(island, weight.epsilon);
                    (prepared, factored) = (false, false);
                }
                self.evaluate_centre(problem, cones, island);
            }
            if self.modes.is_empty() {
                if large {
                    self.guess_standing(cones, island);
                } else {
                    self.guess_modes(cones, island);
                    self.guessed = attempt == 0;
                }
            }
            self.prepare_system(problem, island, &mut prepared);
            self.earlier_modes.clone_from(&self.modes);
            let reweighted = if self.solve_proximal(problem, cones, island, settings, attempt, &mut factored) {
                self.effort.proximal_iterations += 1;
                self.take_impulses(cones, island);
                weight.fall(self.modes == self.earlier_modes)
            } else if large && self.recover(problem, cones, island, &mut weight, best) {
                true
            } else {
                break;
            };
            if reweighted {
                self.set_weights(island, weight.epsilon);
                (prepared, factored, last) = (false, false, f64::INFINITY);
            }
        }
        // A polished centre is the best one, and evaluated.
        if !polished {
            factored &= self.modes == self.best_modes;
            self.restore_best();
            self.evaluate_centre(problem, cones, island);
        }
        if !is_exact(best, self.largest_impulse(island)) {
            self.prepare_system(problem, island, &mut prepared);
            if self.refine_velocity(cones, island, settings, factored) && polished {
                // The next step starts from impulses that need no refinement.
                self.take_bilateral(island);
                self.take_impulses(cones, island);
            }
        }
        best
    }

    /// After a proximal problem of a large island that was not solved: at first another start, later a larger ε. `false` if
    /// there is nothing left to try.
    fn recover(
        &mut self,
        problem: &ContactProblem,
        cones: &Cones,
        island: &Island,
        weight: &mut ProximalWeight,
        best: f64,
    ) -> bool {
        if self.effort.proximal_iterations == 0 && !weight.is_falling() && !weight.is_patient() {
            weight.begin_large();
            return self.interior_start(problem, cones, island, InteriorLaw::Coulomb);
        }
        self.modes.clone_from(&self.earlier_modes);
        weight.rise(best)
    }

    fn analyse_system(&mut self, problem: &ContactProblem, island: &Island) {
        if !std::mem::replace(&mut self.analysed, true) {
            self.system.analyse(problem, island);
        }
    }

    /// Assembles what the system has in common for all modes, unless that is done for the present ε.
    fn prepare_system(&mut self, problem: &ContactProblem, island: &Island, prepared: &mut bool) {
        self.analyse_system(problem, island);
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

    /// How many times the last change of the impulses fits into the way to where it leads; infinite where it leads nowhere, 0 where
    /// it has no direction.
    ///
    /// When two changes in a row have the same direction, the iteration follows one eigenvector, with the ratio `r` of
    /// their sizes: the changes to come add up to `r/(1 − r)` times the last one. Where `r` is 1, contacts that stick
    /// contradict each other by a little, and every iteration adds the same self-balanced impulses until one of them
    /// slides or opens. Both end at the latest where a contact leaves its mode.
    fn times_to_go(&self, cones: &Cones, island: &Island) -> f64 {
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
            return 0.0;
        }
        let ratio = (last / earlier).sqrt();
        let mut times = if ratio < 1.0 { ratio / (1.0 - ratio) } else { f64::INFINITY };
        for (c, &i) in island.units.iter().enumerate() {
            cones.facets(i as usize, self.modes[c], |facet| {
                let dot = |x: [f64; 3]| facet.normal[0] * x[0] + facet.normal[1] * x[1] + facet.normal[2] * x[2];
                let slope = dot(self.change[c]);
                if slope < 0.0 {
                    times = times.min(dot(self.y[c]).max(0.0) / -slope);
                }
            });
        }
        times
    }

    /// Adds so many times the last change to the impulses.
    fn extrapolate(&mut self, times: f64) {
        for (p, d) in self.impulse.iter_mut().zip(&self.change) {
            for r in 0..3 {
                p[r] += times * d[r];
            }
        }
        for (p, d) in self.bilateral_impulse.iter_mut().zip(&self.bilateral_change) {
            *p += times * d;
        }
        self.change.clear();
    }

    /// The velocity of the solution, one more fixed-mode correction beyond what the impulses can express: where impulses
    /// are large against the masses they move, `v^f + M⁻¹Jᵀλ` cancels, while `v + δv` satisfies the contact rows to rounding.
    /// Whether the modes hold with it.
    pub(super) fn refine_velocity(
        &mut self,
        cones: &Cones,
        island: &Island,
        settings: &SolverSettings,
        mut factored: bool,
    ) -> bool {
        let solved = !self.modes.is_empty() && self.solve_modes(cones, island, &mut factored);
        let holds = solved && self.violations(cones, island, settings) == 0;
        if holds {
            self.velocity.iter_mut().zip(&self.work).for_each(|(v, d)| *v += d);
        }
        holds
    }
}
