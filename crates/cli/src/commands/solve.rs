//! `signorini solve`.

use std::path::{Path, PathBuf};

use clap::Args;
use signorini::contact::problem_file::{
    self, ProblemFile, write_cone_solution, write_contact_solution, write_contradiction, write_exclusion,
    write_plain_solution,
};

use crate::args::{DEFAULT_CONE_TOLERANCE, MethodChoice, directions, fraction};
use crate::error::CliError;
use crate::exit::Exit;
use crate::results::{DenialProof, SolveResult, StageHistory, StageLine};
use crate::solving::{
    Answer, Denial, Options, Point, SolverChoice, solve_contact, solve_frictional, solve_lcp, solve_mixed,
    with_directions,
};
use crate::{output, text};

const EXAMPLE: &str = "\
Examples:
  signorini solve problem.npz --out solution.npz
  signorini solve problems/*.npz --json
  signorini solve problem.npz --method lemke --directions 16
  signorini solve problem.npz --method circular --out solution.npz
  signorini solve problem.npz --method refined --tolerance 1e-9
  signorini solve table.npz --least-norm --ranges

Methods:
  structured                   the polygon's law, sparse and exact (kind contact)
  automatic, lemke, enumeration, principal-pivoting, psor, newton-fischer-burmeister, newton-minimum
                               the same law as a dense LCP, and kinds lcp, mlcp, frictional3d, frictional2d
  circular                     Coulomb's law with the circular cone (kinds contact, frictional3d, frictional2d)
  refined                      polygons turned into the slip until the circular cone's laws hold within --tolerance
  relaxation                   Anitescu's convex relaxation, another model: its own residuals, and beside them those of the
                               contact laws, which it does not satisfy where anything slides

A method that a problem does not suit is `refused`, with the reason. Kinds of problems: lcp, mlcp, contact, frictional3d,
frictional2d (the field `kind` of the file). Every problem is solved even if one before it is not, or its file cannot be
read; the exit code is 1 if a file cannot be read or does not fit the options, else 2 if a problem is not solved.";

/// Arguments of `solve`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// Problem files.
    #[arg(required = true, value_name = "PROBLEM.npz")]
    pub problems: Vec<PathBuf>,
    /// Solver, see below. [default: structured for contact, else automatic]
    #[arg(long, value_name = "NAME", value_parser = SolverChoice::parse)]
    pub method: Option<SolverChoice>,
    /// Friction directions of every contact, even and at least 4. [default: the file's own for contact, 8 for frictional3d]
    #[arg(long, value_name = "M", value_parser = directions)]
    pub directions: Option<usize>,
    /// A problem is solved when every residual is at most this.
    #[arg(long, value_name = "X", default_value = "1e-8", value_parser = fraction)]
    pub tol: f64,
    /// With --method refined: bound on every residual of the circular cone's laws. [default: 1e-6]
    #[arg(long, value_name = "X", value_parser = fraction)]
    pub tolerance: Option<f64>,
    /// Of all impulses that give the same velocity take those of least norm (kind contact, polygon's law).
    #[arg(long)]
    pub least_norm: bool,
    /// Describe all impulses that give the same velocity: dimension, and range at each contact (kind contact, polygon's law).
    #[arg(long)]
    pub ranges: bool,
    /// Add to --json what every stage of the structured solver did on every island, residuals included.
    #[arg(long, requires = "json")]
    pub history: bool,
    /// Write the solution (of a single problem), the proof that there is none, or the best point found.
    #[arg(long, value_name = "SOLUTION.npz")]
    pub out: Option<PathBuf>,
    /// Print one JSON object per problem, each on one line.
    #[arg(long)]
    pub json: bool,
}

/// Solves every problem and prints what came out.
pub fn run(arguments: &Arguments) -> Result<Exit, CliError> {
    check_options(arguments)?;
    let problems: Vec<&Path> = arguments.problems.iter().map(PathBuf::as_path).collect();
    output::keep_apart(&problems, &[("--out", arguments.out.as_deref())])?;
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

/// Refuses options that have no meaning together.
fn check_options(arguments: &Arguments) -> Result<(), CliError> {
    if arguments.out.is_some() && arguments.problems.len() > 1 {
        return Err(CliError::OneSolution { problems: arguments.problems.len() });
    }
    let unused = |option, needs| Err(CliError::UnusedOption { option, needs });
    let method = arguments.method.as_ref();
    if arguments.tolerance.is_some() && method != Some(&SolverChoice::Refined) {
        return unused("--tolerance", "--method refined");
    }
    if matches!(method, Some(SolverChoice::Circular | SolverChoice::Relaxation)) {
        const POLYGON: &str = "methods that solve the polygon's law (structured, refined, methods for LCPs)";
        if arguments.least_norm {
            return unused("--least-norm", POLYGON);
        }
        if arguments.ranges {
            return unused("--ranges", POLYGON);
        }
    }
    if arguments.history && !matches!(method, None | Some(SolverChoice::Polygon(MethodChoice::Structured))) {
        return unused("--history", "--method structured");
    }
    if arguments.out.is_some() && method == Some(&SolverChoice::Relaxation) {
        return unused("--out", "methods that solve the contact laws, which the relaxation does not");
    }
    Ok(())
}

fn solve_file(path: &Path, arguments: &Arguments) -> Result<SolveResult, CliError> {
    let problem = problem_file::read(path).map_err(CliError::in_file(path))?;
    let kind = problem.kind();
    let answer = solve_problem(problem, kind, path, arguments)?;
    if let Some(out) = &arguments.out {
        match (&answer.denial, &answer.point) {
            (Some((Denial::Gaps(proof), _)), _) => write_contradiction(out, proof),
            (Some((Denial::Cases(proof), _)), _) => write_exclusion(out, proof),
            (None, Point::Contact(solution)) => write_contact_solution(out, solution),
            (None, Point::Cone(solution)) => write_cone_solution(out, solution),
            (None, Point::Plain(z)) => write_plain_solution(out, z),
            (None, Point::Relaxed(_)) => Ok(()),
        }
        .map_err(CliError::in_file(out))?;
    }
    let refined = arguments.method == Some(SolverChoice::Refined);
    Ok(SolveResult {
        problem: path.into(),
        kind,
        n: answer.n,
        contacts: answer.contacts,
        status: answer.status(),
        method: answer.method,
        law: answer.law,
        reason: answer.ending.reason.filter(|_| !answer.holds),
        tolerance: arguments.tol,
        residual: answer.residual,
        circular_laws: answer.circular_laws,
        circular_tolerance: refined.then(|| cone_tolerance(arguments)),
        contact_laws: answer.contact_laws,
        iterations: answer.iterations,
        seconds: answer.seconds,
        stages: StageLine::list(&answer.point.stages()),
        history: arguments.history.then(|| answer.point.history().iter().map(StageHistory::from).collect()),
        least_norm: answer.least_norm,
        distributions: answer.distributions,
        involved: if answer.holds { Vec::new() } else { answer.ending.involved },
        denial: answer.denial.as_ref().map(|(proof, residual)| DenialProof::of(proof, *residual)),
        solution: arguments.out.as_ref().map(Into::into),
    })
}

fn cone_tolerance(arguments: &Arguments) -> f64 {
    arguments.tolerance.unwrap_or(DEFAULT_CONE_TOLERANCE)
}

fn solve_problem(
    problem: ProblemFile,
    kind: &'static str,
    path: &Path,
    arguments: &Arguments,
) -> Result<Answer, CliError> {
    let in_file = |error| CliError::in_file(path)(error);
    let options = Options {
        tolerance: arguments.tol,
        cone_tolerance: cone_tolerance(arguments),
        least_norm: arguments.least_norm,
        ranges: arguments.ranges,
        history: arguments.history,
    };
    if let ProblemFile::Contact(problem) = problem {
        let problem = with_directions(problem, arguments.directions).map_err(in_file)?;
        let method = arguments.method.clone().unwrap_or(SolverChoice::Polygon(MethodChoice::Structured));
        return solve_contact(&problem, &method, &options).map_err(in_file);
    }
    for (option, given) in [("--least-norm", options.least_norm), ("--ranges", options.ranges)] {
        if given {
            return Err(CliError::OptionNeedsContacts { path: path.to_owned(), option, kind });
        }
    }
    let choice = arguments.method.clone().unwrap_or_else(SolverChoice::automatic);
    let unsuited = || CliError::NeedsContacts { path: path.to_owned(), method: choice.name(), kind };
    let lcp = choice.lcp();
    match problem {
        ProblemFile::Lcp(problem) => solve_lcp(&problem, lcp.ok_or_else(unsuited)?, &options).map_err(in_file),
        ProblemFile::MixedLcp(problem) => solve_mixed(&problem, lcp.ok_or_else(unsuited)?, &options).map_err(in_file),
        ProblemFile::Frictional(problem) => {
            if lcp.is_none() && choice != SolverChoice::Circular {
                return Err(unsuited());
            }
            solve_frictional(&problem, lcp, arguments.directions, &options).map_err(in_file)
        }
        _ => Err(CliError::UnsupportedKind { path: path.to_owned() }),
    }
}
