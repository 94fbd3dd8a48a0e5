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
mod parts;

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
