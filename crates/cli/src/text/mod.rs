//! Results in words for people.

mod comparison;
mod inspection;
mod recording;
mod run;
mod solving;
mod stability;

pub use comparison::comparison;
pub use inspection::inspection;
pub use recording::recording;
pub use run::{export, run, settled, settling};
pub use solving::{check, solve};
pub use stability::stability;

use std::fmt::Write;

use signorini_scenes::Scene;

use crate::results::{ImportWarning, Laws};

/// A number with at most six digits.
pub fn number(x: f64) -> String {
    if x == 0.0 {
        return "0".into();
    }
    if !(1e-4..1e6).contains(&x.abs()) {
        return format!("{x:.3e}");
    }
    let decimals = (5 - x.abs().log10().floor() as i32).max(0) as usize;
    let text = format!("{x:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// Numbers in brackets.
fn numbers(values: &[f64]) -> String {
    format!("[{}]", values.iter().map(|&x| number(x)).collect::<Vec<_>>().join(", "))
}

/// A count with its noun.
fn count(n: u64, one: &str) -> String {
    if n == 1 { format!("1 {one}") } else { format!("{n} {one}s") }
}

/// A count of bodies.
fn bodies(n: usize) -> String {
    if n == 1 { "1 body".into() } else { format!("{n} bodies") }
}

/// Residuals in one line.
fn laws(laws: &Laws) -> String {
    laws.list().map(|(name, r)| format!("{} {r:.1e}", name.replace('_', " "))).collect::<Vec<_>>().join(", ")
}

/// The import report; those lines that can change the motion are marked.
fn import(warnings: &[ImportWarning]) -> String {
    if warnings.is_empty() {
        return "import       everything in the file was taken over\n".into();
    }
    let mut out =
        format!("import       {} not taken over (! can change the motion):\n", count(warnings.len() as u64, "thing"));
    for warning in warnings {
        let mark = if warning.changes_motion { '!' } else { ' ' };
        let _ = writeln!(out, "  {mark} {}", warning.text);
    }
    out
}

/// The bundled scenes.
pub fn scenes(scenes: &[Scene]) -> String {
    let width = scenes.iter().map(|scene| scene.name.len()).max().unwrap_or(0);
    scenes.iter().map(|scene| format!("{:width$}  {}\n", scene.name, scene.description())).collect()
}
