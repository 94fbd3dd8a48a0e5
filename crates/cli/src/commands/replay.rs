//! `signorini replay`.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use signorini::recording::report::{ReportBuilder, ReportSettings};
use signorini::recording::{Frame, Reader};
use signorini::viewer::PageServer;

use crate::error::CliError;
use crate::exit::Exit;
use crate::output;
use crate::results::{FileName, ending};

const HELP: &str = "\
Without --report the page is served on this machine only, at the address that is printed; Ctrl-C ends it. The page is that of
`simulate --report`: it plays the run, shows contacts, forces and plots, and steps through the frames.

Examples:
  signorini replay run.rec
  signorini replay run.rec --report run.html";

/// Browsers show pages up to this many bytes without trouble.
const LARGEST_PAGE: usize = 100_000_000;

/// Arguments of `replay`.
#[derive(Debug, Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    /// The recording; one that was cut off is shown as far as it goes.
    #[arg(value_name = "RUN.rec")]
    pub recording: PathBuf,
    /// Write the page as a file in place of serving it.
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
    /// Frames in the page, at most; of a longer run every k-th is shown.
    #[arg(long, value_name = "N", default_value_t = 5000, value_parser = clap::value_parser!(u32).range(2..))]
    pub max_frames: u32,
    /// Port on 127.0.0.1; 0 takes a free one.
    #[arg(long, value_name = "N", default_value_t = 0, conflicts_with = "report")]
    pub port: u16,
    /// Print the address without opening the browser.
    #[arg(long, conflicts_with = "report")]
    pub no_open: bool,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// What is shown, and where.
#[derive(Serialize)]
struct Shown {
    recording: FileName,
    model: String,
    frames: usize,
    ending: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    report: Option<FileName>,
    #[serde(skip_serializing_if = "Option::is_none")]
    address: Option<String>,
}

impl Shown {
    fn text(&self) -> String {
        let Self { model, frames, ending, .. } = self;
        let place = match (&self.report, &self.address) {
            (Some(path), _) => path.display().to_string(),
            (None, address) => format!("{}\nCtrl-C ends it.", address.as_deref().unwrap_or_default()),
        };
        format!("{model} ({frames} frames, {ending}): {place}\n")
    }
}

/// Shows a recording.
pub fn run(arguments: &Arguments) -> Result<Exit, CliError> {
    output::keep_apart(&[&arguments.recording], &[("--report", arguments.report.as_deref())])?;
    let mut reader = Reader::open(&arguments.recording)?;
    let mut shown = Shown {
        recording: (&arguments.recording).into(),
        model: reader.header().model_name.clone(),
        frames: reader.len(),
        ending: ending(reader.ending()),
        report: arguments.report.as_ref().map(Into::into),
        address: None,
    };
    if let Some(path) = &arguments.report {
        page(&mut reader, arguments)?.write_file(path, reader.ending())?;
        output::print_result(&shown, arguments.json, Shown::text);
        return Ok(Exit::Success);
    }
    let mut bytes = Vec::new();
    page(&mut reader, arguments)?.write(&mut bytes, reader.ending())?;
    let server = PageServer::launch(bytes, arguments.port)?;
    shown.address = Some(server.address().to_owned());
    output::print_result(&shown, arguments.json, Shown::text);
    if !arguments.no_open
        && let Err(error) = server.open_browser()
    {
        eprintln!("note: the browser could not be opened ({error}); open the address by hand");
    }
    server.wait();
    Ok(Exit::Success)
}

/// The page with all frames of a recording.
fn page(
    reader: &mut Reader<impl std::io::Read + std::io::Seek>,
    arguments: &Arguments,
) -> Result<ReportBuilder, CliError> {
    let notes = vec![("recording".to_owned(), name(&arguments.recording))];
    let settings = ReportSettings::default()
        .with_notes(notes)
        .with_max_frames(arguments.max_frames as usize)
        .with_max_bytes(LARGEST_PAGE);
    let mut builder = ReportBuilder::new(reader.header().clone(), settings)?;
    let mut frame = Frame::default();
    for i in 0..reader.len() {
        reader.frame_into(i, &mut frame)?;
        builder.push(&frame)?;
    }
    Ok(builder)
}

fn name(path: &Path) -> String {
    path.display().to_string()
}
