//! `signorini check`: from the data of problem and solution to the residuals, without any solver.

use std::path::{Path, PathBuf};

use clap::Args;
use signorini::contact::problem_file::{
    self, ProblemFile, is_cone_solution, read_cone_solution, read_contact_solution, read_plain_solution,
};
use signorini::contact::{ProblemError, certify, certify_cone};

use crate::args::{directions, fraction};
use crate::error::CliError;
use crate::exit::Exit;
use crate::results::{CheckResult, Laws};
use crate::solving::{ContactLaw, kind_of, polygonal, with_directions};
use crate::{output, text};

const EXAMPLE: &str = "\
Examples:
  signorini check problem.npz solution.npz
  signorini check problem.npz solution.npz --tol 1e-10 --json

The solution file holds z, and for contact problems v, lambda_n, alpha, beta where it has them; v is computed from the
impulses where it is missing. A solution with the circular cone (`solve --method circular` or `refined`) says so in its
field `law` and is checked against the circular cone's laws. Give --directions where the solution was made with them. Exit code 1: a law is violated.";

/// Arguments of `check`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// Problem file.
    #[arg(value_name = "PROBLEM.npz")]
    pub problem: PathBuf,
    /// Solution file.
    #[arg(value_name = "SOLUTION.npz")]
    pub solution: PathBuf,
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

/// Checks a solution and says which laws hold.
pub fn run(arguments: &Arguments) -> Result<Exit, CliError> {
    let problem = problem_file::read(&arguments.problem).map_err(CliError::in_file(&arguments.problem))?;
    let kind = kind_of(&problem);
    let solution = &arguments.solution;
    let circular = is_cone_solution(solution).map_err(CliError::in_file(solution))?;
    let (law, laws) =
        if circular { circular_laws(problem, kind, arguments)? } else { polygon_laws(problem, arguments)? };
    let files = [arguments.problem.clone(), solution.clone()];
    let result = CheckResult::new(files, kind, law, arguments.tol, laws);
    output::print_result(&result, arguments.json, text::check);
    Ok(if result.ok { Exit::Success } else { Exit::Failure })
}

/// The laws of the circular cone.
fn circular_laws(
    problem: ProblemFile,
    kind: &'static str,
    arguments: &Arguments,
) -> Result<(Option<ContactLaw>, Laws), CliError> {
    let path = arguments.solution.as_path();
    let read = |nv, nc, nb| read_cone_solution(path, nv, nc, nb).map_err(CliError::in_file(path));
    let laws = match problem {
        ProblemFile::Contact(problem) => {
            let unsupported = problem.check_circular().map_err(ProblemError::from);
            unsupported.map_err(CliError::in_file(&arguments.problem))?;
            let nb = problem.bilateral_violation.len();
            let claimed = read(problem.nv(), problem.contact_count(), nb)?;
            Laws::of_cone(&certify_cone(&problem, &claimed), nb > 0)
        }
        ProblemFile::Frictional(problem) => {
            let claimed = read(0, problem.friction.len(), 0)?;
            Laws::of_frictional_cone(&problem.certify_cone(&claimed.impulse))
        }
        _ => return Err(CliError::LawWithoutContacts { path: path.to_owned(), kind }),
    };
    Ok((Some(ContactLaw::Circular), laws))
}

/// The laws of the complementarity problem.
fn polygon_laws(problem: ProblemFile, arguments: &Arguments) -> Result<(Option<ContactLaw>, Laws), CliError> {
    let (path, solution) = (arguments.problem.as_path(), arguments.solution.as_path());
    match problem {
        ProblemFile::Lcp(problem) => {
            let z = read_z(solution, problem.len())?;
            Ok((None, Laws::natural_map(problem.residual(&z).value)))
        }
        ProblemFile::MixedLcp(problem) => {
            let z = read_z(solution, problem.len())?;
            Ok((None, Laws::natural_map(problem.residual(&z).value)))
        }
        ProblemFile::Frictional(problem) => {
            let lcp = polygonal(&problem, arguments.directions).map_err(CliError::in_file(path))?;
            let z = read_z(solution, lcp.len())?;
            Ok((Some(ContactLaw::Polygon), Laws::of_friction(&problem.certify(&lcp, &z))))
        }
        ProblemFile::Contact(problem) => {
            let problem = with_directions(problem, arguments.directions).map_err(CliError::in_file(path))?;
            let claimed = read_contact_solution(solution, &problem).map_err(CliError::in_file(solution))?;
            let laws = Laws::of_contacts(&certify(&problem, &claimed), !problem.bilateral_violation.is_empty());
            Ok((Some(ContactLaw::Polygon), laws))
        }
        _ => Err(CliError::UnsupportedKind { path: path.to_owned() }),
    }
}

fn read_z(solution: &Path, size: usize) -> Result<Vec<f64>, CliError> {
    read_plain_solution(solution, size).map_err(CliError::in_file(solution))
}
