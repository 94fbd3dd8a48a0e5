//! Accelerated contact sweeps in turn with exact solutions of parts, for islands of many contacts.

use signorini_contact::StageOutcome;

use super::shared::{Outcome, Shared};
use crate::contact_sweeps::{ContactSweeps, Ended, SolvePart};
use crate::iterate::Iterate;
use crate::proximal::ProximalWeight;
use crate::residual::RESIDUALS;
use crate::task::{Look, Task};

/// Islands of many contacts; with a rough tolerance, or where the sweeps are counted, all large ones.
pub(super) fn applies(task: &Task, _: &Iterate) -> bool {
    if task.budget().is_some() {
        return task.is_large();
    }
    let is_many = task.island.units.len() >= task.settings.sweeps_from || task.is_rough() && task.is_large();
    is_many && matches!(task.look, Look::First | Look::Only)
}

/// Large islands that iterations left far from the modes of a start that was given; where the sweeps are counted, small ones that they did
/// not solve.
pub(super) fn applies_to_rest(task: &Task, iterate: &Iterate) -> bool {
    if task.budget().is_some() {
        return !task.is_large();
    }
    let is_left = task.is_warm && task.is_large() && !task.is_costly() && iterate.residual > RESIDUALS.far;
    is_left && !applies(task, iterate) && matches!(task.look, Look::First | Look::Only)
}

/// The sweeps, and the start that they go back to.
#[derive(Clone, Debug, Default)]
pub(super) struct Memory {
    sweeps: ContactSweeps,
    start: Iterate,
}

/// Sweeps in turn with exact solutions of parts.
pub(super) fn run(
    memory: &mut Memory,
    shared: &mut Shared,
    task: &Task,
    iterate: &mut Iterate,
    solve_part: impl SolvePart,
) -> Outcome {
    let uncounted = |sweeps: &mut ContactSweeps, iterate: &mut Iterate, history: &mut dyn FnMut(f64)| {
        sweeps.run(task, iterate, solve_part, history)
    };
    sweep_and_iterate(memory, shared, task, iterate, uncounted)
}

/// A few sweeps on what iterations left: they find most of the modes, and a factorisation costs little more than they do.
pub(super) fn run_on_rest(memory: &mut Memory, shared: &mut Shared, task: &Task, iterate: &mut Iterate) -> Outcome {
    let uncounted = |sweeps: &mut ContactSweeps, iterate: &mut Iterate, history: &mut dyn FnMut(f64)| {
        sweeps.run_short(task, iterate, history)
    };
    sweep_and_iterate(memory, shared, task, iterate, uncounted)
}

/// Takes what the sweeps come to where that is enough. Where they become slow close to a solution, proximal iterations go on from there
/// with an ε that falls; where these come to nothing, too, the iterate stays as it was.
///
/// - `uncounted`: the sweeps where there is no budget of them
fn sweep_and_iterate(
    memory: &mut Memory,
    shared: &mut Shared,
    task: &Task,
    iterate: &mut Iterate,
    uncounted: impl FnOnce(&mut ContactSweeps, &mut Iterate, &mut dyn FnMut(f64)) -> Ended,
) -> Outcome {
    let Memory { sweeps, start } = memory;
    start.clone_from(iterate);
    let mut history = |residual| {
        if task.settings.record_history {
            shared.residuals.push(residual);
        }
    };
    let ended = match task.budget() {
        Some(budget) => sweeps.run_within(task, iterate, budget, &mut history),
        None => uncounted(sweeps, iterate, &mut history),
    };
    shared.map.effort.sweeps += sweeps.made();
    match ended {
        Ended::Enough | Ended::OutOfBudget => {
            shared.map.set_weights(task.island, task.settings.proximal_weight);
            iterate.residual = shared.map.evaluate_centre(task, iterate);
            let is_solved = ended == Ended::Enough && (task.budget().is_none() || iterate.residual <= task.accept());
            if is_solved { StageOutcome::Solved.into() } else { StageOutcome::OutOfBudget.into() }
        }
        Ended::Near => StageOutcome::Prepared.into(),
        Ended::Far => StageOutcome::Slow.into(),
        Ended::Slow => {
            let outcome = shared.iterate(task, iterate, ProximalWeight::after_sweeps(task.settings));
            if iterate.residual > task.accept() {
                iterate.clone_from(start);
                shared.map.change_modes();
            }
            outcome
        }
    }
}
