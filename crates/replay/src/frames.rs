//! Where frames come from.

use std::io::{Read, Seek};

use signorini_recording::{Frame, Header, Reader, Recording};

use crate::ReplayError;

/// The frames of a recording, one after the other.
pub trait FrameSource {
    /// What was simulated.
    fn header(&self) -> &Header;

    /// Number of frames.
    fn count(&self) -> usize;

    /// Calls `visit` with every frame in order.
    ///
    /// # Errors
    /// The first error of `visit`, or [`ReplayError::Recording`] where a frame cannot be read.
    fn visit(&mut self, visit: &mut dyn FnMut(usize, &Frame) -> Result<(), ReplayError>) -> Result<(), ReplayError>;
}

impl<R: Read + Seek> FrameSource for Reader<R> {
    fn header(&self) -> &Header {
        self.header()
    }

    fn count(&self) -> usize {
        self.len()
    }

    fn visit(&mut self, visit: &mut dyn FnMut(usize, &Frame) -> Result<(), ReplayError>) -> Result<(), ReplayError> {
        let mut frame = Frame::default();
        for i in 0..self.len() {
            self.frame_into(i, &mut frame)?;
            visit(i, &frame)?;
        }
        Ok(())
    }
}

impl FrameSource for &Recording {
    fn header(&self) -> &Header {
        Recording::header(self)
    }

    fn count(&self) -> usize {
        self.frames().len()
    }

    fn visit(&mut self, visit: &mut dyn FnMut(usize, &Frame) -> Result<(), ReplayError>) -> Result<(), ReplayError> {
        self.frames().iter().enumerate().try_for_each(|(i, frame)| visit(i, frame))
    }
}
