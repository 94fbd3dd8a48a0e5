//! The result of `export`.

use serde::Serialize;

use super::{Contradiction, FileName, ImportWarning};

/// The result of `export`.
#[derive(Debug, Serialize)]
pub struct Exported {
    /// File written; none where the simulation did not get there.
    pub out: Option<FileName>,
    /// File of the model, or bundled scene.
    pub source: String,
    /// Time at the beginning of the step, s.
    pub time: f64,
    /// Time step, s.
    pub timestep: f64,
    /// Degrees of freedom.
    pub nv: usize,
    /// Contacts, joint limits included.
    pub contacts: usize,
    /// Friction directions of all contacts.
    pub directions: usize,
    /// How the simulation's own solve of the step ended.
    pub status: &'static str,
    /// Whether the problem's negative gaps were taken as zero.
    pub clipped_gaps: bool,
    /// Part θ of overlaps and violations that the problem has; 1 where it is all that is asked for.
    pub theta: f64,
    /// Steps before it that missed their tolerance.
    pub missed_steps: u64,
    /// Why the simulation did not get there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contradiction: Option<Contradiction>,
    /// Import report.
    pub warnings: Vec<ImportWarning>,
}
