//! `signorini export`.

use std::path::PathBuf;

use clap::Args;
use signorini::RunEnd;
use signorini::contact::problem_file::write_contact;

use crate::args::{ModelArguments, StartArguments, StepArguments, finite};
use crate::error::CliError;
use crate::exit::Exit;
use crate::loading::{load_model, start};
use crate::results::{Contradiction, Exported, import_warnings, solve_status};
use crate::{clock, output, text};

const EXAMPLE: &str = "\
Example:
  signorini export stack.xml --time 0.5 --out stack.npz
  signorini solve stack.npz --out solution.npz
  signorini check stack.npz solution.npz";

/// Arguments of `export`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// The model.
    #[command(flatten)]
    pub model: ModelArguments,
    /// Time in seconds at which the step begins; the nearest step's is taken.
    #[arg(long, value_name = "T", value_parser = finite)]
    pub time: f64,
    /// File to write (.npz, kind = "contact").
    #[arg(long, value_name = "FILE.npz")]
    pub out: PathBuf,
    /// The state to start from.
    #[command(flatten)]
    pub start: StartArguments,
    /// How steps are made.
    #[command(flatten)]
    pub step: StepArguments,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// Simulates up to a time and writes the contact problem of the step that begins there.
pub fn run(arguments: &Arguments) -> Result<Exit, CliError> {
    output::keep_apart(&arguments.model.files(), &[("--out", Some(&arguments.out))])?;
    let loaded = load_model(&arguments.model)?;
    let mut simulation = start(&loaded, &arguments.start, arguments.step.settings()?)?;
    let (begin, dt) = (simulation.state().time, simulation.timestep());
    let steps = clock::steps("--time", arguments.time - begin, dt)?;
    if steps < 0.0 {
        return Err(CliError::TimeBeforeStart { time: arguments.time, start: begin });
    }
    let progress = output::progress(steps as u64, "steps");
    let end = simulation.run(steps * dt, |_, _| {
        progress.inc(1);
        true
    });
    progress.finish_and_clear();
    let time = simulation.state().time;
    let breakdown = |source| CliError::Step { time, source };
    let stopped = match end.map_err(breakdown)? {
        RunEnd::NoSolution(report) => Some(report),
        _ => None,
    };
    let missed_steps = simulation.summary().missed_steps;
    let report = match &stopped {
        Some(report) => report.as_ref().clone(),
        None => simulation.step().map_err(breakdown)?.clone(),
    };
    let problem = simulation.workspace().problem();
    if stopped.is_none() {
        write_contact(&arguments.out, problem).map_err(CliError::in_file(&arguments.out))?;
    }
    let steps = simulation.summary().steps;
    let contradiction = stopped.map(|report| Contradiction::of(&simulation, &report, steps));
    let result = Exported {
        out: contradiction.is_none().then(|| (&arguments.out).into()),
        source: loaded.source.clone(),
        time,
        timestep: dt,
        nv: problem.nv(),
        contacts: problem.contact_count(),
        directions: problem.direction_count(),
        status: solve_status(problem, &report.status),
        clipped_gaps: report.clipped_gaps,
        theta: report.theta,
        missed_steps,
        contradiction,
        warnings: import_warnings(&loaded.report),
    };
    output::print_result(&result, arguments.json, text::export);
    Ok(match (&result.contradiction, result.missed_steps) {
        (Some(_), _) => Exit::Contradiction,
        (None, 0) => Exit::Success,
        (None, _) => Exit::NotSolved,
    })
}
