//! `signorini solve`.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use signorini::contact::problem_file::{
    self, FrictionalProblem, ProblemFile, write_contact_solution, write_plain_solution,
};
use signorini::contact::{ContactProblem, ContactSolution, ContactSolver, ProblemError, solve_as_lcp};
use signorini::lcp::{Lcp, MethodKind, MixedLcp, Solution};

use crate::args::{MethodChoice, directions, fraction, structured};
use crate::error::CliError;
use crate::exit::Exit;
use crate::results::{Laws, SolveResult, lcp_status, solve_status};
use crate::{output, text};

const EXAMPLE: &str = "\
Examples:
  signorini solve problem.npz --out solution.npz
  signorini solve problems/*.npz --json
  signorini solve problem.npz --method lemke --directions 16

Kinds of problems: lcp, mlcp, contact, frictional3d, frictional2d (the field `kind` of the file). Every problem is solved
even if one before it is not, or its file cannot be read; the exit code is 1 if a file cannot be read, else 2 if a problem
is not solved.";

/// Friction directions of a frictional problem where none are asked for.
const DEFAULT_DIRECTIONS: usize = 8;

/// Arguments of `solve`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// Problem files.
    #[arg(required = true, value_name = "PROBLEM.npz")]
    pub problems: Vec<PathBuf>,
    /// Solver: structured (kind contact only), automatic, lemke, enumeration, principal-pivoting, psor,
    /// newton-fischer-burmeister, newton-minimum. [default: structured for contact, else automatic]
    #[arg(long, value_name = "NAME", value_parser = MethodChoice::parse)]
    pub method: Option<MethodChoice>,
    /// Friction directions of every contact, even and at least 4. [default: the file's own for contact, 8 for frictional3d]
    #[arg(long, value_name = "M", value_parser = directions)]
    pub directions: Option<usize>,
    /// A problem is solved when every residual is at most this.
    #[arg(long, value_name = "X", default_value = "1e-8", value_parser = fraction)]
    pub tol: f64,
    /// Write the solution (of a single problem), or the best point found.
    #[arg(long, value_name = "SOLUTION.npz")]
    pub out: Option<PathBuf>,
    /// Print one JSON object per problem, each on one line.
    #[arg(long)]
    pub json: bool,
}

/// Solves every problem and prints what came out.
pub fn run(arguments: &Arguments) -> Result<Exit, CliError> {
    if arguments.out.is_some() && arguments.problems.len() > 1 {
        return Err(CliError::OneSolution { problems: arguments.problems.len() });
    }
    let progress = output::progress(arguments.problems.len() as u64, "problems");
    let (mut unreadable, mut unsolved) = (0, 0);
    for path in &arguments.problems {
        let outcome = solve_file(path, arguments);
        progress.suspend(|| match outcome {
            Ok(result) => {
                unsolved += usize::from(result.status != "solved");
                output::print_result(&result, arguments.json, text::solve);
            }
            Err(error) => {
                unreadable += 1;
                output::problem_error(path, &error, arguments.json);
            }
        });
        progress.inc(1);
    }
    progress.finish_and_clear();
    Ok(match (unreadable, unsolved) {
        (0, 0) => Exit::Success,
        (0, _) => Exit::NotSolved,
        _ => Exit::Failure,
    })
}

/// What a solve gives, whatever the kind of the problem.
struct Answer {
    n: usize,
    contacts: Option<usize>,
    method: String,
    status: (&'static str, Vec<usize>),
    residual: Laws,
    iterations: u64,
    seconds: f64,
    point: Point,
}

enum Point {
    Contact(Box<ContactSolution>),
    Plain(Vec<f64>),
}

fn solve_file(path: &Path, arguments: &Arguments) -> Result<SolveResult, CliError> {
    let problem = problem_file::read(path).map_err(CliError::in_file(path))?;
    let kind = kind_of(&problem);
    let answer = solve_problem(problem, kind, path, arguments)?;
    if let Some(out) = &arguments.out {
        match &answer.point {
            Point::Contact(solution) => write_contact_solution(out, solution),
            Point::Plain(z) => write_plain_solution(out, z),
        }
        .map_err(CliError::in_file(out))?;
    }
    let (claimed, involved) = answer.status;
    let holds = answer.residual.worst().1 <= arguments.tol;
    let status = match claimed {
        _ if holds => "solved",
        "solved" => "inaccurate",
        other => other,
    };
    Ok(SolveResult {
        problem: path.to_owned(),
        kind,
        n: answer.n,
        contacts: answer.contacts,
        method: answer.method,
        status,
        tolerance: arguments.tol,
        residual: answer.residual,
        iterations: answer.iterations,
        seconds: answer.seconds,
        involved: if holds { Vec::new() } else { involved },
        solution: arguments.out.clone(),
    })
}

/// The name of a problem's kind, as in the field `kind` of its file.
pub fn kind_of(problem: &ProblemFile) -> &'static str {
    match problem {
        ProblemFile::Lcp(_) => "lcp",
        ProblemFile::MixedLcp(_) => "mlcp",
        ProblemFile::Contact(_) => "contact",
        ProblemFile::Frictional(problem) if problem.dimension == 2 => "frictional2d",
        ProblemFile::Frictional(_) => "frictional3d",
        _ => "unknown",
    }
}

/// The contact problem with the directions asked for.
pub fn with_directions(
    problem: Box<ContactProblem>,
    directions: Option<usize>,
) -> Result<Box<ContactProblem>, ProblemError> {
    match directions {
        Some(count) => Ok(Box::new(problem.with_directions(count)?)),
        None => Ok(problem),
    }
}

/// The polygonal LCP of a frictional problem.
pub fn polygonal(problem: &FrictionalProblem, directions: Option<usize>) -> Result<Lcp, ProblemError> {
    problem.polygonal_lcp(directions.unwrap_or(DEFAULT_DIRECTIONS))
}

fn solve_problem(
    problem: ProblemFile,
    kind: &'static str,
    path: &Path,
    arguments: &Arguments,
) -> Result<Answer, CliError> {
    let in_file = |error| CliError::in_file(path)(error);
    if let ProblemFile::Contact(problem) = problem {
        let problem = with_directions(problem, arguments.directions).map_err(in_file)?;
        return solve_contact(&problem, arguments).map_err(in_file);
    }
    let method = match &arguments.method {
        None => MethodKind::Automatic(Default::default(), Default::default()),
        Some(MethodChoice::Lcp(method)) => method.clone(),
        Some(MethodChoice::Structured) => return Err(CliError::NeedsContacts { path: path.to_owned(), kind }),
    };
    match problem {
        ProblemFile::Lcp(problem) => solve_lcp(&problem, &method).map_err(in_file),
        ProblemFile::MixedLcp(problem) => solve_mixed(&problem, &method).map_err(in_file),
        ProblemFile::Frictional(problem) => {
            let lcp = polygonal(&problem, arguments.directions).map_err(in_file)?;
            let mut answer = solve_lcp(&lcp, &method).map_err(in_file)?;
            if let Point::Plain(z) = &answer.point {
                answer.residual = Laws::of_friction(&problem.certify(&lcp, z));
            }
            answer.contacts = Some(problem.friction.len());
            Ok(answer)
        }
        _ => Err(CliError::UnsupportedKind { path: path.to_owned() }),
    }
}

fn solve_contact(problem: &ContactProblem, arguments: &Arguments) -> Result<Answer, ProblemError> {
    let begin = Instant::now();
    let (method, solution) = match &arguments.method {
        Some(MethodChoice::Lcp(kind)) => {
            (kind.to_string(), solve_as_lcp(problem, kind.build()?.as_mut(), arguments.tol)?)
        }
        _ => ("structured".to_owned(), ContactSolver::new(structured(arguments.tol))?.solve(problem, None)),
    };
    let seconds = begin.elapsed().as_secs_f64();
    Ok(Answer {
        n: problem.standard_layout().size,
        contacts: Some(problem.contact_count()),
        method,
        status: solve_status(&solution.status),
        residual: Laws::of_contacts(&solution.certificate, !problem.bilateral_violation.is_empty()),
        iterations: u64::from(solution.report.iterations()),
        seconds,
        point: Point::Contact(Box::new(solution)),
    })
}

fn solve_lcp(problem: &Lcp, kind: &MethodKind) -> Result<Answer, ProblemError> {
    let mut method = kind.build()?;
    let begin = Instant::now();
    let solution = method.solve(problem, None);
    Ok(plain_answer(kind, solution, begin.elapsed().as_secs_f64()))
}

fn solve_mixed(problem: &MixedLcp, kind: &MethodKind) -> Result<Answer, ProblemError> {
    let mut method = kind.build()?;
    let begin = Instant::now();
    let solution = problem.solve(method.as_mut(), None);
    Ok(plain_answer(kind, solution, begin.elapsed().as_secs_f64()))
}

fn plain_answer(kind: &MethodKind, solution: Solution, seconds: f64) -> Answer {
    Answer {
        n: solution.z.len(),
        contacts: None,
        method: kind.to_string(),
        status: lcp_status(&solution.status),
        residual: Laws::natural_map(solution.residual.value),
        iterations: solution.iterations as u64,
        seconds,
        point: Point::Plain(solution.z),
    }
}
