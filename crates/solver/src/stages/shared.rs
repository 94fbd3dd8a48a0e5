//! What the stages share: how one ends, and the proximal map that several of them work with.

use signorini_contact::{SolveStatus, StageOutcome};

use crate::iterate::Iterate;
use crate::proximal::{End, ProximalIterations, ProximalMap, ProximalWeight};
use crate::task::Task;

/// How a stage ended, and what to report if that is the end.
#[derive(Clone, Debug)]
pub(super) struct Outcome {
    pub why: StageOutcome,
    pub status: Option<SolveStatus>,
}

impl From<StageOutcome> for Outcome {
    fn from(why: StageOutcome) -> Self {
        Self { why, status: None }
    }
}

/// Memory that belongs to no stage alone.
#[derive(Clone, Debug, Default)]
pub(super) struct Shared {
    pub map: ProximalMap,
    pub proximal: ProximalIterations,
    /// Residuals that the stage at hand met, where they are asked for.
    pub residuals: Vec<f64>,
}

impl Shared {
    /// Proximal iterations from an iterate.
    pub fn iterate(&mut self, task: &Task, iterate: &mut Iterate, weight: ProximalWeight) -> Outcome {
        let Self { map, proximal, residuals } = self;
        let mut history = |residual| {
            if task.settings.record_history {
                residuals.push(residual);
            }
        };
        let why = match proximal.run(map, task, iterate, weight, &mut history) {
            End::Polished | End::Accepted => StageOutcome::Solved,
            End::Contradiction => StageOutcome::Contradiction,
            End::Slow => StageOutcome::Slow,
            End::Lost => StageOutcome::Lost,
            End::Limit => StageOutcome::OutOfIterations,
        };
        why.into()
    }
}
