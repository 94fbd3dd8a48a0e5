//! One HTML file that shows a recording in any browser, without server or network.
//!
//! The page is built from the folder `viewer/` of the project; this module puts the data in. A long
//! run is thinned: the page holds every k-th frame, k a power of two, while residuals, iterations
//! and contact counts are the largest of the frames that each kept one stands for, so that a bad
//! step shows however short it was. The summary covers every frame. Meshes are simplified and take a third of the page at most,
//! so that there is room for frames.
//!
//! The same page shows a run that goes on, frame by frame as it is made: see [`LiveFeed`].

mod builder;
mod coding;
mod live;
mod meshes;
mod page;
mod payload;
mod run;
mod settings;

use std::io::Write;
use std::path::Path;

pub use builder::ReportBuilder;
pub use live::LiveFeed;
pub use settings::ReportSettings;

use crate::error::RecordingError;
use crate::recording::Recording;

/// Writes the report of a recording to a file, whole or not at all.
///
/// A run too long to hold in memory goes frame by frame through a [`ReportBuilder`] instead.
///
/// # Errors
/// [`RecordingError::Io`].
pub fn write_html(
    recording: &Recording,
    path: impl AsRef<Path>,
    settings: &ReportSettings,
) -> Result<(), RecordingError> {
    filled(recording, settings)?.write_file(path, recording.ending())
}

/// Writes the report of a recording to any output.
///
/// # Errors
/// [`RecordingError::Io`].
pub fn write_html_to(
    recording: &Recording,
    output: &mut impl Write,
    settings: &ReportSettings,
) -> Result<(), RecordingError> {
    filled(recording, settings)?.write(output, recording.ending())
}

/// The report with all frames of a recording.
fn filled(recording: &Recording, settings: &ReportSettings) -> Result<ReportBuilder, RecordingError> {
    let mut builder = ReportBuilder::new(recording.header().clone(), settings.clone())?;
    recording.frames().iter().try_for_each(|frame| builder.push(frame))?;
    Ok(builder)
}

/// The report of a recording as one element for a page that somebody else makes, such as a notebook's: an `<iframe>` with
/// the whole report in its `srcdoc`. The report's script runs in it, apart from the page around it.
///
/// - `height`: of the element, CSS pixels
///
/// # Errors
/// As [`write_html_to`].
pub fn inline_html(recording: &Recording, settings: &ReportSettings, height: u32) -> Result<String, RecordingError> {
    let mut page = Vec::new();
    write_html_to(recording, &mut page, settings)?;
    let page = String::from_utf8_lossy(&page).replace('&', "&amp;").replace('"', "&quot;");
    Ok(format!(
        "<iframe srcdoc=\"{page}\" sandbox=\"allow-scripts\" style=\"width: 100%; height: {height}px; border: 0\"></iframe>"
    ))
}
