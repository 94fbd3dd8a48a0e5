//! How a solve ended, and what was done for it.

use signorini_complementarity::Refusal;

use crate::stages::StageCounts;

/// What a solve ended with.
#[derive(Clone, Debug, PartialEq, Default)]
#[non_exhaustive]
pub enum SolveStatus {
    /// Every law holds within the tolerance.
    #[default]
    Solved,
    /// The best point found; its residuals exceed the tolerance, or are no numbers to rely on because the impulses are too large.
    Inaccurate,
    /// No solution was found, and Lemke's path ended on a ray: these contacts wedge each other (φ < 0 and a cone that is not pointed).
    /// That is no proof that there is none, as gaps are negative ([`Infeasible`](Self::Infeasible) is one).
    Ray {
        /// Contacts with an impulse along the ray, ascending.
        contacts: Vec<usize>,
    },
    /// No impulses satisfy the rows: the gaps contradict each other.
    Infeasible {
        /// Contacts whose rows contradict each other, ascending.
        contacts: Vec<usize>,
    },
    /// The number of pivots was used up.
    IterationLimit,
    /// The LCP does not meet a hypothesis of the method's theory; rows are those of the standard LCP, of the condensed one where
    /// the problem has bilateral rows.
    Refused(Refusal),
    /// The LCP has more pairs than the method accepts.
    TooLarge {
        /// The largest number it accepts.
        limit: usize,
    },
}

/// What was done, for reports and recordings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct SolveReport {
    /// Islands with at least one contact or bilateral row.
    pub islands: usize,
    /// Islands at rest that nothing was solved for (`SolverSettings::sleeping`).
    pub sleeping_islands: usize,
    /// LU factorisations.
    pub factorizations: u32,
    /// Changes of a contact's mode.
    pub mode_changes: u32,
    /// Proximal iterations.
    pub proximal_iterations: u32,
    /// Islands that had another look, because the certificate did not hold with what was found first.
    pub restarts: u32,
    /// Islands given to Lemke's method, and its pivots.
    pub lemke_islands: u32,
    /// Pivots of Lemke's method.
    pub lemke_pivots: u32,
    /// Contact sweeps, the most that an island had.
    pub sweeps: u32,
    /// Islands that were left because the sweeps of the budget (`SolverSettings::budget`) were used up.
    pub unfinished_islands: u32,
    /// What each stage did.
    pub stages: StageCounts,
}

impl SolveReport {
    /// One number for plots: mode changes, proximal iterations and pivots.
    pub fn iterations(&self) -> u32 {
        self.mode_changes + self.proximal_iterations + self.lemke_pivots
    }

    /// Adds what another solve of the same step did.
    pub fn accumulate(&mut self, other: &Self) {
        (self.islands, self.sleeping_islands) = (other.islands, other.sleeping_islands);
        self.factorizations += other.factorizations;
        self.mode_changes += other.mode_changes;
        self.proximal_iterations += other.proximal_iterations;
        self.restarts += other.restarts;
        self.lemke_islands += other.lemke_islands;
        self.lemke_pivots += other.lemke_pivots;
        self.sweeps += other.sweeps;
        self.unfinished_islands = other.unfinished_islands;
        self.stages.add(&other.stages);
    }
}
