//! Results of `solve` and `check` in words.

use std::fmt::Write;

use super::{count, laws, number};
use crate::results::{CheckResult, Distributions, Laws, SolveResult};
use crate::solving::ContactLaw;

/// A solved (or refused) problem.
pub fn solve(result: &SolveResult) -> String {
    let contacts = result.contacts.map(|n| format!(", {}", count(n as u64, "contact"))).unwrap_or_default();
    let relaxed =
        if result.law == Some(ContactLaw::Relaxation) { " (the relaxation, not the contact laws)" } else { "" };
    let mut out = format!("{}: {}{relaxed}\n", result.problem.display(), result.status.replace('_', " "));
    let _ = writeln!(out, "  problem    {}, {} rows{contacts}", result.kind, result.n);
    let _ = writeln!(
        out,
        "  method     {}, {}, {:.3e} s",
        result.method,
        count(result.iterations, "iteration"),
        result.seconds
    );
    if let Some(reason) = &result.reason {
        let _ = writeln!(out, "  reason     {reason}");
    }
    if !matches!(result.status, "refused" | "too_large") {
        out.push_str(&residuals(result));
    }
    if let Some(choice) = &result.least_norm {
        let _ = writeln!(
            out,
            "  least norm {}: {} N·s, before {} N·s",
            choice.outcome.replace('_', " "),
            number(choice.norm),
            number(choice.norm_before)
        );
    }
    if let Some(set) = &result.distributions {
        out.push_str(&distributions(set));
    }
    if !result.involved.is_empty() {
        let what = if result.kind == "contact" { "contacts" } else { "rows" };
        let list = result.involved.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
        let _ = writeln!(out, "  involved   {what} {list}");
    }
    if let Some(path) = &result.solution {
        let what = match result.status {
            "solved" => "solution  ",
            _ if result.denial.is_some() => "proof     ",
            _ => "best point",
        };
        let _ = writeln!(out, "  {what} {}", path.display());
    }
    out
}

/// The residuals of the law solved, and of those that it is compared with.
fn residuals(result: &SolveResult) -> String {
    let mut out = format!("  residuals  {} (tolerance {:e})\n", laws(&result.residual), result.tolerance);
    if let Some(circular) = &result.circular_laws {
        let tolerance = result.circular_tolerance.map(|t| format!(" (tolerance {t:e})")).unwrap_or_default();
        let _ = writeln!(out, "  circular   {}{tolerance}", laws(circular));
    }
    if let Some(true_laws) = &result.contact_laws {
        let _ = writeln!(out, "  true laws  {} (not asked of a relaxation)", laws(true_laws));
    }
    out
}

/// The set of impulses, contact by contact.
fn distributions(set: &Distributions) -> String {
    let range = |[min, max]: [Option<f64>; 2]| {
        let end = |x: Option<f64>, unbounded: &str| x.map_or(unbounded.to_owned(), number);
        format!("[{}, {}]", end(min, "−∞"), end(max, "∞"))
    };
    let mut out = match set.dimension {
        0 => "  impulses   unique\n".to_owned(),
        n => format!("  impulses   a set of dimension {n}; ranges in N·s\n"),
    };
    let _ = writeln!(out, "    {:>7}  {:^25}  {:^25}  {:^25}", "contact", "normal", "tangent 1", "tangent 2");
    for (i, [normal, t_1, t_2]) in set.contacts.iter().map(|ranges| ranges.map(range)).enumerate() {
        let _ = writeln!(out, "    {i:>7}  {normal:<25}  {t_1:<25}  {t_2:<25}");
    }
    for (k, row) in set.bilateral.iter().enumerate() {
        let _ = writeln!(out, "    bilateral row {k}: {}", range(*row));
    }
    out
}

/// A checked solution.
pub fn check(result: &CheckResult) -> String {
    let verdict = if result.ok { "every law holds" } else { "VIOLATED" };
    let cone = if result.law == Some(ContactLaw::Circular) { " of the circular cone" } else { "" };
    let mut out = format!("{}: {verdict}{cone} (tolerance {:e})\n", result.solution.display(), result.tolerance);
    if let Some(verdict) = result.verdict {
        let _ = writeln!(out, "  verdict      {}", verdict.replace('_', " "));
    }
    let laws = result.laws.iter().flat_map(Laws::list);
    for (name, residual) in laws.chain(result.proof.iter().map(|(name, r)| (*name, *r))) {
        let mark = if result.violated.contains(&name) { "violated" } else { "holds" };
        let _ = writeln!(out, "  {:12} {residual:9.2e}  {mark}", name.replace('_', " "));
    }
    out
}
