//! Results of `solve` and `check` in words.

use std::fmt::Write;

use super::{count, laws};
use crate::results::{CheckResult, SolveResult};

/// A solved (or refused) problem.
pub fn solve(result: &SolveResult) -> String {
    let contacts = result.contacts.map(|n| format!(", {}", count(n as u64, "contact"))).unwrap_or_default();
    let mut out = format!("{}: {}\n", result.problem.display(), result.status.replace('_', " "));
    let _ = writeln!(out, "  problem    {}, {} rows{contacts}", result.kind, result.n);
    let _ = writeln!(
        out,
        "  method     {}, {}, {:.3e} s",
        result.method,
        count(result.iterations, "iteration"),
        result.seconds
    );
    let _ = writeln!(out, "  residuals  {} (tolerance {:e})", laws(&result.residual), result.tolerance);
    if !result.involved.is_empty() {
        let what = if result.kind == "contact" { "contacts" } else { "rows" };
        let list = result.involved.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
        let _ = writeln!(out, "  involved   {what} {list}");
    }
    if let Some(path) = &result.solution {
        let what = if result.status == "solved" { "solution  " } else { "best point" };
        let _ = writeln!(out, "  {what} {}", path.display());
    }
    out
}

/// A checked solution.
pub fn check(result: &CheckResult) -> String {
    let verdict = if result.ok { "every law holds" } else { "VIOLATED" };
    let mut out = format!("{}: {verdict} (tolerance {:e})\n", result.solution.display(), result.tolerance);
    for (name, residual) in result.laws.list() {
        let mark = if result.violated.contains(&name) { "violated" } else { "holds" };
        let _ = writeln!(out, "  {:12} {residual:9.2e}  {mark}", name.replace('_', " "));
    }
    out
}
