//! `signorini compare`.
//!
//! Every row is a process of its own, so that one that takes too long or too much memory can be ended without the others.

use std::path::{Path, PathBuf};

use clap::Args;
use signorini::contact::problem_file::{self, ProblemFile};

use crate::args::{directions, fraction, positive};
use crate::error::CliError;
use crate::exit::Exit;
use crate::results::{Comparison, Row};
use crate::solving::{Options, kind_of};
use crate::{output, text};

mod plan;
mod process;
mod row;

use plan::{Plan, plan};

const EXAMPLE: &str = "\
Examples:
  signorini compare problem.npz
  signorini compare problem.npz --directions 4,32 --repetitions 9 --json
  signorini compare large.npz --time-limit 60 --max-rows 10000

Laws: the polygons of the file, regular ones with --directions, the circular cone (solved as such, and by refined polygons),
and the convex relaxation, each with every method that there is for it. For kinds lcp and mlcp the methods alone; for
frictional problems the polygons and the circular cone.

Columns: status of the row's own law and its worst residual; the worst residual of the circular cone's laws; the median time
of a cold solve; iterations; the largest difference of the velocity from the reference, relative to the velocity scale of
the data (for kinds lcp and mlcp of z, relative to its largest entry). The reference is the first row that is solved.

Methods on dense matrices are skipped above --max-rows, and a row is stopped after --time-limit; the same method is then not
tried on larger problems. The exit code is 0 if any row is solved, else 2.";

/// Arguments of `compare`.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// Problem file.
    #[arg(value_name = "PROBLEM.npz")]
    pub problem: PathBuf,
    /// Friction directions of the regular polygons beside the file's own.
    #[arg(long, value_name = "M,…", value_delimiter = ',', default_value = "4,8,16", value_parser = directions)]
    pub directions: Vec<usize>,
    /// A row is solved when every residual is at most this; refinement goes on until the circular cone's laws hold within it.
    #[arg(long, value_name = "X", default_value = "1e-8", value_parser = fraction)]
    pub tol: f64,
    /// Solves of each row; their median time is shown. Fewer where they take more than half of the time limit.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    pub repetitions: u32,
    /// Seconds after which a row is stopped.
    #[arg(long, value_name = "S", default_value = "10", value_parser = positive)]
    pub time_limit: f64,
    /// Complementarity problems with more rows are not given to methods on dense matrices.
    #[arg(long, value_name = "N", default_value_t = 3000)]
    pub max_rows: usize,
    /// Solve this row alone and print it; how the rows of a comparison run.
    #[arg(long, hide = true, value_name = "K")]
    pub row: Option<usize>,
    /// Print one JSON object.
    #[arg(long)]
    pub json: bool,
}

impl Arguments {
    fn options(&self) -> Options {
        Options { tolerance: self.tol, cone_tolerance: self.tol, least_norm: false, ranges: false }
    }
}

/// Solves the problem row by row and prints the table.
pub fn run(arguments: &Arguments) -> Result<Exit, CliError> {
    let path = arguments.problem.as_path();
    let problem = problem_file::read(path).map_err(CliError::in_file(path))?;
    if kind_of(&problem) == "unknown" {
        return Err(CliError::UnsupportedKind { path: path.to_owned() });
    }
    let plans = plan(&problem, &arguments.directions);
    if let Some(k) = arguments.row {
        let planned = plans.get(k).ok_or(CliError::NoSuchRow { row: k, rows: plans.len() })?;
        output::print_json(&row::solve(&problem, planned, arguments));
        return Ok(Exit::Success);
    }
    let result = compare(&problem, path, &plans, arguments)?;
    output::print_result(&result, arguments.json, text::comparison);
    Ok(if result.reference.is_some() { Exit::Success } else { Exit::NotSolved })
}

fn compare(problem: &ProblemFile, path: &Path, plans: &[Plan], arguments: &Arguments) -> Result<Comparison, CliError> {
    let progress = output::progress(plans.len() as u64, "rows");
    let mut rows: Vec<Row> = Vec::with_capacity(plans.len());
    for (k, planned) in plans.iter().enumerate() {
        let row = match reason_to_skip(planned, &rows, arguments) {
            Some(reason) => Row { status: "skipped".into(), reason: Some(reason), ..planned.row() },
            None => process::solve_row(k, planned, arguments)?,
        };
        rows.push(row);
        progress.inc(1);
    }
    progress.finish_and_clear();
    let reference = rows.iter().position(|row| row.status == "solved");
    if let Some(reference) = reference {
        let point = rows[reference].point.clone();
        let scale = scale(problem, &point);
        rows.iter_mut().for_each(|row| row.difference = difference(&row.point, &point, scale));
    }
    rows.iter_mut().for_each(|row| row.point.clear());
    let (nv, contacts) = match problem {
        ProblemFile::Contact(problem) => (Some(problem.nv()), Some(problem.contact_count())),
        ProblemFile::Frictional(problem) => (None, Some(problem.friction.len())),
        _ => (None, None),
    };
    let plain = matches!(problem, ProblemFile::Lcp(_) | ProblemFile::MixedLcp(_));
    Ok(Comparison {
        problem: path.to_owned(),
        kind: kind_of(problem),
        nv,
        contacts,
        tolerance: arguments.tol,
        reference,
        difference_of: if plain { "z" } else { "velocity" },
        rows,
    })
}

/// Why a row is not tried.
fn reason_to_skip(planned: &Plan, before: &[Row], arguments: &Arguments) -> Option<String> {
    if !planned.is_dense() {
        return None;
    }
    if planned.n > arguments.max_rows {
        return Some(format!(
            "{} rows; methods on dense matrices are tried up to --max-rows {}",
            planned.n, arguments.max_rows
        ));
    }
    let name = planned.method.name();
    let stopped = before.iter().find(|row| row.status == "stopped" && row.method == name)?;
    let n = stopped.n.filter(|n| *n <= planned.n)?;
    Some(format!("{} rows; {name} was stopped at {n} already (--time-limit {})", planned.n, arguments.time_limit))
}

/// What differences are relative to; 1 where it is zero.
fn scale(problem: &ProblemFile, reference: &[f64]) -> f64 {
    let largest = |x: &[f64]| x.iter().fold(0.0, |l: f64, x| l.max(x.abs()));
    let scale = match problem {
        ProblemFile::Contact(problem) => problem.velocity_scale(),
        ProblemFile::Frictional(problem) => largest(&problem.free_velocity),
        _ => largest(reference),
    };
    if scale > 0.0 { scale } else { 1.0 }
}

fn difference(point: &[f64], reference: &[f64], scale: f64) -> Option<f64> {
    if point.len() != reference.len() || point.is_empty() {
        return None;
    }
    let largest = point.iter().zip(reference).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    Some(largest / scale)
}
