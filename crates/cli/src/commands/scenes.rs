//! `signorini scenes`.

use clap::Args;
use serde_json::json;

use crate::error::CliError;
use crate::exit::Exit;
use crate::{output, scene, text};

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
    let scenes: Vec<_> = scene::all().collect();
    if arguments.json {
        let entry = |scene: &scene::Scene| json!({ "name": scene.name, "description": scene.description() });
        output::print_json(&json!({ "scenes": scenes.iter().map(entry).collect::<Vec<_>>() }));
    } else {
        output::print(&text::scenes(&scenes));
    }
    Ok(Exit::Success)
}
