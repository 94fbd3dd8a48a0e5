//! A recording in memory.

use std::io::{Read, Seek};
use std::path::Path;

use crate::error::RecordingError;
use crate::frame::Frame;
use crate::header::Header;
use crate::layout;
use crate::reader::{Ending, Reader};
use crate::writer::Writer;

/// A header, its frames, and how the run ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    header: Header,
    frames: Vec<Frame>,
    ending: Ending,
}

impl Recording {
    /// A recording without frames.
    ///
    /// # Errors
    /// [`RecordingError::InvalidHeader`].
    pub fn new(header: Header) -> Result<Self, RecordingError> {
        header.validate()?;
        let ending = Ending::Interrupted { leftover: 0 };
        Ok(Self { header, frames: Vec::new(), ending })
    }

    /// Reads a file with all its complete frames.
    ///
    /// # Errors
    /// As [`Reader::open`] and [`Reader::frame_into`].
    pub fn read(path: impl AsRef<Path>) -> Result<Self, RecordingError> {
        Self::from_reader(&mut Reader::open(path)?)
    }

    /// All complete frames of a reader.
    ///
    /// # Errors
    /// As [`Reader::frame_into`].
    pub fn from_reader<R: Read + Seek>(reader: &mut Reader<R>) -> Result<Self, RecordingError> {
        let frames = reader.frames().collect::<Result<_, _>>()?;
        Ok(Self { header: reader.header().clone(), frames, ending: reader.ending().clone() })
    }

    /// Writes a file, whole or not at all; it is marked as finished if this recording is.
    ///
    /// # Errors
    /// As [`Writer::create`] and [`Writer::append`]; what was there before then stays.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), RecordingError> {
        let file = path.as_ref();
        let io = |source| RecordingError::Io { file: file.to_owned(), source };
        let mut writer = Writer::whole(file, self.header.clone())?;
        for frame in &self.frames {
            writer.append(frame)?;
        }
        let output = match &self.ending {
            Ending::Finished { reason } => writer.finish(reason)?,
            Ending::Interrupted { .. } | Ending::Damaged { .. } => writer.into_output(),
        };
        output.finish().map_err(io)
    }

    /// Appends a frame.
    ///
    /// # Errors
    /// [`RecordingError::FrameMismatch`] when it does not fit the header.
    pub fn push(&mut self, frame: Frame) -> Result<(), RecordingError> {
        let index = self.frames.len();
        layout::check(&frame, &self.header).map_err(|mismatch| mismatch.in_frame(index))?;
        self.frames.push(frame);
        Ok(())
    }

    /// Marks the run as ended for `reason`.
    pub fn finish(&mut self, reason: impl Into<String>) {
        self.ending = Ending::Finished { reason: reason.into() };
    }

    /// What was simulated.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// The frames in order.
    pub fn frames(&self) -> &[Frame] {
        &self.frames
    }

    /// How the run ended.
    pub fn ending(&self) -> &Ending {
        &self.ending
    }
}
