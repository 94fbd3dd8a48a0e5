//! `signorini inspect`.

use clap::Args;

use crate::args::ModelArguments;
use crate::error::CliError;
use crate::exit::Exit;
use crate::loading::load_model;
use crate::results::Inspection;
use crate::{output, text};

const EXAMPLE: &str = "\
Example:
  signorini inspect robot.xml
  signorini inspect robot.urdf --floating-base --json";

/// Arguments of `inspect`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// The model.
    #[command(flatten)]
    pub model: ModelArguments,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// Shows what a model file became.
pub fn run(arguments: &Arguments) -> Result<Exit, CliError> {
    let loaded = load_model(&arguments.model)?;
    output::print_result(&Inspection::of(&loaded), arguments.json, text::inspection);
    Ok(Exit::Success)
}
