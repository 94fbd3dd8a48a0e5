//! Recordings in other programs' formats.
//!
//! | ending | what | for |
//! |---|---|---|
//! | `.npz` | every quantity as one array over all frames | NumPy |
//! | `.csv` | one row per frame: state, energy, residuals | spreadsheets |
//! | `.mcap` | poses, shapes, forces, contacts, certificates as timed messages | Foxglove, MCAP tools |

mod csv;
mod mcap;
mod npz;

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use crate::{FrameSource, ReplayError};

pub use self::csv::write_csv;
pub use self::mcap::write_mcap;
pub use npz::write_npz;

/// Writes a recording in the format that the ending of the file's name says: `.npz`, `.csv` or `.mcap`.
///
/// # Errors
/// [`ReplayError::UnknownFormat`], and those of [`write_npz`], [`write_csv`], [`write_mcap`]. For `.rrd`,
/// [`ReplayError::Rerun`], which says what writes it.
pub fn export(frames: &mut impl FrameSource, path: &Path) -> Result<(), ReplayError> {
    let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default().to_ascii_lowercase();
    match ending.as_str() {
        "npz" => write_npz(frames, path),
        "csv" => write_csv(frames, path),
        "mcap" => write_mcap(frames, path),
        "rrd" => Err(ReplayError::Rerun { path: path.to_owned() }),
        _ => Err(ReplayError::UnknownFormat { path: path.to_owned() }),
    }
}

/// A new file, buffered.
fn create(path: &Path) -> Result<BufWriter<File>, ReplayError> {
    File::create(path).map(BufWriter::new).map_err(|source| ReplayError::Write { path: path.to_owned(), source })
}

/// Everything to the disk.
fn finish(mut output: BufWriter<File>, path: &Path) -> Result<(), ReplayError> {
    output.flush().map_err(|source| ReplayError::Write { path: path.to_owned(), source })
}

/// The status of a step as a word.
fn status_name(status: signorini_recording::StepStatus) -> &'static str {
    use signorini_recording::StepStatus as S;
    match status {
        S::Solved => "solved",
        S::Inaccurate => "inaccurate",
        S::Ray => "ray",
        S::Infeasible => "infeasible",
        S::IterationLimit => "iteration_limit",
        S::NumericalFailure => "numerical_failure",
        _ => "unknown",
    }
}

/// What a contact does, as a word and as `signorini.ContactMode` in Python numbers it: 0 open, 1 frictionless, 2 sticking, 3 sliding.
fn mode_of(contact: &signorini_recording::ContactFrame) -> (&'static str, i32) {
    use signorini_recording::ContactModeCode as M;
    match contact.mode {
        M::Open => ("open", 0),
        M::Sticking if contact.friction == 0.0 => ("frictionless", 1),
        M::Sticking => ("sticking", 2),
        M::Sliding { .. } | M::SlidingBetween { .. } => ("sliding", 3),
    }
}

/// The mean force of a step on the second body of a contact, world axes, N.
fn force(contact: &signorini_recording::ContactFrame, timestep: f64) -> [f64; 3] {
    let [t_1, t_2] = contact.lambda_t;
    let axes = [contact.normal, contact.tangent_1, contact.tangent_2];
    [0, 1, 2].map(|k| (contact.lambda_n * axes[0][k] + t_1 * axes[1][k] + t_2 * axes[2][k]) / timestep)
}
