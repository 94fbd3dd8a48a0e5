//! Fields of payloads: numbers to bytes and back.

use crate::error::RecordingError;

/// A field whose length or value does not fit the header.
pub(crate) struct Mismatch {
    pub field: &'static str,
    pub expected: usize,
    pub found: usize,
}

impl Mismatch {
    pub(crate) fn in_frame(self, frame: usize) -> RecordingError {
        let Self { field, expected, found } = self;
        RecordingError::FrameMismatch { frame, field, expected, found }
    }
}

/// Appends numbers. Allocates only to grow `bytes`.
pub(crate) fn put(bytes: &mut Vec<u8>, values: &[f64]) {
    for value in values {
        bytes.extend(value.to_le_bytes());
    }
}

/// As many entries as there should be, in memory that is re-used; `None` where one is missing.
pub(crate) fn refill<T>(values: &mut Vec<T>, count: usize, mut next: impl FnMut() -> Option<T>) -> Option<()> {
    values.clear();
    values.reserve(count);
    for _ in 0..count {
        values.push(next()?);
    }
    Some(())
}

/// What is left of a payload.
pub(crate) struct Fields<'a>(pub(crate) &'a [u8]);

impl Fields<'_> {
    /// Whether as many entries of this size are left, so that a wrong count reserves no memory.
    pub(crate) fn has(&self, count: u32, size: usize) -> Option<()> {
        (count as usize).checked_mul(size).filter(|bytes| *bytes <= self.0.len()).map(drop)
    }

    pub(crate) fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (field, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*field)
    }

    pub(crate) fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    pub(crate) fn f64(&mut self) -> Option<f64> {
        self.array().map(f64::from_le_bytes)
    }

    pub(crate) fn floats<const N: usize>(&mut self) -> Option<[f64; N]> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.f64()?;
        }
        Some(values)
    }
}
