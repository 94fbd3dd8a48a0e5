//! What can be wrong with a picture.

/// Most pixels along either side of a picture.
pub const LARGEST: usize = 16_384;

/// A picture that cannot be made or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// No camera has this name.
    #[error("there is no camera '{name}'; {}", known(cameras))]
    UnknownCamera {
        /// The name.
        name: String,
        /// The names that there are.
        cameras: Vec<String>,
    },
    /// A picture without pixels, or with more than memory should hold.
    #[error("a picture of {width} x {height} pixels: both must be between 1 and {}", LARGEST)]
    Size {
        /// Pixels in a row.
        width: usize,
        /// Number of rows.
        height: usize,
    },
    /// A frame of a film is not as large as those before.
    #[error("a frame of {found:?} pixels in a film of {expected:?}")]
    FrameSize {
        /// Width and height of the film.
        expected: [usize; 2],
        /// Width and height of the frame.
        found: [usize; 2],
    },
    /// A film that cannot be made.
    #[error("a film cannot be made: {0}")]
    Film(String),
    /// Poses or a configuration for another model.
    #[error("{what} has {found} entries where the model needs {expected}")]
    WrongLength {
        /// What was given.
        what: &'static str,
        /// Number of entries needed.
        expected: usize,
        /// Number of entries found.
        found: usize,
    },
    /// The file cannot be written.
    #[error("the picture cannot be written: {0}")]
    Write(#[from] std::io::Error),
    /// What the encoder says.
    #[error("the picture cannot be encoded: {0}")]
    Encode(String),
}

fn known(cameras: &[String]) -> String {
    if cameras.is_empty() {
        return "the model has none: leave the name out for a view of the whole scene".into();
    }
    format!("the model has: {}", cameras.join(", "))
}

impl From<png::EncodingError> for RenderError {
    fn from(error: png::EncodingError) -> Self {
        match error {
            png::EncodingError::IoError(error) => Self::Write(error),
            other => Self::Encode(other.to_string()),
        }
    }
}
