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
}

pub(super) fn applies(task: &Task, iterate: &Iterate) -> bool {
    task.is_large() && iterate.residual > RESIDUALS.far && !matches!(task.look, Look::Short | Look::Part)
}

/// From the path of Coulomb's law; where it turns back early around its folds, unless the island is warm: that may take thousands of
/// factorisations, and an island that had a solution a step before has it only at a second look.
pub(super) fn run(memory: &mut Memory, shared: &mut Shared, task: &Task, iterate: &mut Iterate) -> Outcome {
    let Memory { start, ahead } = memory;
    ahead.clear(task.problem, task.island);
    if !start.run(&mut Ground { map: &mut shared.map, iterate: &mut *ahead, task }) {
        return StageOutcome::Lost.into();
    }
    let outcome = shared.iterate(task, ahead, ProximalWeight::falling(task.settings));
    if ahead.residual < iterate.residual {
        std::mem::swap(ahead, iterate);
    }
    outcome
}
