//! `signorini check`: from the data of problem and solution, or of a recording, to the residuals, without any solver.

mod recording;

use std::path::{Path, PathBuf};

use clap::Args;
use signorini::recording::is_recording;
use signorini_check::check;

use crate::args::{directions, fraction};
use crate::error::CliError;
use crate::exit::Exit;
use crate::results::CheckResult;
use crate::{output, text};

const EXAMPLE: &str = "\
Examples:
  signorini check problem.npz solution.npz
  signorini check problem.npz solution.npz --tol 1e-10 --json
  signorini check run.rec

The solution file holds z, and for contact problems v, lambda_n, alpha, beta where it has them; v is computed from the
impulses where it is missing. A solution with the circular cone (`solve --method circular` or `refined`) says so in its
field `law` and is checked against the circular cone's laws. Give --directions where the solution was made with them.

A proof that there is no solution, which `solve --out` writes for what is infeasible or has no_solution, is checked the same way: every
multiplier, and that no case is missing.

A verdict of `signorini stability --out` is checked against the problem that `--problem` wrote: every part of its proof.

Of a recording every step is checked: at the recorded state the contact problem is built anew from the model, and the recorded
velocity and impulses are judged as its solution; everything else in the step must follow from them. The model is made from the
text in the recording; meshes are read from where they were.

Exit code 1: a law is violated; of a recording, the steps are named.";

/// Arguments of `check`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// Problem file, or a recording.
    #[arg(value_name = "PROBLEM.npz|RUN.rec")]
    pub problem: PathBuf,
    /// Solution file; none for a recording.
    #[arg(value_name = "SOLUTION.npz")]
    pub solution: Option<PathBuf>,
    /// Model file of the recording, in place of the text that it holds.
    #[arg(long, value_name = "FILE")]
    pub model: Option<PathBuf>,
    /// A law holds when its residual is at most this.
    #[arg(long, value_name = "X", default_value = "1e-8", value_parser = fraction)]
    pub tol: f64,
    /// Friction directions of every contact, as given to `solve`. [default: the file's own for contact, 8 for frictional3d]
    #[arg(long, value_name = "M", value_parser = directions)]
    pub directions: Option<usize>,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

/// Checks a solution or a recording and says which laws hold.
pub fn run(arguments: &Arguments) -> Result<Exit, CliError> {
    let wrong = |problem| Err(CliError::CheckArguments { path: arguments.problem.clone(), problem });
    match (is_recording(&arguments.problem)?, &arguments.solution) {
        (true, None) if arguments.directions.is_none() => {
            recording::run(&arguments.problem, arguments.model.as_deref(), arguments.tol, arguments.json)
        }
        (true, None) => wrong("a recording has its own directions; leave --directions out"),
        (true, Some(_)) => wrong("a recording holds its solutions; give it alone"),
        (false, None) => wrong("this is no recording; a problem is checked with its solution: give both files"),
        (false, Some(_)) if arguments.model.is_some() => wrong("--model has a meaning with a recording only"),
        (false, Some(solution)) => check_solution(solution, arguments),
    }
}

fn check_solution(solution: &Path, arguments: &Arguments) -> Result<Exit, CliError> {
    let checked = check(&arguments.problem, solution, arguments.directions)?;
    let files = [arguments.problem.as_path().into(), solution.into()];
    let result = CheckResult::new(files, arguments.tol, checked);
    output::print_result(&result, arguments.json, text::check);
    Ok(if result.ok { Exit::Success } else { Exit::Failure })
}
