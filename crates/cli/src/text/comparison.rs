//! The result of `compare` as a table.

use std::fmt::Write;

use super::count;
use crate::results::{Comparison, Row};

const HEADER: [&str; 8] = ["law", "method", "status", "residual", "circular", "time", "iterations", "difference"];
/// Stands where a row has no value.
const NONE: &str = "–";

/// All laws and methods on one problem.
pub fn comparison(result: &Comparison) -> String {
    let contacts = result.contacts.map(|n| format!(", {}", count(n as u64, "contact"))).unwrap_or_default();
    let nv = result.nv.map(|n| format!(", {} of freedom", count(n as u64, "degree"))).unwrap_or_default();
    let mut out = format!("{}: {}{contacts}{nv}\n", result.problem.display(), result.kind);
    let (tolerance, of) = (result.tolerance, result.difference_of);
    let _ = writeln!(out, "tolerance {tolerance:e}; difference of {of} {}", reference(result));
    let rows: Vec<[String; 8]> = result.rows.iter().map(cells).collect();
    let shown: Vec<usize> = (0..8).filter(|&c| c < 3 || rows.iter().any(|row| row[c] != NONE)).collect();
    let length = |text: &str| text.chars().count();
    let widths = HEADER
        .iter()
        .enumerate()
        .map(|(c, title)| rows.iter().map(|row| length(&row[c])).fold(length(title), usize::max));
    let widths: Vec<usize> = widths.collect();
    let line = |cells: &[String; 8]| {
        let padded = shown.iter().map(|&c| match (c, widths[c]) {
            (0..3, width) => format!("{:<width$}", cells[c]),
            (_, width) => format!("{:>width$}", cells[c]),
        });
        padded.collect::<Vec<_>>().join("  ").trim_end().to_owned()
    };
    let _ = writeln!(out, "{}", line(&HEADER.map(str::to_owned)));
    for (row, cells) in result.rows.iter().zip(&rows) {
        let _ = writeln!(out, "{}", line(cells));
        if let Some(note) = note(row) {
            let _ = writeln!(out, "    {note}");
        }
    }
    out
}

fn reference(result: &Comparison) -> String {
    match result.reference.map(|k| &result.rows[k]) {
        Some(row) => format!("to {} with {}", law(row), row.method),
        None => "to nothing: no row is solved".into(),
    }
}

fn law(row: &Row) -> String {
    let directions = row.directions.map(|m| format!(" {m}")).unwrap_or_default();
    format!("{}{directions}{}", row.law, if row.as_given { " (given)" } else { "" })
}

fn cells(row: &Row) -> [String; 8] {
    let size = |x: Option<f64>| x.map_or(NONE.to_owned(), |x| format!("{x:.1e}"));
    [
        law(row),
        row.method.clone(),
        row.status.replace('_', " "),
        size(row.residual),
        size(row.circular_residual),
        row.seconds.map_or(NONE.to_owned(), time),
        row.iterations.map_or(NONE.to_owned(), |n| n.to_string()),
        size(row.difference),
    ]
}

fn time(seconds: f64) -> String {
    match seconds {
        s if s < 1e-3 => format!("{:.1} µs", 1e6 * s),
        s if s < 1.0 => format!("{:.2} ms", 1e3 * s),
        s => format!("{s:.2} s"),
    }
}

/// What a row needs to say in words.
fn note(row: &Row) -> Option<String> {
    let true_laws = row.contact_residual.map(|r| format!("residual of the true contact laws: {r:.1e}"));
    row.reason.clone().or(true_laws)
}
