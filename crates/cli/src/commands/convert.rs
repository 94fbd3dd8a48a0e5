//! `signorini convert`.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;
use signorini::recording::Reader;
use signorini_replay::export::export;

use crate::error::CliError;
use crate::exit::Exit;
use crate::output;
use crate::results::FileName;

const HELP: &str = "\
The ending of the file's name says which format: .npz (NumPy arrays over all frames), .csv (one row per frame, names with
units), .mcap (poses, shapes, forces, contacts and certificates for Foxglove). Recordings of Rerun (.rrd) are written by the
Python package: pip install 'signorini[rerun]', then signorini.load_recording('run.rec').to_rerun('run.rrd').

Examples:
  signorini convert run.rec --out run.npz
  signorini convert run.rec --out run.mcap";

/// Arguments of `convert`.
#[derive(Debug, Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    /// The recording.
    #[arg(value_name = "RUN.rec")]
    pub recording: PathBuf,
    /// File to write: .npz, .csv or .mcap.
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// The result of `convert`.
#[derive(Debug, Serialize)]
struct Converted {
    recording: FileName,
    out: FileName,
    model: String,
    frames: usize,
}

/// Writes a recording in another format.
pub fn run(arguments: &Arguments) -> Result<Exit, CliError> {
    output::keep_apart(&[&arguments.recording], &[("--out", Some(&arguments.out))])?;
    let mut reader = Reader::open(&arguments.recording)?;
    export(&mut reader, &arguments.out)?;
    let (recording, out) = ((&arguments.recording).into(), (&arguments.out).into());
    let result = Converted { recording, out, model: reader.header().model_name.clone(), frames: reader.len() };
    output::print_result(&result, arguments.json, |result| {
        format!("{}: {} frames of {}\n", result.out.display(), result.frames, result.model)
    });
    Ok(Exit::Success)
}
