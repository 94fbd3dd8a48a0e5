//! What a simulation adds up to.

use serde::Serialize;
use signorini::Simulation;
use signorini::contact::{LackingRow, ResidualSpread};

use super::{Contradiction, FileName, ImportWarning, Involved, Laws, StageLine};
use crate::solving::ContactLaw;

/// The result of `simulate`.
#[derive(Clone, Debug, Serialize)]
pub struct RunResult {
    /// How the run ended.
    pub status: RunStatus,
    /// Name of the model.
    pub model: String,
    /// File, or bundled scene.
    pub source: String,
    /// Number of moving bodies.
    pub bodies: usize,
    /// Degrees of freedom.
    pub nv: usize,
    /// Time step, s.
    pub timestep: f64,
    /// Friction directions.
    pub directions: usize,
    /// Solver.
    pub method: String,
    /// Tolerance on every residual.
    pub tolerance: f64,
    /// Gaps of at most this counted as closed, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap_resolution: Option<f64>,
    /// How many bodies the last step left alone, because they sleep.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bodies_asleep: Option<usize>,
    /// Time at start and end, s.
    pub time: Range,
    /// Steps made.
    pub steps: u64,
    /// Steps whose residuals exceed the tolerance.
    pub missed_steps: u64,
    /// Details of the steps that missed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub missed: Option<Miss>,
    /// Steps whose sweeps were used up, where these are counted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub budget: Option<Budget>,
    /// Steps that the laws permitted to remove a part θ of their overlaps and violations only.
    pub limited_steps: u64,
    /// The smallest θ.
    pub smallest_theta: f64,
    /// The largest overlap or violation that such a step kept, m or rad.
    pub deepest_kept: f64,
    /// Work of the impulses along corrections of overlaps and violations, J.
    pub correction_energy: f64,
    /// By how much the energy rose where corrections put in at least that, J.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy_from_corrections: Option<f64>,
    /// The most contact points of a step that no joint can move along their normal; they are left out.
    pub left_out_max: usize,
    /// Steps in which penetrations were taken as zero.
    pub clipped_steps: u64,
    /// Largest number of contacts in a step.
    pub contacts_max: usize,
    /// The law of friction that `worst` speaks of.
    pub law: ContactLaw,
    /// Largest residual of each law over the run.
    pub worst: Laws,
    /// The same of the circular cone's laws, where the law of friction asks for them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub worst_circular: Option<Laws>,
    /// Solver iterations of all steps.
    pub iterations: u64,
    /// What the structured solver's stages did in all steps.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub stages: Vec<StageLine>,
    /// Wall time of the steps, s; writing recording and report is not counted.
    pub seconds: f64,
    /// Steps in one second of wall time.
    pub steps_per_second: f64,
    /// Kinetic and potential energy together, J.
    pub energy: Range,
    /// Deepest penetration at the beginning of a step, m.
    pub deepest_penetration: f64,
    /// Why the run could not go on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contradiction: Option<Contradiction>,
    /// Import report.
    pub warnings: Vec<ImportWarning>,
    /// Recording written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub recording: Option<FileName>,
    /// Report written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub report: Option<FileName>,
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RunStatus {
    /// The time is over and every step is within the tolerance.
    Finished,
    /// The time is over; steps missed their tolerance.
    MissedTolerance,
    /// A step has no solution, or none was found.
    NoSolution,
    /// A signal ended the run before its time was over.
    Interrupted,
}

/// A quantity at the start and at the end.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Range {
    /// At the start.
    pub start: f64,
    /// At the end.
    pub end: f64,
}

/// What a budget of sweeps left open.
#[derive(Clone, Debug, Serialize)]
pub struct Budget {
    /// Sweeps a step.
    pub sweeps: u32,
    /// Steps whose sweeps were used up.
    pub unfinished_steps: u64,
    /// The largest root mean square of a step's residuals.
    pub largest_rms: f64,
    /// The step that lacked most.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub worst: Option<Unfinished>,
}

/// The row of a step that lacked most when the sweeps were used up.
#[derive(Clone, Debug, Serialize)]
pub struct Unfinished {
    /// Time at the beginning of the step, s.
    pub time: f64,
    /// What the row lacks, relative to the velocity scale.
    pub residual: f64,
    /// Root mean square of what all rows of the step lack.
    pub rms: f64,
    /// `contact`, `friction group` or `bilateral`.
    pub row: &'static str,
    /// Its number in the step's problem.
    pub index: usize,
    /// The contact or limit, where it is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contact: Option<Involved>,
}

impl Unfinished {
    /// What a step lacks most.
    ///
    /// - `simulation`: after the step; `time`: at its beginning
    pub fn of(simulation: &Simulation, spread: &ResidualSpread, time: f64) -> Self {
        let (row, index) = match spread.worst_row {
            LackingRow::Contact(i) => ("contact", i),
            LackingRow::FrictionGroup(j) => ("friction group", j),
            LackingRow::Bilateral(k) => ("bilateral", k),
        };
        let contact = if row == "contact" { Involved::of(simulation, index) } else { None };
        Self { time, residual: spread.worst, rms: spread.rms, row, index, contact }
    }
}

/// Steps that missed their tolerance.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Miss {
    /// Time of the first one, s.
    pub first_time: f64,
    /// Largest residual.
    pub worst: f64,
    /// The law it belongs to.
    pub worst_law: &'static str,
    /// Its time, s.
    pub worst_time: f64,
}
