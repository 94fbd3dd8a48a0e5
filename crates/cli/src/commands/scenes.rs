//! `signorini scenes`.

use clap::Args;
use serde_json::json;
use signorini_scenes::{SCENES, Scene};

use crate::error::CliError;
use crate::exit::Exit;
use crate::{output, text};

const EXAMPLE: &str = "\
Example:
  signorini scenes
  signorini simulate --scene house_of_cards";

/// Arguments of `scenes`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// Print one JSON object with all scenes.
    #[arg(long)]
    pub json: bool,
}

/// Lists the bundled scenes with what to see in each.
pub fn run(arguments: &Arguments) -> Result<Exit, CliError> {
    if arguments.json {
        let entry = |scene: &Scene| json!({ "name": scene.name, "description": scene.description() });
        output::print_json(&json!({ "scenes": SCENES.iter().map(entry).collect::<Vec<_>>() }));
    } else {
        output::print(&text::scenes(&SCENES));
    }
    Ok(Exit::Success)
}
