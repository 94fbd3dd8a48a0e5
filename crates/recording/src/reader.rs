//! Reading recordings, complete or not.

use std::fs::File;
use std::io::{BufReader, ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use crate::error::RecordingError;
use crate::frame::Frame;
use crate::header::{Header, SCHEMA_VERSION};
use crate::layout;
use crate::writer::{MAGIC, RECORD_PREFIX};

/// How a recording ends.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Ending {
    /// The run ended by itself.
    Finished {
        /// Why, in words.
        reason: String,
    },
    /// The file stops without the mark of a finished run, perhaps within a frame: the run was killed
    /// or still goes on.
    Interrupted {
        /// Bytes after the last complete frame.
        leftover: u64,
    },
    /// A record fails its checksum; it and what follows is left out.
    Damaged {
        /// Where the record starts.
        offset: u64,
    },
}

/// Reads a recording's header at once and its frames when asked for.
///
/// Opening walks through the file and verifies every checksum, so that [`Reader::len`] counts
/// complete and undamaged frames only.
#[derive(Debug)]
pub struct Reader<R: Read + Seek> {
    file: PathBuf,
    input: R,
    header: Header,
    /// Start of each frame's record, and length of its payload.
    index: Vec<(u64, u32)>,
    ending: Ending,
    payload: Vec<u8>,
}

impl Reader<BufReader<File>> {
    /// Opens a file.
    ///
    /// # Errors
    /// [`RecordingError::Io`], [`RecordingError::NotARecording`], [`RecordingError::NewerSchema`],
    /// [`RecordingError::DamagedHeader`], [`RecordingError::InvalidHeader`].
    pub fn open(path: impl AsRef<Path>) -> Result<Self, RecordingError> {
        let file = path.as_ref().to_path_buf();
        match File::open(&file) {
            Ok(input) => Self::new(file, BufReader::new(input)),
            Err(source) => Err(RecordingError::Io { file, source }),
        }
    }
}

/// Whether a file begins as every recording does, however damaged it may be after that.
///
/// # Errors
/// [`RecordingError::Io`].
pub fn is_recording(path: impl AsRef<Path>) -> Result<bool, RecordingError> {
    let file = path.as_ref();
    let io = |source| RecordingError::Io { file: file.to_path_buf(), source };
    let mut start = Vec::new();
    File::open(file).and_then(|input| input.take(MAGIC.len() as u64).read_to_end(&mut start)).map_err(io)?;
    Ok(start == MAGIC)
}

impl<R: Read + Seek> Reader<R> {
    /// Reads from any source; `file` is the name that errors will carry.
    ///
    /// # Errors
    /// As [`Reader::open`].
    pub fn new(file: impl Into<PathBuf>, mut input: R) -> Result<Self, RecordingError> {
        let file = file.into();
        let io = |source| RecordingError::Io { file: file.clone(), source };
        let end = input.seek(SeekFrom::End(0)).map_err(io)?;
        input.rewind().map_err(io)?;
        let (header, first) = read_header(&file, &mut input, end)?;
        let mut reader = Self {
            file,
            input,
            header,
            index: Vec::new(),
            ending: Ending::Interrupted { leftover: 0 },
            payload: Vec::new(),
        };
        reader.ending = reader.scan(first, end)?;
        Ok(reader)
    }

    /// What was simulated.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// Number of complete frames.
    pub fn len(&self) -> usize {
        self.index.len()
    }

    /// Whether there is no complete frame.
    pub fn is_empty(&self) -> bool {
        self.index.is_empty()
    }

    /// How the file ends.
    pub fn ending(&self) -> &Ending {
        &self.ending
    }

    /// Frame `i`.
    ///
    /// # Errors
    /// As [`Reader::frame_into`].
    pub fn frame(&mut self, i: usize) -> Result<Frame, RecordingError> {
        let mut frame = Frame::default();
        self.frame_into(i, &mut frame)?;
        Ok(frame)
    }

    /// Reads frame `i` into `frame`, re-using its memory.
    ///
    /// # Errors
    /// [`RecordingError::NoSuchFrame`], [`RecordingError::Io`], [`RecordingError::DamagedFrame`],
    /// [`RecordingError::FrameMismatch`].
    pub fn frame_into(&mut self, i: usize, frame: &mut Frame) -> Result<(), RecordingError> {
        let count = self.index.len();
        let &(offset, length) = self.index.get(i).ok_or(RecordingError::NoSuchFrame { frame: i, count })?;
        let io = |source| RecordingError::Io { file: self.file.clone(), source };
        self.input.seek(SeekFrom::Start(offset + RECORD_PREFIX as u64)).map_err(io)?;
        self.payload.resize(length as usize, 0);
        self.input.read_exact(&mut self.payload).map_err(io)?;
        if layout::decode_into(&self.payload, frame).is_none() {
            let file = self.file.clone();
            return Err(RecordingError::DamagedFrame { file, frame: i, offset });
        }
        layout::check(frame, &self.header).map_err(|mismatch| mismatch.in_frame(i))
    }

