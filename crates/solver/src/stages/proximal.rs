//! Proximal iterations from the iterate.

use signorini_contact::StageOutcome;

use super::{Outcome, Workspace};
use crate::iterate::Iterate;
use crate::proximal::{End, ProximalWeight};
use crate::task::{Look, Task};

pub(super) fn applies(_: &Task, _: &Iterate) -> bool {
    true
}

/// Iterates with the usual weight; at the second look at a large island with a large one that falls: what it lacks are a few modes.
pub(super) fn run(workspace: &mut Workspace, task: &Task, iterate: &mut Iterate) -> Outcome {
    let weight = if task.look == Look::Second && task.is_large() {
        ProximalWeight::falling(task.settings)
    } else {
        ProximalWeight::new(task.settings, task.is_large())
    };
    let Workspace { map, proximal, residuals, .. } = workspace;
    let mut history = |residual| {
        if task.settings.record_history {
            residuals.push(residual);
        }
    };
    outcome_of(proximal.run(map, task, iterate, weight, &mut history)).into()
}

/// Why proximal iterations ended, in the words of the report.
pub(super) fn outcome_of(end: End) -> StageOutcome {
    match end {
        End::Polished | End::Accepted => StageOutcome::Solved,
        End::Contradiction => StageOutcome::Contradiction,
        End::Slow => StageOutcome::Slow,
        End::Lost => StageOutcome::Lost,
        End::Limit => StageOutcome::OutOfIterations,
    }
}
