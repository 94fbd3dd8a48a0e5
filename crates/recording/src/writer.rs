//! Appending frames to a file while a run goes on.

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};

use signorini_files::WholeFile;

use crate::error::RecordingError;
use crate::frame::Frame;
use crate::header::{Header, SCHEMA_VERSION};
use crate::layout;

/// First bytes of every recording; the first byte is not text, the last catches changed line ends.
pub(crate) const MAGIC: [u8; 8] = *b"\x89SIGREC\n";
/// Length and checksum before a record's payload.
pub(crate) const RECORD_PREFIX: usize = 8;

/// Writes a recording, one frame at a time.
///
/// Each frame is given to the output in one call, so nothing is lost with the process when the
/// output is a file. After the largest frame has been seen, appending allocates nothing.
#[derive(Debug)]
pub struct Writer<W: Write> {
    file: PathBuf,
    output: W,
    header: Header,
    frames: usize,
    record: Vec<u8>,
}

impl Writer<File> {
    /// Creates (or replaces) a file and writes the header.
    ///
    /// # Errors
    /// [`RecordingError::InvalidHeader`], [`RecordingError::Io`].
    pub fn create(path: impl AsRef<Path>, header: Header) -> Result<Self, RecordingError> {
        header.validate()?;
        let file = path.as_ref().to_path_buf();
        match File::create(&file) {
            Ok(output) => Self::start(file, output, header),
            Err(source) => Err(RecordingError::Io { file, source }),
        }
    }
}

impl Writer<WholeFile> {
    /// Begins a file that takes its place when the output is finished.
    pub(crate) fn whole(path: &Path, header: Header) -> Result<Self, RecordingError> {
        header.validate()?;
        let file = path.to_path_buf();
        match WholeFile::create(&file) {
            Ok(output) => Self::start(file, output, header),
            Err(source) => Err(RecordingError::Io { file, source }),
        }
    }
}

impl<W: Write> Writer<W> {
    /// Writes the header to any output.
    ///
    /// # Errors
    /// [`RecordingError::InvalidHeader`], [`RecordingError::Io`].
    pub fn new(output: W, header: Header) -> Result<Self, RecordingError> {
        header.validate()?;
        Self::start("(stream)".into(), output, header)
    }

    fn start(file: PathBuf, output: W, mut header: Header) -> Result<Self, RecordingError> {
        header.schema_version = SCHEMA_VERSION;
        let invalid = |problem| RecordingError::InvalidHeader { field: "size".into(), problem };
        let json = serde_json::to_vec(&header).map_err(|_| invalid("cannot be written as JSON"))?;
        let length = u32::try_from(json.len()).map_err(|_| invalid("must be below 4 GiB"))?;
        let mut record = MAGIC.to_vec();
        record.extend(SCHEMA_VERSION.to_le_bytes());
        record.extend(length.to_le_bytes());
        record.extend(crc32fast::hash(&json).to_le_bytes());
        record.extend(json);
        let mut writer = Self { file, output, header, frames: 0, record };
        writer.write_record()?;
        Ok(writer)
    }

    /// The header as written.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// Number of frames written so far.
    pub fn frames(&self) -> usize {
        self.frames
    }

    /// Appends one frame.
    ///
    /// # Errors
    /// [`RecordingError::FrameMismatch`] when it does not fit the header,
    /// [`RecordingError::FrameTooLarge`], [`RecordingError::Io`]. After an input or output error the
    /// file's last record may be incomplete; readers stop before it.
    pub fn append(&mut self, frame: &Frame) -> Result<(), RecordingError> {
        let index = self.frames;
        layout::check(frame, &self.header).map_err(|mismatch| mismatch.in_frame(index))?;
        let size = layout::encoded_size(frame);
        size.ok_or(RecordingError::FrameTooLarge { frame: index })?;
        self.start_record();
        layout::encode(frame, &mut self.record);
        self.finish_record()?;
        self.frames += 1;
        Ok(())
    }

    /// Marks the run as ended for `reason` (for people, such as "reached 10 s" or "the constraints
    /// contradict each other at step 120") and gives the output back.
    ///
    /// # Errors
    /// [`RecordingError::Io`].
    pub fn finish(mut self, reason: &str) -> Result<W, RecordingError> {
        self.start_record();
        self.record.push(layout::END);
        self.record.extend((self.frames as u64).to_le_bytes());
        self.record.extend(reason.as_bytes());
        self.finish_record()?;
        match self.output.flush() {
            Ok(()) => Ok(self.output),
            Err(source) => Err(RecordingError::Io { file: self.file, source }),
        }
    }

    /// Gives the output back without marking the run as ended.
    pub fn into_output(self) -> W {
        self.output
    }

    fn start_record(&mut self) {
        self.record.clear();
        self.record.extend([0; RECORD_PREFIX]);
    }

    fn finish_record(&mut self) -> Result<(), RecordingError> {
        let payload = &self.record[RECORD_PREFIX..];
        let length = payload.len() as u32;
        let crc = crc32fast::hash(payload);
        self.record[..4].copy_from_slice(&length.to_le_bytes());
        self.record[4..RECORD_PREFIX].copy_from_slice(&crc.to_le_bytes());
        self.write_record()
    }

    fn write_record(&mut self) -> Result<(), RecordingError> {
        let io = |source| RecordingError::Io { file: self.file.clone(), source };
        self.output.write_all(&self.record).map_err(io)
    }
}
