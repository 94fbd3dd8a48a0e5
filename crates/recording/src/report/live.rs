//! The same page for a run that goes on: the page first, then its frames in messages.

use serde::Serialize;

use super::meshes::PageMeshes;
use super::page::{self, About};
use super::payload::{ArrayPlace, Bin, Form, Payload};
use super::run::Run;
use crate::error::RecordingError;
use crate::frame::Frame;
use crate::header::Header;
use crate::layout;

/// The block of a message starts at a multiple of this, as typed arrays in browsers need it.
const ALIGNMENT: usize = 8;

/// Meshes become coarser until their text has no more bytes than this.
const MESH_BYTES: usize = 8_000_000;

/// Turns the frames of a run that goes on into a page and messages for it.
///
/// A message holds one frame: the latest since the last message, with the largest residuals, iterations and numbers of
/// contacts of all since then, so that a bad step shows however short it was. It is the length of a JSON text (u32,
/// little-endian), that text, and a block of arrays laid out as in a report. The text says where the arrays are, what the
/// run adds up to, and in which epoch the frame is: frames of an earlier epoch are to be forgotten.
#[derive(Debug)]
pub struct LiveFeed {
    /// Without the triangles of its meshes.
    header: Header,
    meshes: PageMeshes,
    run: Run,
    epoch: u32,
    /// The latest frame; the bin covers the frames since the last message.
    frame: Frame,
    bin: Option<Bin>,
}

/// What a message says besides numbers.
#[derive(Serialize)]
struct MessageHead<'a> {
    epoch: u32,
    run: &'a Run,
    arrays: &'a [ArrayPlace],
}

impl LiveFeed {
    /// A feed without frames.
    ///
    /// # Errors
    /// [`RecordingError::InvalidHeader`].
    pub fn new(header: Header) -> Result<Self, RecordingError> {
        header.validate()?;
        let mut header = header.without_source();
        let meshes = PageMeshes::take_from(&mut header, MESH_BYTES);
        Ok(Self { header, meshes, run: Run::default(), epoch: 0, frame: Frame::default(), bin: None })
    }

    /// The page, which takes its frames from a websocket at the address `socket` beside its own.
    ///
    /// - `title`: the model's name when empty
    /// - `notes`: further lines of the summary, a label and its text
    ///
    /// # Errors
    /// [`RecordingError::InvalidHeader`] when the header cannot be written as JSON.
    pub fn page(&self, title: &str, notes: &[(String, String)]) -> Result<Vec<u8>, RecordingError> {
        let (header, meshes, run) = (&self.header, &self.meshes, &self.run);
        let about = About { header, meshes, run, ending: None, stride: 1, notes, arrays: &[], live: true };
        let mut output = Vec::new();
        page::write(title, &about, String::new(), &mut output)?;
        Ok(output)
    }

    /// Begins anew with a state from which no step was made; `write` fills in the frame.
    ///
    /// # Errors
    /// [`RecordingError::FrameMismatch`] when it does not fit the header.
    pub fn restart(&mut self, write: impl FnOnce(&mut Frame)) -> Result<(), RecordingError> {
        self.run = Run::default();
        self.epoch += 1;
        self.bin = None;
        self.take_frame(write)
    }

    /// Adds the frame of a step; `write` fills it in.
    ///
    /// # Errors
    /// [`RecordingError::FrameMismatch`] when it does not fit the header.
    pub fn push(&mut self, write: impl FnOnce(&mut Frame)) -> Result<(), RecordingError> {
        self.take_frame(write)?;
        self.run.add(&self.frame);
        Ok(())
    }

    fn take_frame(&mut self, write: impl FnOnce(&mut Frame)) -> Result<(), RecordingError> {
        write(&mut self.frame);
        layout::check(&self.frame, &self.header).map_err(|mismatch| mismatch.in_frame(self.run.frames))?;
        let latest = Bin::of(&self.frame);
        match &mut self.bin {
            Some(bin) => bin.merge(&latest),
            None => self.bin = Some(latest),
        }
        Ok(())
    }

    /// The message of the frames since the last one; `None` where there are none.
    pub fn message(&mut self) -> Option<Vec<u8>> {
        let bin = self.bin.take()?;
        Some(self.encode(&bin))
    }

    /// The message of the latest frame alone, for a page that comes later.
    pub fn latest(&self) -> Vec<u8> {
        self.encode(&Bin::of(&self.frame))
    }

    fn encode(&self, bin: &Bin) -> Vec<u8> {
        let mut payload = Payload::new(Form::Plain);
        payload.add(&self.frame, bin);
        let (arrays, block) = payload.pack();
        let head = MessageHead { epoch: self.epoch, run: &self.run, arrays: &arrays };
        let mut text = serde_json::to_vec(&head).expect("numbers and names become JSON");
        text.resize((4 + text.len()).next_multiple_of(ALIGNMENT) - 4, b' ');
        let mut message = Vec::with_capacity(4 + text.len() + block.len());
        message.extend((text.len() as u32).to_le_bytes());
        message.extend(&text);
        message.extend(&block);
        message
    }
}
