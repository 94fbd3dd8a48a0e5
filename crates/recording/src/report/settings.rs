//! Settings of a report.

use derive_setters::Setters;

/// What the report shows and how large it may get.
#[derive(Debug, Clone, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct ReportSettings {
    /// Title of the page; the model's name when empty.
    #[setters(into)]
    pub title: String,
    /// Frames in the page, at most. Default 2000, at least 2.
    pub max_frames: usize,
    /// Size of the file in bytes, at most, as far as leaving out frames can achieve it.
    /// Default 8 million.
    pub max_bytes: usize,
    /// Further lines of the summary: a label and its text, for example what the import left out.
    pub notes: Vec<(String, String)>,
}

impl Default for ReportSettings {
    fn default() -> Self {
        Self { title: String::new(), max_frames: 2000, max_bytes: 8_000_000, notes: Vec::new() }
    }
}
