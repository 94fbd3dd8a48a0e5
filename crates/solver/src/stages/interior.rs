//! A start from a central path, and proximal iterations from there: for large islands that are far from their modes.

use signorini_contact::StageOutcome;

use super::shared::{Outcome, Shared};
use crate::interior::{Ground, InteriorStart};
use crate::iterate::Iterate;
use crate::proximal::ProximalWeight;
use crate::residual::RESIDUALS;
use crate::task::{Look, Task};

/// The interior point, and where it leads.
#[derive(Clone, Debug, Default)]
pub(super) struct Memory {
    start: InteriorStart,
    ahead: Iterate,
    /// Where it led, for another try.
    again: Iterate,
}

pub(super) fn applies(task: &Task, iterate: &Iterate) -> bool {
    task.is_large() && iterate.residual > RESIDUALS.far && !matches!(task.look, Look::Short | Look::Part)
}

/// From the path of Coulomb's law; where it turns back early around its folds, unless the island is warm: that may take thousands of
/// factorisations, and an island that had a solution a step before has it only at a second look. Where iterations from there end close to a
/// solution and come no nearer, they begin there once more and [go far](ProximalWeight::far) in a stride.
pub(super) fn run(memory: &mut Memory, shared: &mut Shared, task: &Task, iterate: &mut Iterate) -> Outcome {
    let Memory { start, ahead, again } = memory;
    ahead.clear(task.problem, task.island);
    if !start.run(&mut Ground { map: &mut shared.map, iterate: &mut *ahead, task }) {
        return StageOutcome::Lost.into();
    }
    again.clone_from(ahead);
    let mut outcome = shared.iterate(task, ahead, ProximalWeight::falling(task.settings));
    let is_stuck = outcome.why == StageOutcome::Slow && ahead.residual > task.accept();
    if is_stuck && ahead.residual < RESIDUALS.far {
        let other = shared.iterate(task, again, ProximalWeight::far(task.settings));
        if again.residual < ahead.residual {
            std::mem::swap(again, ahead);
            outcome = other;
        }
    }
    if ahead.residual < iterate.residual {
        std::mem::swap(ahead, iterate);
    }
    outcome
}
