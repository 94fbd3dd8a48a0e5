//! Results about recordings in words.

use std::fmt::Write;

use super::{count, laws, number};
use crate::results::RecordingResult;
use crate::solving::ContactLaw;

/// A checked recording.
pub fn recording(result: &RecordingResult) -> String {
    let verdict = if result.ok { "every law holds in every step" } else { "VIOLATED" };
    let cone = if result.law == ContactLaw::Circular { ", circular cone" } else { "" };
    let mut out = format!("{}: {verdict} (tolerance {:e}{cone})\n", result.recording.display(), result.tolerance);
    let _ = writeln!(out, "  model      {}", result.model);
    let _ = writeln!(out, "  steps      {} certified, of {}", result.steps, count(result.frames as u64, "frame"));
    let _ = writeln!(out, "  worst      {} (step {})", laws(&result.worst), result.worst_step);
    if let Some(circular) = result.worst_circular.as_ref().filter(|_| result.law == ContactLaw::Polygon) {
        let _ = writeln!(out, "  circular   {}", laws(circular));
    }
    if let Some(resolution) = result.gap_resolution {
        let _ = writeln!(out, "  gaps       up to {resolution:e} m count as closed");
    }
    let _ = writeln!(out, "  ending     {}", result.ending);
    if result.limited_steps > 0 {
        let steps = count(result.limited_steps as u64, "step");
        let _ = writeln!(out, "  limited    {steps} with a part of overlaps and violations (θ < 1)");
    }
    if result.clipped_steps > 0 {
        let _ = writeln!(
            out,
            "  clipped    {} with penetrations taken as zero",
            count(result.clipped_steps as u64, "step")
        );
    }
    if let Some(first) = result.restarts.first() {
        let steps = count(result.restarts.len() as u64, "step");
        let _ = writeln!(out, "  restarts   {steps} not begun where the one before ended, the first is step {first}");
    }
    if result.violated_steps > 0 {
        let _ = writeln!(out, "  violated   {}", count(result.violated_steps as u64, "step"));
    }
    for violation in &result.violations {
        let residual = violation.residual.map(|r| format!("residual {r:.1e}"));
        let what = [residual, violation.fault.clone()].into_iter().flatten().collect::<Vec<_>>().join("; ");
        let _ = writeln!(out, "    step {} at {} s: {what}", violation.step, number(violation.time));
    }
    out
}
