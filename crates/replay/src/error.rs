//! What can go wrong.

use std::path::PathBuf;

use signorini_formats::FormatError;
use signorini_npz::NpzError;
use signorini_recording::RecordingError;
use signorini_simulation::SimulationError;

/// A recording that cannot be checked or exported.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReplayError {
    /// The recording cannot be read.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// The recorded steps cannot be certified.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// The recording does not hold its model's file.
    #[error("the recording does not hold the file of its model '{model}'; give that file")]
    NoSource {
        /// The model's name.
        model: String,
    },
    /// The model's file cannot become a model any more.
    #[error("the model of the recording cannot be built again: {0}")]
    Model(Box<FormatError>),
    /// The ending of a file's name names no format.
    #[error("'{}': no format has this ending; they are .npz, .csv and .mcap", path.display())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// Recordings of Rerun are not written here.
    #[error(
        "'{}': recordings of Rerun are written by the Python package: pip install 'signorini[rerun]', then \
         signorini.load_recording(…).to_rerun('{}')",
        path.display(), path.display()
    )]
    Rerun {
        /// The file.
        path: PathBuf,
    },
    /// A file that cannot be written.
    #[error("cannot write '{}': {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// An archive that cannot be written.
    #[error(transparent)]
    Npz(#[from] NpzError),
    /// An MCAP file that cannot be written.
    #[error("cannot write '{}': {source}", path.display())]
    Mcap {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: Box<mcap::McapError>,
    },
}
