//! `signorini view`.

use clap::Args;
use serde::Serialize;
use signorini::viewer::{Viewer, ViewerSettings};

use crate::args::{ModelArguments, StartArguments, StepArguments, positive};
use crate::error::CliError;
use crate::exit::Exit;
use crate::loading::{load_model, start};
use crate::output;

const HELP: &str = "\
The page listens on this machine only, and whoever opens it needs the address that is printed. While no page is open the
simulation waits. Ctrl-C ends it.

In the page: space runs and pauses, → makes one step, R goes back to the start; pull a body with the mouse, or turn the
view beside it (or with Shift held). The ? there lists all keys.

Examples:
  signorini view
  signorini view robot.xml --keyframe home --paused
  signorini view --scene stack_of_ten --port 8080 --no-open";

/// Arguments of `view`.
#[derive(Debug, Args)]
#[command(after_help = HELP)]
pub struct Arguments {
    /// The model.
    #[command(flatten)]
    pub model: ModelArguments,
    /// The state to start from, and to reset to.
    #[command(flatten)]
    pub start: StartArguments,
    /// How steps are made.
    #[command(flatten)]
    pub step: StepArguments,
    /// Port on 127.0.0.1; 0 takes a free one.
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub port: u16,
    /// Simulated seconds per second, as far as the machine can.
    #[arg(long, value_name = "X", default_value = "1", value_parser = positive)]
    pub speed: f64,
    /// Wait for the user to start the simulation.
    #[arg(long)]
    pub paused: bool,
    /// Print the address without opening the browser.
    #[arg(long)]
    pub no_open: bool,
    /// Print one JSON object with the address.
    #[arg(long)]
    pub json: bool,
}

/// Where the page is.
#[derive(Serialize)]
struct Shown {
    model: String,
    source: String,
    address: String,
}

/// Shows a model until the command is ended from outside.
pub fn run(arguments: &Arguments) -> Result<Exit, CliError> {
    let loaded = load_model(&arguments.model)?;
    let simulation = start(&loaded, &arguments.start, arguments.step.settings()?)?;
    let settings = ViewerSettings::default()
        .with_port(arguments.port)
        .with_title(String::new())
        .with_notes(loaded.notes())
        .with_running(!arguments.paused)
        .with_speed(arguments.speed);
    let viewer = Viewer::launch(simulation, &settings)?;
    let address = viewer.address().to_owned();
    let shown = Shown { model: loaded.model.name.clone(), source: loaded.source, address };
    output::print_result(&shown, arguments.json, |shown| {
        format!("{} ({}): {}\nCtrl-C ends it.\n", shown.model, shown.source, shown.address)
    });
    if !arguments.no_open
        && let Err(error) = viewer.open_browser()
    {
        eprintln!("note: the browser could not be opened ({error}); open the address by hand");
    }
    viewer.wait();
    Ok(Exit::Success)
}
