//! The page: one HTML file with places for title, description, meshes and data.

use std::io::Write;

use serde::Serialize;

use super::meshes::PageMeshes;
use super::payload::ArrayPlace;
use super::run::Run;
use crate::error::RecordingError;
use crate::header::Header;

const PAGE: &str = include_str!("../../assets/report.html");
const TITLE: &str = "@@TITLE@@";
const ABOUT: &str = "@@ABOUT@@";
const MESHES: &str = "@@MESHES@@";
const DATA: &str = "@@DATA@@";

/// The page's description of its data.
#[derive(Serialize)]
pub(super) struct About<'a> {
    /// Without the triangles of its meshes.
    pub header: &'a Header,
    pub meshes: &'a PageMeshes,
    pub run: &'a Run,
    /// `null` when the run did not end by itself.
    pub ending: Option<&'a str>,
    pub stride: usize,
    pub notes: &'a [(String, String)],
    pub arrays: &'a [ArrayPlace],
    /// Whether the frames come over a websocket.
    pub live: bool,
}

/// Length of a page without frames, bytes.
pub(super) fn empty_length(header: &Header, meshes: &PageMeshes) -> Result<usize, RecordingError> {
    Ok(PAGE.len() + to_json(header)?.len() + to_json(meshes)?.len() + meshes.text.len())
}

/// Writes the page; an empty title is the model's name.
pub(super) fn write(
    title: &str,
    about: &About<'_>,
    data: String,
    output: &mut impl Write,
) -> Result<(), RecordingError> {
    let title = if title.is_empty() { &about.header.model_name } else { title };
    let (title, description) = (escape_html(title), to_json(about)?);
    let values = [(TITLE, &title), (ABOUT, &description), (MESHES, &about.meshes.text), (DATA, &data)];
    fill(PAGE, &values, output).map_err(|source| RecordingError::Io { file: "(report)".into(), source })
}

/// JSON that may stand inside a `<script>` element.
fn to_json(value: &impl Serialize) -> Result<String, RecordingError> {
    let json = serde_json::to_string(value)
        .map_err(|_| RecordingError::InvalidHeader { field: "header".into(), problem: "cannot be written as JSON" })?;
    Ok(json.replace('<', "\\u003c"))
}

fn escape_html(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// Writes `page` with each marker (in the order in which the page has them) replaced by its value.
fn fill(page: &str, values: &[(&str, &String)], output: &mut impl Write) -> std::io::Result<()> {
    let mut rest = page;
    for (marker, value) in values {
        let (before, after) = rest.split_once(marker).expect("the page has every marker once, in order");
        output.write_all(before.as_bytes())?;
        output.write_all(value.as_bytes())?;
        rest = after;
    }
    output.write_all(rest.as_bytes())
}
