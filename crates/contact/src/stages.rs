//! The stages of the structured solver, as reports name them.

use std::ops::{Index, IndexMut};

/// A stage of the structured solver, in the order in which an island goes through them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum StageKind {
    /// The start solves the island already, and is taken as it is.
    Hold,
    /// Newton's method in the space of impulses.
    Impulses,
    /// Modes from projected Gauss–Seidel sweeps.
    Sweeps,
    /// Accelerated sweeps of exact solutions contact by contact, in turn with exact solutions of the parts that lag behind.
    ContactSweeps,
    /// The modes of what stands.
    Standing,
    /// Proximal iterations.
    Proximal,
    /// Modes from the central path of Coulomb's law, then proximal iterations.
    Interior,
    /// Lexicographic Lemke.
    Lemke,
}

impl StageKind {
    /// All stages, in their order.
    pub const ALL: [Self; 8] = [
        Self::Hold,
        Self::Impulses,
        Self::Sweeps,
        Self::ContactSweeps,
        Self::Standing,
        Self::Proximal,
        Self::Interior,
        Self::Lemke,
    ];

    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Hold => "hold",
            Self::Impulses => "impulses",
            Self::Sweeps => "sweeps",
            Self::ContactSweeps => "contact sweeps",
            Self::Standing => "standing",
            Self::Proximal => "proximal",
            Self::Interior => "interior",
            Self::Lemke => "lemke",
        }
    }
}

/// Why a stage ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum StageOutcome {
    /// The laws hold to the accuracy that the stage works to.
    Solved,
    /// Modes are there to begin with.
    Prepared,
    /// The rows are proved to contradict each other.
    Contradiction,
    /// The residual no longer falls.
    Slow,
    /// The stage has nothing to give: its modes were not found, its path did not arrive, its start does not hold.
    Lost,
    /// The number of iterations is used up.
    OutOfIterations,
    /// The sweeps of the budget are used up (`SolverSettings::budget`).
    OutOfBudget,
    /// There is no solution, or none that the method can reach: its path ended on a ray.
    Denied,
    /// The method failed.
    Failed,
}

impl StageOutcome {
    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Solved => "solved",
            Self::Prepared => "prepared",
            Self::Contradiction => "contradiction",
            Self::Slow => "slow",
            Self::Lost => "lost",
            Self::OutOfIterations => "out of iterations",
            Self::OutOfBudget => "out of budget",
            Self::Denied => "denied",
            Self::Failed => "failed",
        }
    }
}

/// What a stage did in one or more solves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct StageCount {
    /// How often it was asked, once for each island.
    pub asked: u64,
    /// How often it ended an island: by a solution, or by the proof that there is none.
    pub ended: u64,
    /// Its time, ns, where that was asked for (`SolverSettings::time_stages`); of all threads together.
    pub nanoseconds: u64,
}

/// What every stage did in one or more solves; indexed by the stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StageCounts([StageCount; StageKind::ALL.len()]);

impl StageCounts {
    /// The stages in their order.
    pub fn iter(&self) -> impl Iterator<Item = (StageKind, StageCount)> {
        StageKind::ALL.into_iter().zip(self.0)
    }

    /// Adds the counts of another solve.
    pub fn add(&mut self, other: &Self) {
        for (sum, count) in self.0.iter_mut().zip(&other.0) {
            sum.asked += count.asked;
            sum.ended += count.ended;
            sum.nanoseconds += count.nanoseconds;
        }
    }

    /// A stage's part of the time of all stages; none where times were not asked for.
    pub fn time_share(&self, stage: StageKind) -> Option<f64> {
        let all: u64 = self.0.iter().map(|count| count.nanoseconds).sum();
        (all > 0).then(|| self[stage].nanoseconds as f64 / all as f64)
    }
}

impl Index<StageKind> for StageCounts {
    type Output = StageCount;

    fn index(&self, stage: StageKind) -> &StageCount {
        &self.0[stage as usize]
    }
}

impl IndexMut<StageKind> for StageCounts {
    fn index_mut(&mut self, stage: StageKind) -> &mut StageCount {
        &mut self.0[stage as usize]
    }
}

/// What a stage did on an island, where that was asked for (`SolverSettings::record_history`).
#[derive(Clone, Debug, PartialEq)]
pub struct StageRun {
    /// The island, by the order of the first tree in each.
    pub island: u32,
    /// The stage.
    pub stage: StageKind,
    /// Why it ended.
    pub outcome: StageOutcome,
    /// What the laws lacked on the way, relative to the island's velocity scale: one number for each proximal iteration.
    pub residuals: Vec<f64>,
}
