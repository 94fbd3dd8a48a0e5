//! A start from a central path, and proximal iterations from there: for large islands that are far from their modes.

use signorini_contact::StageOutcome;

use super::proximal::outcome_of;
use super::{Outcome, Workspace};
use crate::interior::{Ground, InteriorLaw};
use crate::iterate::Iterate;
use crate::proximal::ProximalWeight;
use crate::task::{Look, Task};

/// A large island with a smaller residual lacks a few modes, and has a second look first: another start would take all of the way again.
///
/// Chosen by: `sim S4_pile300`, 22 November 2026.
pub(super) const CLOSE: f64 = 1e-4;

pub(super) fn applies(task: &Task, iterate: &Iterate) -> bool {
    task.is_large() && iterate.residual > CLOSE && task.look != Look::Short
}

/// From the path of Coulomb's law, around its folds where it turns back early.
pub(super) fn run(workspace: &mut Workspace, task: &Task, iterate: &mut Iterate) -> Outcome {
    begin_and_iterate(workspace, task, iterate, InteriorLaw::Coulomb)
}

/// From the path that begins with all contacts opened.
pub(super) fn run_opened(workspace: &mut Workspace, task: &Task, iterate: &mut Iterate) -> Outcome {
    begin_and_iterate(workspace, task, iterate, InteriorLaw::Opened)
}

fn begin_and_iterate(workspace: &mut Workspace, task: &Task, iterate: &mut Iterate, law: InteriorLaw) -> Outcome {
    let Workspace { map, interior, ahead, proximal, residuals, .. } = workspace;
    ahead.clear(task.problem, task.island);
    if !interior.run(&mut Ground { map: &mut *map, iterate: &mut *ahead, task }, law) {
        return StageOutcome::Lost.into();
    }
    let mut history = |residual| {
        if task.settings.record_history {
            residuals.push(residual);
        }
    };
    let end = proximal.run(map, task, ahead, ProximalWeight::falling(task.settings), &mut history);
    if ahead.residual < iterate.residual {
        std::mem::swap(ahead, iterate);
    }
    outcome_of(end).into()
}
