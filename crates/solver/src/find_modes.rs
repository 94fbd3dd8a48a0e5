//! The modes of one proximal problem: Newton's steps, then paths.

use super::SolverSettings;
use super::island::Island;
use super::island_solver::IslandSolver;
use super::path::{PathOutcome, Shift};
use super::proximal::{COSTLY, LARGE, is_patient};
use signorini_contact::ContactProblem;
use signorini_contact::projection::{Cones, Mode};

/// The first attempt on a large island follows a path if at most one in so many contacts lies outside its mode.
const FEW: usize = 16;
/// ε from which Newton's steps find the modes of a large island by themselves.
const EASY: f64 = 1e-2;
/// So many contacts outside their modes are worth another step with any ε.
const VERY_FEW: usize = 3;

impl IslandSolver {
    /// Solves the proximal problem around the centre: modes, `y`, bilateral impulses. `false` if neither Newton's
    /// iterations nor the paths found its modes.
    ///
    /// A path starts from the best modes that Newton's steps met. Where it is lost, another one starts with every contact
    /// open: the matrix of the proximal problem is strictly copositive, so that this path, which is Lemke's in other
    /// coordinates, cannot end on a ray.
    ///
    /// The first attempt on a large island follows one path at most, and only where few contacts lie outside their modes: what
    /// it does not find is asked for with a larger ε.
    ///
    /// A patient attempt on one follows a path from the centre, which is short where the laws nearly hold there.
    ///
    /// Modes that are no more than guessed and do not hold are swept first.
    pub(super) fn solve_proximal(
        &mut self,
        problem: &ContactProblem,
        cones: &Cones,
        island: &Island,
        settings: &SolverSettings,
        attempt: u32,
        factored: &mut bool,
    ) -> bool {
        let large = island.units.len() >= LARGE;
        let patient = is_patient(island, attempt);
        let careful = large && !patient;
        for round in 0..settings.max_rounds {
            let newton = if round == 0 && (attempt == 0 || large) { settings.newton_iterations } else { 0 };
            if std::mem::take(&mut self.guessed) {
                if !self.solve_modes(cones, island, factored) {
                    return false;
                }
                if self.violations(cones, island, settings) == 0 {
                    self.take_bilateral(island);
                    return true;
                }
                self.sweep(problem, cones, island);
                *factored = false;
            }
            let Some(violations) = self.take_newton_steps(cones, island, settings, newton, factored) else {
                return false;
            };
            if violations == 0 {
                self.take_bilateral(island);
                return true;
            }
            if patient {
                *factored = false;
                return self.follow_path(cones, island, settings, Shift::Centre, attempt)
                    && self.holds_at_path_end(cones, island, settings, factored);
            }
            if careful && (round > 0 || FEW * violations > island.units.len()) {
                return false;
            }
            *factored = false;
            let seed = attempt * settings.max_rounds + round;
            let shift = if careful { Shift::Few } else { Shift::Violated };
            if is_lost(island, violations) || !self.follow_path(cones, island, settings, shift, seed) {
                if careful {
                    return false;
                }
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

    /// Newton steps on all modes at once, as long as each leaves fewer contacts outside their modes; ends at the modes that left
    /// the fewest there, factorised and solved, and returns how many. Nothing if a system is singular.
    pub(super) fn take_newton_steps(
        &mut self,
        cones: &Cones,
        island: &Island,
        settings: &SolverSettings,
        steps: u32,
        factored: &mut bool,
    ) -> Option<usize> {
        let mut fewest = usize::MAX;
        for step in 0..=steps {
            if !self.solve_modes(cones, island, factored) {
                return None;
            }
            let violations = self.violations(cones, island, settings);
            let better = violations < fewest;
            if better {
                fewest = violations;
                self.newton_best.clone_from(&self.modes);
            }
            if violations == 0 || step == steps || !better || self.is_for_a_path(island, violations) {
                break;
            }
            self.take_modes_of_trial(cones, island);
            *factored = false;
        }
        if self.modes == self.newton_best && *factored {
            return Some(fewest);
        }
        self.modes.clone_from(&self.newton_best);
        *factored = false;
        self.solve_modes(cones, island, factored).then_some(fewest)
    }

    /// Whether so few contacts of a very large island lie outside their modes, with an ε so small, that a path does better than a
    /// step on all modes at once, which then mostly throws out more contacts than it brings in.
    fn is_for_a_path(&self, island: &Island, violations: usize) -> bool {
        let contacts = island.units.len();
        contacts >= COSTLY && self.epsilon < EASY && violations > VERY_FEW && FEW * violations <= contacts
    }

    /// Solves with the modes at a path's end, which are the solution's but for rounding.
    fn holds_at_path_end(
        &mut self,
        cones: &Cones,
        island: &Island,
        settings: &SolverSettings,
        factored: &mut bool,
    ) -> bool {
        let holds = self.solve_modes(cones, island, factored) && self.violations(cones, island, settings) == 0;
        if holds {
            self.take_bilateral(island);
        }
        holds
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

    fn take_modes_of_trial(&mut self, cones: &Cones, island: &Island) {
        for (c, &i) in island.units.iter().enumerate() {
            let mode = cones.mode_at(i as usize, self.y[c]);
            self.effort.mode_changes += u32::from(mode != self.modes[c]);
            self.modes[c] = mode;
        }
    }
}

/// Whether so many contacts of a large island lie outside their modes that a path from there would wander.
fn is_lost(island: &Island, violations: usize) -> bool {
    let contacts = island.units.len();
    contacts >= LARGE && 2 * violations > contacts
}
