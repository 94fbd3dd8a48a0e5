//! Accelerated contact sweeps in turn with exact solutions of parts, for islands of many contacts.

use signorini_contact::StageOutcome;

use super::shared::{Outcome, Shared};
use crate::contact_sweeps::{ContactSweeps, Ended, SolvePart};
use crate::iterate::Iterate;
use crate::proximal::ProximalWeight;
use crate::residual::RESIDUALS;
use crate::task::{Look, SIZES, Task};

/// Islands of many bodies, and warm ones of some hundred between bodies; where the sweeps are counted, all large ones.
pub(super) fn applies(task: &Task, _: &Iterate) -> bool {
    if task.budget().is_some() {
        return task.is_large();
    }
    (is_many(task) || is_of_some_hundred(task)) && matches!(task.look, Look::First | Look::Only)
}

/// Whether a few sweeps from a start find more modes than as many factorisations as they cost, three to five: in islands twice as large as those that
/// count as large, unless robots are most of them (`motion/run.py`, and a hundred humanoids that fall on each other, 29 November 2026).
/// A start that is another solve's of the same step has few modes to find: whole runs of `pile100`, seeds 0 to 9, take 0.79 of their time without (ibid.).
fn is_of_some_hundred(task: &Task) -> bool {
    let is_far = task.is_warm && !task.is_nearly_solved;
    is_far && task.island.units.len() >= 2 * SIZES.large && !task.is_costly() && !is_of_robots(task)
}

/// Whether fewer than half of the degrees of freedom are those of free bodies, or contacts and groups outnumber them all, as those of a single robot
/// do: what moves many of them at once leaves iterations few modes to change.
fn is_of_robots(task: &Task) -> bool {
    let island = task.island;
    let of_bodies: usize = island.starts.windows(2).map(|pair| pair[1] - pair[0]).filter(|size| *size <= FREE).sum();
    2 * of_bodies < island.nv() || island.units.len() > island.nv()
}

/// Degrees of freedom of a free body.
const FREE: usize = 6;

/// Whether the island is so large that a factorisation costs many sweeps, or the tolerance is so rough that factorising it is the last resort.
fn is_many(task: &Task) -> bool {
    task.is_large() && (task.island.nv() >= task.settings.sweeps_from || task.is_rough())
}

/// Where the sweeps are counted, small islands that iterations did not solve.
pub(super) fn applies_to_rest(task: &Task, _: &Iterate) -> bool {
    task.budget().is_some() && !task.is_large()
}

/// The sweeps, and the start that they go back to.
#[derive(Clone, Debug, Default)]
pub(super) struct Memory {
    sweeps: ContactSweeps,
    start: Iterate,
}

/// Takes what the sweeps come to where that is enough. Where few modes are wrong or they become slow, and after the few of an island of some hundred
/// contacts, proximal iterations go on from there with an ε that falls. What these leave of a warm island of many bodies is swept again, and given to
/// iterations with a larger ε, as long as half of it goes every time; where that comes to nothing the iterate stays as it was. (Of 27 cold clusters of
/// 110 bodies none that the first turn left was solved by further ones, of as many warm ones one of six, of recorded piles most.)
pub(super) fn run(
    memory: &mut Memory,
    shared: &mut Shared,
    task: &Task,
    iterate: &mut Iterate,
    mut solve_part: impl SolvePart,
) -> Outcome {
    let Memory { sweeps, start } = memory;
    start.clone_from(iterate);
    let mut left = f64::INFINITY;
    loop {
        match sweep(sweeps, shared, task, iterate, &mut solve_part) {
            Ended::OutOfBudget => {
                // The velocity of what is left unfinished is that of its impulses, which the verdict finds.
                iterate.velocity.clone_from(&shared.map.free_velocity);
                iterate.residual = sweeps.lacks();
                return StageOutcome::OutOfBudget.into();
            }
            Ended::Enough => {
                shared.map.set_weights(task.island, task.settings.proximal_weight);
                iterate.residual = shared.map.evaluate_centre(task, iterate);
                let is_solved = task.budget().is_none() || iterate.residual <= task.accept();
                return if is_solved { StageOutcome::Solved.into() } else { StageOutcome::OutOfBudget.into() };
            }
            Ended::Near => return StageOutcome::Prepared.into(),
            Ended::Far => {
                if left < f64::INFINITY {
                    take_back(shared, iterate, start);
                }
                return StageOutcome::Slow.into();
            }
            Ended::ForIterations => {
                let is_first = left == f64::INFINITY;
                let weight = if is_first { ProximalWeight::after_sweeps } else { ProximalWeight::falling };
                let outcome = shared.iterate(task, iterate, weight(task.settings));
                if iterate.residual <= task.accept() {
                    return outcome;
                }
                let helps = iterate.residual <= RESIDUALS.less * left;
                if !(helps && is_many(task) && task.is_warm) {
                    take_back(shared, iterate, start);
                    return outcome;
                }
                left = iterate.residual;
            }
        }
    }
}

/// Makes the iterate what it was before iterations changed it.
fn take_back(shared: &mut Shared, iterate: &mut Iterate, start: &Iterate) {
    iterate.clone_from(start);
    shared.map.change_modes();
}

/// Sweeps as often as the island may be, or as helps.
fn sweep(
    sweeps: &mut ContactSweeps,
    shared: &mut Shared,
    task: &Task,
    iterate: &mut Iterate,
    solve_part: &mut impl SolvePart,
) -> Ended {
    let mut history = |residual| {
        if task.settings.record_history {
            shared.residuals.push(residual);
        }
    };
    let ended = match task.budget() {
        Some(budget) => sweeps.run_within(task, iterate, budget, &mut history),
        None if is_many(task) => sweeps.run(task, iterate, solve_part, &mut history),
        None => sweeps.run_short(task, iterate, &mut history),
    };
    shared.map.effort.sweeps += sweeps.made();
    ended
}
