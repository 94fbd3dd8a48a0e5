//! The frames of a run, one step after the other, into a recording.

use std::fs::File;
use std::io::Write;
use std::path::Path;

use signorini_recording::{Frame, RecordingError, Writer};

use super::{frame_into, last_frame_into, recording_header, step_solution_into};
use crate::Simulation;

/// Records a simulation step by step, with all that is needed to certify the steps again
/// ([`Recertifier`](crate::Recertifier)).
///
/// After the largest frame has been seen, [`add`](Self::add) allocates nothing.
#[derive(Debug)]
pub struct RunRecorder<W: Write> {
    writer: Writer<W>,
    frame: Frame,
    steps: u64,
}

impl RunRecorder<File> {
    /// Creates (or replaces) a file for a run that is about to begin.
    ///
    /// # Errors
    /// [`RecordingError::InvalidHeader`] if the model cannot be described, [`RecordingError::Io`].
    pub fn create(path: impl AsRef<Path>, simulation: &Simulation) -> Result<Self, RecordingError> {
        let header = recording_header(simulation.model(), simulation.settings(), simulation.workspace());
        Ok(Self::new(Writer::create(path, header)?))
    }
}

impl<W: Write> RunRecorder<W> {
    /// Appends to a writer whose header is a [`recording_header`] of the simulation.
    pub fn new(writer: Writer<W>) -> Self {
        Self { writer, frame: Frame::default(), steps: 0 }
    }

    /// Appends the step just made.
    ///
    /// # Errors
    /// As [`Writer::append`].
    pub fn add(&mut self, simulation: &Simulation) -> Result<(), RecordingError> {
        let Simulation { model, workspace, report, input, .. } = simulation;
        // After a step `next` holds the state it was made from.
        let before = if report.advanced() { &simulation.next } else { &simulation.state };
        frame_into(model, self.steps, before, workspace, report, &mut self.frame);
        step_solution_into(input, workspace, report, &mut self.frame);
        self.steps += 1;
        self.writer.append(&self.frame)
    }

    /// Appends the state that the run ended in, says why it ended (for people, such as "reached 10 s"), and gives the output back.
    ///
    /// # Errors
    /// As [`Writer::append`].
    pub fn finish(mut self, simulation: &Simulation, reason: &str) -> Result<W, RecordingError> {
        last_frame_into(simulation.model(), self.steps, simulation.state(), &simulation.input, &mut self.frame);
        self.writer.append(&self.frame)?;
        self.writer.finish(reason)
    }
}
