//! What the derivatives of steps are worth: how often they exist, whether one that is called exact was ever wrong, and how near to differences
//! they are inside modes. Fails where one was wrong.

mod accuracy;
mod bench;
mod flags;
mod models;

use std::error::Error;
use std::path::PathBuf;

use clap::Parser;

/// Compares derivatives of steps that are called exact with differences of the steps.
#[derive(Parser)]
struct Options {
    /// Steps of each bundled scene
    #[arg(long, default_value_t = 400)]
    steps: u32,
    /// Random scenes of each kind, of 200 steps each and 50 beside them
    #[arg(long, default_value_t = 100)]
    scenes: u64,
    /// The first random scene
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// A few steps of everything
    #[arg(long)]
    smoke: bool,
    /// Say why derivatives are refused or one-sided
    #[arg(long)]
    why: bool,
    /// Refuse steps whose problem has another solution without their start
    #[arg(long)]
    twice: bool,
    /// Compare the derivatives of so many random states of each robot and mechanism with extrapolated differences instead, by parameters, too
    #[arg(long)]
    accuracy: Option<usize>,
    /// A folder with `a1_description` and `panda_description`, as `benchmarks/robots/fetch.py` makes it
    #[arg(long)]
    robots: Option<PathBuf>,
    /// Only the robot or mechanism of this name
    #[arg(long)]
    only: Option<String>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut options = Options::parse();
    if let Some(states) = options.accuracy {
        return match accuracy::compare(&options, states)? {
            0 => Ok(()),
            wrong => Err(format!("{wrong} derivatives are not those of differences").into()),
        };
    }
    let mut wrong = 0;
    if options.smoke {
        (options.steps, options.scenes) = (12, 4);
        wrong += accuracy::compare(&options, 2)?;
    }
    wrong += flags::count(&options)?;
    match wrong {
        0 => Ok(()),
        _ => Err(format!("{wrong} derivatives were called exact and are not").into()),
    }
}
