//! A start from a central path, and proximal iterations from there: for large islands that are far from their modes.

use signorini_contact::StageOutcome;

use super::shared::{Outcome, Shared};
use crate::interior::{Ground, InteriorLaw, InteriorStart};
use crate::iterate::Iterate;
use crate::proximal::ProximalWeight;
use crate::residual::RESIDUALS;
use crate::task::{Look, Task};

/// The interior point, and where it leads.
#[derive(Clone, Debug, Default)]
pub(super) struct Memory {
    start: InteriorStart,
    ahead: Iterate,
}

pub(super) fn applies(task: &Task, iterate: &Iterate) -> bool {
    task.is_large() && iterate.residual > RESIDUALS.far && !matches!(task.look, Look::Short | Look::Part)
}

/// From the path of Coulomb's law, around its folds where it turns back early.
pub(super) fn run(memory: &mut Memory, shared: &mut Shared, task: &Task, iterate: &mut Iterate) -> Outcome {
    begin_and_iterate(memory, shared, task, iterate, InteriorLaw::Coulomb)
}

/// From the path that begins with all contacts opened.
pub(super) fn run_opened(memory: &mut Memory, shared: &mut Shared, task: &Task, iterate: &mut Iterate) -> Outcome {
    begin_and_iterate(memory, shared, task, iterate, InteriorLaw::Opened)
}

fn begin_and_iterate(
    memory: &mut Memory,
    shared: &mut Shared,
    task: &Task,
    iterate: &mut Iterate,
    law: InteriorLaw,
) -> Outcome {
    let Memory { start, ahead } = memory;
    ahead.clear(task.problem, task.island);
    if !start.run(&mut Ground { map: &mut shared.map, iterate: &mut *ahead, task }, law) {
        return StageOutcome::Lost.into();
    }
    let outcome = shared.iterate(task, ahead, ProximalWeight::falling(task.settings));
    if ahead.residual < iterate.residual {
        std::mem::swap(ahead, iterate);
    }
    outcome
}
