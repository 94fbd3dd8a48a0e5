//! What the solver's stages did, as `solve` and `simulate` tell it.

use serde::Serialize;
use signorini::contact::{StageCounts, StageRun};

/// What a stage did, summed over islands and steps.
#[derive(Clone, Debug, Serialize)]
pub struct StageLine {
    /// Its name.
    pub stage: &'static str,
    /// How often it was asked: once for each island that came to it.
    pub asked: u64,
    /// How often it ended an island: by a solution, or by the proof that there is none.
    pub ended: u64,
    /// Its part of the time of all stages.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_share: Option<f64>,
}

impl StageLine {
    /// The stages that were asked, in their order.
    pub fn list(counts: &StageCounts) -> Vec<Self> {
        let asked = counts.iter().filter(|(_, count)| count.asked > 0);
        asked
            .map(|(stage, count)| Self {
                stage: stage.name(),
                asked: count.asked,
                ended: count.ended,
                time_share: counts.time_share(stage),
            })
            .collect()
    }
}

/// What a stage did on one island.
#[derive(Clone, Debug, Serialize)]
pub struct StageHistory {
    /// The island.
    pub island: u32,
    /// The stage.
    pub stage: &'static str,
    /// Why it ended.
    pub outcome: &'static str,
    /// What the laws lacked after each proximal iteration, relative to the island's velocity scale; `null` where it was no number.
    pub residuals: Vec<Option<f64>>,
}

impl From<&StageRun> for StageHistory {
    fn from(run: &StageRun) -> Self {
        let finite = |x: &f64| x.is_finite().then_some(*x);
        Self {
            island: run.island,
            stage: run.stage.name(),
            outcome: run.outcome.name(),
            residuals: run.residuals.iter().map(finite).collect(),
        }
    }
}
