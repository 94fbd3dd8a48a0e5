use signorini_recording::RecordingError;

use crate::message;

/// Why a viewer cannot be started.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ViewerError {
    /// The port cannot be listened on.
    #[error("cannot listen on 127.0.0.1:{port}: {source}; choose another port, or 0 for a free one")]
    Port {
        /// The port.
        port: u16,
        /// What the system says.
        source: std::io::Error,
    },
    /// The speed is out of its range.
    #[error("speed = {found}: must be between {} and {}", message::SPEEDS.start(), message::SPEEDS.end())]
    Speed {
        /// What it is.
        found: f64,
    },
    /// The system gives no random numbers.
    #[error("the system gives no random numbers for the address: {0}")]
    Random(getrandom::Error),
    /// A thread cannot be started.
    #[error("cannot start a thread: {0}")]
    Thread(std::io::Error),
    /// The model cannot be shown.
    #[error(transparent)]
    Recording(#[from] RecordingError),
}
