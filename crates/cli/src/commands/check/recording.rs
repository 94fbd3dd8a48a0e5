//! `signorini check RUN.rec`: every step of a recording.

use signorini::multibody::Model;
use signorini::recording::Reader;
use signorini_formats::{LoadOptions, load};
use signorini_replay::{check, rebuild};

use super::Arguments;
use crate::error::CliError;
use crate::exit::Exit;
use crate::results::RecordingResult;
use crate::{output, text};

/// Checks every step and says which do not hold.
pub fn run(arguments: &Arguments) -> Result<Exit, CliError> {
    let path = &arguments.problem;
    let mut reader = Reader::open(path)?;
    let model: Model = match &arguments.model {
        Some(file) => load(file, &LoadOptions::default())?.model,
        None => rebuild(reader.header())?,
    };
    let found = check(&mut reader, model, arguments.tol)?;
    if found.certified + found.violated == 0 {
        return Err(CliError::NoSteps { path: path.clone() });
    }
    let result = RecordingResult::new(path, &reader, arguments.tol, &found);
    output::print_result(&result, arguments.json, text::recording);
    Ok(if result.ok { Exit::Success } else { Exit::Failure })
}
