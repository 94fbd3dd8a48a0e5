//! `signorini check RUN.rec`: every step of a recording.

use std::path::Path;

use signorini::formats::{LoadOptions, load};
use signorini::multibody::Model;
use signorini::recording::Reader;
use signorini_replay::{check, rebuild};

use crate::error::CliError;
use crate::exit::Exit;
use crate::results::RecordingResult;
use crate::{output, text};

/// Checks every step and says which do not hold. The model is that of a file, or the recording's own.
pub fn run(path: &Path, model: Option<&Path>, tolerance: f64, json: bool) -> Result<Exit, CliError> {
    let mut reader = Reader::open(path)?;
    let model: Model = match model {
        Some(file) => load(file, &LoadOptions::default())?.model,
        None => rebuild(reader.header())?,
    };
    let found = check(&mut reader, model, tolerance)?;
    if found.certified + found.violated == 0 {
        return Err(CliError::NoSteps { path: path.to_owned() });
    }
    let result = RecordingResult::new(path, &reader, tolerance, &found);
    output::print_result(&result, json, text::recording);
    Ok(if result.ok { Exit::Success } else { Exit::Failure })
}
