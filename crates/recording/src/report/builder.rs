//! Collecting frames for a report, thinning as they come.

use std::io::Write;
use std::path::Path;

use signorini_files::WholeFile;

use super::ReportSettings;
use super::coding;
use super::meshes::PageMeshes;
use super::page::{self, About};
use super::payload::{ArrayPlace, Bin, Form, Payload, kept_size};
use super::run::Run;
use crate::error::RecordingError;
use crate::frame::Frame;
use crate::header::Header;
use crate::layout;
use crate::reader::Ending;

/// Kept frames may take this many times the file's size before they are packed.
const EXPECTED_COMPRESSION: usize = 6;

/// Meshes become coarser until they take no more than one part in so many of the file's size.
const MESH_PART: usize = 3;

/// A kept frame and what the frames up to the next kept one add to it.
#[derive(Debug)]
struct Kept {
    frame: Frame,
    bin: Bin,
}

/// Builds a report from frames that come one at a time; memory stays within the settings' limits
/// however long the run is.
#[derive(Debug)]
pub struct ReportBuilder {
    /// Without the triangles of its meshes.
    header: Header,
    meshes: PageMeshes,
    settings: ReportSettings,
    run: Run,
    kept: Vec<Kept>,
    /// Frames from one kept frame to the next.
    stride: usize,
    /// The latest frame, while it is not a kept one.
    latest: Option<Frame>,
    /// Bytes of the kept frames before they are packed.
    bytes: usize,
    /// Bytes of packed data that the file has room for.
    room: usize,
}

impl ReportBuilder {
    /// A report without frames.
    ///
    /// # Errors
    /// [`RecordingError::InvalidHeader`].
    pub fn new(header: Header, settings: ReportSettings) -> Result<Self, RecordingError> {
        header.validate()?;
        let mut header = header.without_source();
        let meshes = PageMeshes::take_from(&mut header, settings.max_bytes / MESH_PART);
        let room = settings.max_bytes.saturating_sub(page::empty_length(&header, &meshes)?);
        Ok(Self {
            header,
            meshes,
            settings,
            run: Run::default(),
            kept: Vec::new(),
            stride: 1,
            latest: None,
            bytes: 0,
            room,
        })
    }

    /// Adds the next frame.
    ///
    /// # Errors
    /// [`RecordingError::FrameMismatch`] when it does not fit the header.
    pub fn push(&mut self, frame: &Frame) -> Result<(), RecordingError> {
        let index = self.run.frames;
        layout::check(frame, &self.header).map_err(|mismatch| mismatch.in_frame(index))?;
        self.run.add(frame);
        let bin = Bin::of(frame);
        match self.kept.last_mut() {
            Some(kept) if !index.is_multiple_of(self.stride) => {
                kept.bin.merge(&bin);
                self.latest = Some(frame.clone());
            }
            _ => {
                self.bytes += kept_size(frame);
                self.kept.push(Kept { frame: frame.clone(), bin });
                self.latest = None;
            }
        }
        while self.kept.len() > 2 && self.exceeds_limits() {
            self.thin();
        }
        Ok(())
    }

    /// Writes the page; `ending` says how the run ended.
    ///
    /// # Errors
    /// [`RecordingError::Io`].
    pub fn write(mut self, output: &mut impl Write, ending: &Ending) -> Result<(), RecordingError> {
        let (mut arrays, mut data) = self.pack();
        while data.len() > self.room && self.kept.len() > 2 {
            self.thin();
            (arrays, data) = self.pack();
        }
        let about = About {
            header: &self.header,
            meshes: &self.meshes,
            run: &self.run,
            ending: match ending {
                Ending::Finished { reason } => Some(reason),
                Ending::Interrupted { .. } | Ending::Damaged { .. } => None,
            },
            stride: self.stride,
            notes: &self.settings.notes,
            arrays: &arrays,
            live: false,
        };
        page::write(&self.settings.title, &about, data, output)
    }

    /// Writes the page to a file, whole or not at all.
    ///
    /// # Errors
    /// [`RecordingError::Io`].
    pub fn write_file(self, path: impl AsRef<Path>, ending: &Ending) -> Result<(), RecordingError> {
        let io = |source| RecordingError::Io { file: path.as_ref().to_path_buf(), source };
        let mut output = WholeFile::create(&path).map_err(io)?;
        self.write(&mut output, ending).map_err(|error| match error {
            RecordingError::Io { source, .. } => io(source),
            other => other,
        })?;
        output.finish().map_err(io)
    }

    /// The kept frames' arrays, deflated and as text.
    fn pack(&self) -> (Vec<ArrayPlace>, String) {
        let mut payload = Payload::new(Form::Small);
        for kept in &self.kept {
            payload.add(&kept.frame, &kept.bin);
        }
        if let Some(latest) = &self.latest {
            payload.add(latest, &Bin::of(latest));
        }
        let (arrays, bytes) = payload.pack();
        (arrays, coding::pack(&bytes))
    }

    fn exceeds_limits(&self) -> bool {
        self.kept.len() > self.settings.max_frames.max(2) || self.bytes > EXPECTED_COMPRESSION * self.room
    }

    /// Keeps every second of the kept frames.
    fn thin(&mut self) {
        let last = self.kept.len() - 1;
        self.stride *= 2;
        let mut thinned: Vec<Kept> = Vec::with_capacity(self.kept.len() / 2 + 1);
        for (i, kept) in self.kept.drain(..).enumerate() {
            if i % 2 == 0 {
                thinned.push(kept);
                continue;
            }
            if let Some(before) = thinned.last_mut() {
                before.bin.merge(&kept.bin);
            }
            if i == last && self.latest.is_none() {
                self.latest = Some(kept.frame);
            }
        }
        self.kept = thinned;
        self.bytes = self.kept.iter().map(|kept| kept_size(&kept.frame)).sum();
    }
}
