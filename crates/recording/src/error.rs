//! What can be wrong with a recording.

use std::path::PathBuf;

/// Why a recording could not be written, read or shown.
///
/// A recording that merely stops early is not an error; see [`Ending`](crate::Ending).
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordingError {
    /// The operating system refused to read or write.
    #[error("{}: {source}", file.display())]
    Io {
        /// The file, or a name for the stream.
        file: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The file does not start like a recording.
    #[error("{}: not a recording (the first eight bytes differ)", file.display())]
    NotARecording {
        /// The file.
        file: PathBuf,
    },
    /// The file was written by a later version of the format.
    #[error(
        "{}: has schema version {found}, this program reads up to {known}; use a newer program",
        file.display()
    )]
    NewerSchema {
        /// The file.
        file: PathBuf,
        /// The file's version.
        found: u32,
        /// The version that this program writes.
        known: u32,
    },
    /// The header is cut short, fails its checksum, or is not the JSON it should be.
    #[error("{}: the header cannot be read: {problem}", file.display())]
    DamagedHeader {
        /// The file.
        file: PathBuf,
        /// What is wrong.
        problem: String,
    },
    /// A header value contradicts the others or is not finite.
    #[error("the header's {field} is not valid: {problem}")]
    InvalidHeader {
        /// Which field, for example `geoms[3].body`.
        field: String,
        /// What is wrong.
        problem: &'static str,
    },
    /// A frame does not fit the header.
    #[error("frame {frame}: {field} has {found}, the header asks for {expected}")]
    FrameMismatch {
        /// Index of the frame in the recording.
        frame: usize,
        /// Which field.
        field: &'static str,
        /// What the header implies (a length, or a bound for an index).
        expected: usize,
        /// What the frame has.
        found: usize,
    },
    /// A frame passed its checksum but is not laid out as the schema says.
    #[error("{}: frame {frame} (at byte {offset}) is not laid out as the schema says", file.display())]
    DamagedFrame {
        /// The file.
        file: PathBuf,
        /// Index of the frame.
        frame: usize,
        /// Where its record starts.
        offset: u64,
    },
    /// A frame beyond the end was asked for.
    #[error("frame {frame} was asked for, the recording has {count}")]
    NoSuchFrame {
        /// The index asked for.
        frame: usize,
        /// The number of complete frames.
        count: usize,
    },
    /// A frame has more entries than the format can hold.
    #[error("frame {frame} exceeds 4 GiB")]
    FrameTooLarge {
        /// Index of the frame.
        frame: usize,
    },
}
