//! What the formats share: files, and contacts and statuses in words and numbers.

use std::path::Path;

use signorini_files::WholeFile;
use signorini_recording::{ContactModeCode, RecordedContact, StepStatus};

use crate::ReplayError;

/// A new file, which is there once it is complete.
pub(super) fn create(path: &Path) -> Result<WholeFile, ReplayError> {
    WholeFile::create(path).map_err(|source| ReplayError::Write { path: path.to_owned(), source })
}

/// Puts it in its place.
pub(super) fn finish(output: WholeFile, path: &Path) -> Result<(), ReplayError> {
    output.finish().map_err(|source| ReplayError::Write { path: path.to_owned(), source })
}

/// The status of a step as a word.
pub(super) fn status_name(status: StepStatus) -> &'static str {
    match status {
        StepStatus::Solved => "solved",
        StepStatus::Inaccurate => "inaccurate",
        StepStatus::Ray => "ray",
        StepStatus::Infeasible => "infeasible",
        StepStatus::IterationLimit => "iteration_limit",
        StepStatus::NumericalFailure => "numerical_failure",
        _ => "unknown",
    }
}

/// What a contact does, as a word and as `signorini.ContactMode` in Python numbers it: 0 open, 1 frictionless, 2 sticking, 3 sliding.
pub(super) fn mode_of(contact: &RecordedContact) -> (&'static str, i32) {
    match contact.mode {
        ContactModeCode::Open => ("open", 0),
        ContactModeCode::Sticking if contact.friction == 0.0 => ("frictionless", 1),
        ContactModeCode::Sticking => ("sticking", 2),
        ContactModeCode::Sliding { .. } | ContactModeCode::SlidingBetween { .. } => ("sliding", 3),
    }
}

/// The mean force of a step on the second body of a contact, world axes, N.
pub(super) fn force(contact: &RecordedContact, timestep: f64) -> [f64; 3] {
    let [t_1, t_2] = contact.lambda_t;
    let axes = [contact.normal, contact.tangent_1, contact.tangent_2];
    [0, 1, 2].map(|k| (contact.lambda_n * axes[0][k] + t_1 * axes[1][k] + t_2 * axes[2][k]) / timestep)
}
