//! Settings of the structured contact solver.

use derive_setters::Setters;
use signorini_contact::ProblemError;

/// The part of the tolerance that islands have to reach: the certificate's number is up to 2.4 times the residual that stages measure.
///
/// Chosen by: certificates of recorded steps of piles, 23 November 2026; with all of the tolerance, `motion/run.py cards10_struck pile100 --seeds 0..10` misses 11
/// steps in place of 2, 29 November 2026.
const ENOUGH: f64 = 0.4;

/// Settings of the structured contact solver. All tolerances are relative to `max|b|`, the data's velocity scale.
#[derive(Clone, Debug, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct SolverSettings {
    /// A solution is `Solved` when every residual of the certificate is at most this. Default 1e-9; range (0, 1).
    pub tolerance: f64,
    /// Proximal iterations stop at this residual, and an island whose warm start has it is taken as it is, in one of 64 contacts or more
    /// if the velocity of the impulses needs no refinement. Default 1e-12; range (0, 1).
    pub polish: f64,
    /// ε of the proximal term, relative to each contact's Delassus block. Default 1e-5; range (0, 1).
    pub proximal_weight: f64,
    /// ε is lowered to this where the iterations converge slowly. Default 1e-10; range (0, 1).
    pub smallest_proximal_weight: f64,
    /// How far outside its mode's cone a trial impulse may lie, relative to its typical size. Default 1e-11; range (0, 1).
    pub mode_tolerance: f64,
    /// Newton steps on all modes at once before the path is followed, and on the impulses of robots, at most. Default 10.
    pub newton_iterations: u32,
    /// How often the path is followed for one proximal problem. Default 4; at least 1.
    pub max_rounds: u32,
    /// Proximal iterations at most; twice as many in an island of 64 contacts or more. Default 60; at least 1.
    pub max_proximal_iterations: u32,
    /// Mode changes any path may use. Default 100.
    pub path_changes_base: u32,
    /// More of them for each contact whose data are shifted, where the path starts from modes at hand: such a path is short
    /// or wanders. Default 8.
    pub path_changes_per_violation: u32,
    /// More of them for each contact, where the path starts with all contacts open. Default 16.
    pub path_changes_per_contact: u32,
    /// Degrees of freedom from which an island of 64 contacts or more is given to [contact sweeps](signorini_contact::StageKind::ContactSweeps) first.
    /// Default 1500: in smaller ones factorisations, whose cost is that of their bodies, cost little more than sweeps, whose cost is that of their contacts.
    pub sweeps_from: usize,
    /// How often a contact is visited at most by [contact sweeps](signorini_contact::StageKind::ContactSweeps), at least 1; none for solutions
    /// as exact as can be. Islands of 64 contacts or more are solved by sweeps alone then, smaller ones where iterations do not solve them;
    /// nothing that takes long is tried. Where the sweeps are used up the best point found comes back as
    /// [`Inaccurate`](signorini_contact::SolveStatus::Inaccurate) with its true certificate: its velocity is that of its impulses,
    /// and these are within the bounds of friction, both to rounding. It is a count and never a clock: the same bits every time. Default none.
    #[setters(into)]
    pub budget: Option<u32>,
    /// Pivots Lemke's method may use for each row. Default 30.
    pub lemke_pivots_per_row: usize,
    /// Islands with more rows in their LCP than this are not given to Lemke's method. Default 1000.
    pub lemke_max_rows: usize,
    /// At most so many threads (of the `rayon` pool that the caller is in) solve islands at the same time, where there are
    /// enough rows beside the largest island; 0 for as many as the pool has, 1 for the caller's alone. The result has the
    /// same bits whatever it is. Default 1: waking threads costs more than small islands do.
    pub threads: usize,
    /// Whether islands that the impulses of the warm start hold still, to rounding, and which are left at velocity zero without solving, are
    /// told as sleeping ([`SolveReport::sleeping_islands`](signorini_contact::SolveReport::sleeping_islands)). Default false.
    pub sleeping: bool,
    /// Whether the time of every stage is measured, for [`SolveReport::stages`](signorini_contact::SolveReport::stages). Default false:
    /// a clock is read twice for each stage of each island.
    pub time_stages: bool,
    /// Whether the residuals on the way are kept, in [`ContactSolution::history`](signorini_contact::ContactSolution::history).
    /// Default false: it allocates.
    pub record_history: bool,
}

impl Default for SolverSettings {
    fn default() -> Self {
        Self {
            tolerance: 1e-9,
            polish: 1e-12,
            proximal_weight: 1e-5,
            smallest_proximal_weight: 1e-10,
            mode_tolerance: 1e-11,
            newton_iterations: 10,
            max_rounds: 4,
            max_proximal_iterations: 60,
            path_changes_base: 100,
            path_changes_per_violation: 8,
            path_changes_per_contact: 16,
            sweeps_from: 1500,
            budget: None,
            lemke_pivots_per_row: 30,
            lemke_max_rows: 1000,
            threads: 1,
            sleeping: false,
            time_stages: false,
            record_history: false,
        }
    }
}

impl SolverSettings {
    /// The same for another [`tolerance`](Self::tolerance), with [`polish`](Self::polish) no larger than it.
    pub fn for_tolerance(self, tolerance: f64) -> Self {
        Self { tolerance, polish: self.polish.min(tolerance), ..self }
    }

    /// The residual with which an island counts as solved: what leaves the certificate some room. A solve costs what its tolerance costs.
    pub(crate) fn accept(&self) -> f64 {
        ENOUGH * self.tolerance
    }

    /// The same for a part of an island that counts as solved with a residual.
    pub(crate) fn for_part(&self, accept: f64) -> Self {
        Self { tolerance: accept / ENOUGH, polish: accept, record_history: false, ..self.clone() }
    }

    /// Checks the ranges.
    ///
    /// # Errors
    /// [`ProblemError::Number`] naming the setting.
    pub fn validate(&self) -> Result<(), ProblemError> {
        for (array, value) in [
            ("tolerance", self.tolerance),
            ("polish", self.polish),
            ("proximal_weight", self.proximal_weight),
            ("smallest_proximal_weight", self.smallest_proximal_weight),
            ("mode_tolerance", self.mode_tolerance),
        ] {
            if !(value > 0.0 && value < 1.0) {
                return Err(ProblemError::Number { array, index: 0, value, expected: "between 0 and 1" });
            }
        }
        let counts = [
            ("max_rounds", self.max_rounds),
            ("max_proximal_iterations", self.max_proximal_iterations),
            ("budget", self.budget.unwrap_or(1)),
        ];
        for (array, value) in counts {
            if value == 0 {
                return Err(ProblemError::Number { array, index: 0, value: 0.0, expected: "at least 1" });
            }
        }
        Ok(())
    }
}
