//! The modes of one proximal problem: Newton's steps, then a path.
//!
//! Newton's steps change all modes at once, as long as each leaves fewer contacts outside them. A path starts from the best modes that
//! they met. Where it is lost, another one starts with every contact open: the matrix of the proximal problem is strictly
//! copositive, so that this path, which is Lemke's in other coordinates, cannot end on a ray.
//!
//! In a large island one path is followed at most, and only where few contacts lie outside their modes: what it does not find is
//! asked for with a larger ε.

use signorini_contact::projection::Mode;

use super::map::ProximalMap;
use super::path::{Path, Shift};
use crate::iterate::Iterate;
use crate::task::Task;

/// What is tuned in the search for modes.
pub(super) struct Tuning {
    /// In a large island that is warm, and not costly, a path is followed if at most one in so many contacts lies outside its mode.
    few: usize,
    /// ε from which Newton's steps find the modes of a large island by themselves.
    easy: f64,
}

/// Chosen by: `few` by `moving_piles` on every seventh to forty-first solve of `motion/scenes.py` (drum, shaken_bin, pile100, cards10_struck,
/// cards4_struck; seeds 0 and 3), 1 to 16, 28 November 2026; without `easy` `sim S4_pile300 --tolerance 1e-8` takes twice its time (23
/// November 2026).
pub(super) const TUNING: Tuning = Tuning { few: 4, easy: 1e-2 };

/// Memory of the search.
#[derive(Clone, Debug, Default)]
pub(super) struct ModeSearch {
    path: Path,
    /// The best modes of the Newton steps.
    best: Vec<Mode>,
}

impl ModeSearch {
    /// Solves the proximal problem around the centre: modes in the iterate, `y` in the map. `false` if its modes were not found.
    pub fn solve(&mut self, map: &mut ProximalMap, task: &Task, iterate: &mut Iterate) -> bool {
        let large = task.is_large();
        for round in 0..task.settings.max_rounds {
            let steps = if round == 0 { task.settings.newton_iterations } else { 0 };
            let Some(mut violations) = self.take_newton_steps(map, task, iterate, steps) else { return false };
            if violations > 0 && round > 0 && map.system.is_updated() {
                // What the updates' rounding has moved out of its mode is back in it with a fresh factorisation.
                map.change_modes();
                let Some(left) = self.take_newton_steps(map, task, iterate, steps) else { return false };
                violations = left;
            }
            if violations == 0 {
                return true;
            }
            if large && (round > 0 || !are_few(task, violations)) {
                return false;
            }
            let is_found = self.path.follow(map, task, iterate, Shift::Violated, round)
                || !large && self.follow_from_open(map, task, iterate, round);
            if !is_found {
                return false;
            }
        }
        false
    }

    /// Newton steps on all modes at once, as long as each leaves fewer contacts outside their modes; ends at the modes that left
    /// the fewest there, factorised and solved, and returns how many. Nothing if a system is singular.
    fn take_newton_steps(
        &mut self,
        map: &mut ProximalMap,
        task: &Task,
        iterate: &mut Iterate,
        steps: u32,
    ) -> Option<usize> {
        let mut fewest = usize::MAX;
        for step in 0..=steps {
            if !map.solve_modes(task, iterate) {
                return None;
            }
            let violations = map.violations(task, iterate);
            let better = violations < fewest;
            if better {
                fewest = violations;
                self.best.clone_from(&iterate.modes);
            }
            if violations == 0 || step == steps || !better || ends_newton_steps(map, task, violations) {
                break;
            }
            map.put_aside();
            take_modes_of_trial(map, task, iterate);
        }
        if iterate.modes != self.best {
            iterate.modes.clone_from(&self.best);
            map.take_back();
            return map.solve_modes(task, iterate).then_some(fewest);
        }
        Some(fewest)
    }

    fn follow_from_open(&mut self, map: &mut ProximalMap, task: &Task, iterate: &mut Iterate, seed: u32) -> bool {
        iterate.modes.fill(Mode::Open);
        map.change_modes();
        map.solve_modes(task, iterate) && self.path.follow(map, task, iterate, Shift::All, seed)
    }
}

/// One in so many contacts of a large island may lie outside its mode where a path is followed. Of one that is cold, whose modes are guesses, or so large
/// that a path may change hundreds, the square of the number of others: a heap of 91 boxes that begins at rest would take ten times the work.
pub(super) fn few(task: &Task) -> usize {
    if task.is_warm && !task.is_costly() { TUNING.few } else { TUNING.few * TUNING.few }
}

fn are_few(task: &Task, violations: usize) -> bool {
    few(task) * violations <= task.island.units.len()
}

/// Whether ε is so small that a step on all modes at once mostly throws out more contacts than it brings in: a path does better where few lie outside their
/// modes, and of a large island's where many do a larger ε.
fn ends_newton_steps(map: &ProximalMap, task: &Task, violations: usize) -> bool {
    task.spares_factorizations() && map.epsilon < TUNING.easy && (task.is_large() || are_few(task, violations))
}

fn take_modes_of_trial(map: &mut ProximalMap, task: &Task, iterate: &mut Iterate) {
    for (c, &i) in task.island.units.iter().enumerate() {
        let mode = task.cones.mode_at(i as usize, map.y[c]);
        map.effort.mode_changes += u32::from(mode != iterate.modes[c]);
        iterate.modes[c] = mode;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{on_ground_of, pile};
    use signorini_contact::vector::inner;

    /// What the updates of a path that has arrived solve is what a fresh factorisation for its modes solves.
    #[test]
    fn a_path_ends_with_the_system_of_its_modes() {
        let (mut search, mut updated) = (ModeSearch::default(), 0);
        for seed in 0..50 {
            on_ground_of(&pile(seed), |ground| {
                let (map, task, iterate) = (&mut *ground.map, ground.task, &mut *ground.iterate);
                for epsilon in (0..12).map(|k| 0.3_f64.powi(k)) {
                    map.set_weights(task.island, epsilon);
                    map.evaluate_centre(task, iterate);
                    map.guess_modes(task, &mut iterate.modes);
                    map.prepare(task);
                    if !search.solve(map, task, iterate) {
                        return;
                    }
                    let (y, step) = (map.y.clone(), map.step.clone());
                    updated += u32::from(map.system.is_updated());
                    map.change_modes();
                    assert!(map.solve_modes(task, iterate) && !map.system.is_updated());
                    assert_eq!(map.violations(task, iterate), 0);
                    for (other, own) in [(y.as_flattened(), map.y.as_flattened()), (&step, &map.step)] {
                        let difference: Vec<f64> = other.iter().zip(own).map(|(a, b)| a - b).collect();
                        let (difference, size) = (inner(&difference, &difference).sqrt(), inner(own, own).sqrt());
                        assert!(difference <= 1e-13 * size, "seed {seed}: {difference:e} of {size:e}");
                    }
                    iterate.velocity.clear();
                    for (c, y) in map.y.iter().enumerate() {
                        iterate.impulse[c] = task.cones.project(task.island.units[c] as usize, iterate.modes[c], *y);
                    }
                }
            });
        }
        assert!(updated > 20, "{updated} paths");
    }
}
