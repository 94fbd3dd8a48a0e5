//! The result of `compare` as a table.

use std::fmt::Write;

use super::count;
use crate::results::{Comparison, Row};

/// All laws and methods on one problem.
pub fn comparison(result: &Comparison) -> String {
    let contacts = result.contacts.map(|n| format!(", {}", count(n as u64, "contact"))).unwrap_or_default();
    let nv = result.nv.map(|n| format!(", {}", count(n as u64, "degree of freedom").replace("freedoms", "freedom")));
    let mut out = format!("{}: {}{contacts}{}\n", result.problem.display(), result.kind, nv.unwrap_or_default());
    let _ =
        writeln!(out, "tolerance {:e}; difference of {} {}", result.tolerance, result.difference_of, reference(result));
    let header = ["law", "method", "status", "residual", "circular", "time", "iterations", "difference"];
    let lines: Vec<[String; 8]> =
        std::iter::once(header.map(str::to_owned)).chain(result.rows.iter().map(cells)).collect();
    let width = |column: usize| lines.iter().map(|line| line[column].chars().count()).max().unwrap_or(0);
    let widths: [usize; 8] = std::array::from_fn(width);
    for (k, line) in lines.iter().enumerate() {
        let cells = line.iter().zip(widths).enumerate().map(|(column, (cell, width))| match column {
            0..3 => format!("{cell:<width$}"),
            _ => format!("{cell:>width$}"),
        });
        let _ = writeln!(out, "{}", cells.collect::<Vec<_>>().join("  ").trim_end());
        if let Some(note) = k.checked_sub(1).and_then(|row| note(&result.rows[row])) {
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
    let size = |x: Option<f64>| x.map_or("–".to_owned(), |x| format!("{x:.1e}"));
    [
        law(row),
        row.method.clone(),
        row.status.replace('_', " "),
        size(row.residual),
        size(row.circular_residual),
        row.seconds.map_or("–".to_owned(), time),
        row.iterations.map_or("–".to_owned(), |n| n.to_string()),
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