    /// All complete frames in order.
    pub fn frames(&mut self) -> impl Iterator<Item = Result<Frame, RecordingError>> {
        (0..self.len()).map(|i| self.frame(i))
    }

    /// Indexes the records from byte `first` on.
    fn scan(&mut self, first: u64, end: u64) -> Result<Ending, RecordingError> {
        let mut offset = first;
        loop {
            let left = end - offset;
            let Some(length) = self.next_payload(left)? else {
                return Ok(Ending::Interrupted { leftover: left });
            };
            let Some(length) = length else {
                return Ok(Ending::Damaged { offset });
            };
            match self.payload.first() {
                Some(&layout::FRAME) => self.index.push((offset, length)),
                Some(&layout::END) => return Ok(self.finished(offset)),
                _ => return Ok(Ending::Damaged { offset }),
            }
            offset += RECORD_PREFIX as u64 + u64::from(length);
        }
    }

    /// Reads the next record's payload: `None` when it is incomplete, `Some(None)` when it fails its
    /// checksum.
    fn next_payload(&mut self, left: u64) -> Result<Option<Option<u32>>, RecordingError> {
        let Some(left) = left.checked_sub(RECORD_PREFIX as u64) else {
            return Ok(None);
        };
        let io = |source| RecordingError::Io { file: self.file.clone(), source };
        let mut prefix = [0; RECORD_PREFIX];
        self.input.read_exact(&mut prefix).map_err(io)?;
        let [l0, l1, l2, l3, c0, c1, c2, c3] = prefix;
        let length = u32::from_le_bytes([l0, l1, l2, l3]);
        if u64::from(length) > left {
            return Ok(None);
        }
        self.payload.resize(length as usize, 0);
        self.input.read_exact(&mut self.payload).map_err(io)?;
        let intact = crc32fast::hash(&self.payload) == u32::from_le_bytes([c0, c1, c2, c3]);
        Ok(Some(intact.then_some(length)))
    }

    /// The ending that the current payload declares.
    fn finished(&self, offset: u64) -> Ending {
        let damaged = Ending::Damaged { offset };
        let Some((count, reason)) = self.payload[1..].split_first_chunk() else {
            return damaged;
        };
        match std::str::from_utf8(reason) {
            Ok(reason) if u64::from_le_bytes(*count) == self.index.len() as u64 => {
                Ending::Finished { reason: reason.to_owned() }
            }
            _ => damaged,
        }
    }
}

/// The header and the position after it.
fn read_header(file: &Path, input: &mut impl Read, end: u64) -> Result<(Header, u64), RecordingError> {
    let io = |source| RecordingError::Io { file: file.to_path_buf(), source };
    let damaged = |problem| RecordingError::DamagedHeader { file: file.to_path_buf(), problem };
    let mut prefix = [0; 20];
    match input.read_exact(&mut prefix) {
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => {
            return Err(RecordingError::NotARecording { file: file.to_path_buf() });
        }
        other => other.map_err(io)?,
    }
    if prefix[..8] != MAGIC {
        return Err(RecordingError::NotARecording { file: file.to_path_buf() });
    }
    let number = |at: usize| u32::from_le_bytes([prefix[at], prefix[at + 1], prefix[at + 2], prefix[at + 3]]);
    let (found, length, crc) = (number(8), number(12), number(16));
    if found > SCHEMA_VERSION {
        let (file, known) = (file.to_path_buf(), SCHEMA_VERSION);
        return Err(RecordingError::NewerSchema { file, found, known });
    }
    let first = prefix.len() as u64 + u64::from(length);
    if first > end {
        return Err(damaged("the file ends within it".into()));
    }
    let mut json = vec![0; length as usize];
    input.read_exact(&mut json).map_err(io)?;
    if crc32fast::hash(&json) != crc {
        return Err(damaged("its checksum does not fit".into()));
    }
    let header: Header = serde_json::from_slice(&json).map_err(|error| damaged(error.to_string()))?;
    header.validate()?;
    Ok((header, first))
}
