//! `signorini compare`.
//!
//! Every row is a process of its own, so that one that takes too long or too much memory can be ended without the others.

use std::path::Path;

use signorini::contact::problem_file::{self, ProblemFile};

use crate::error::CliError;
use crate::exit::Exit;
use crate::results::{Comparison, Row};
use crate::{output, text};

mod arguments;
mod plan;
mod process;
mod row;

pub use arguments::Arguments;

use plan::{Plan, plan};

/// Solves the problem row by row and prints the table.
pub fn run(arguments: &Arguments) -> Result<Exit, CliError> {
    let path = arguments.problem.as_path();
    let problem = problem_file::read(path).map_err(CliError::in_file(path))?;
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
        problem: path.into(),
        kind: problem.kind(),
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
