//! Results of `stability` in words.

use std::fmt::Write;

use super::{bodies, count, number};
use crate::results::{CriticalLine, SafetyResult, StabilityResult};

/// Bodies that are named.
const NAMED: usize = 8;

/// A verdict.
pub fn stability(result: &StabilityResult) -> String {
    let meaning = match (result.verdict, result.proof) {
        ("must_move", _) => "no contact forces within the friction cones balance the loads",
        ("stays", Some("without_friction")) => "forces balance the loads without friction, so that nothing can move",
        ("stays", _) => "forces balance the loads, and no combination of contact modes lets anything move",
        ("may_do_either", _) => "forces balance the loads, and there is a moving solution as well",
        _ => "forces balance the loads; no moving solution was found, and nothing more is proved",
    };
    let mut out = format!("{}: {}\n  {meaning}\n", result.source, result.verdict.replace('_', " "));
    let holds = if result.proved { "holds" } else { "does NOT hold" };
    let residuals: Vec<String> =
        result.residuals.iter().map(|(name, r)| format!("{} {r:.1e}", name.replace('_', " "))).collect();
    let _ = writeln!(out, "  proof      {} ({holds} within {:e})", residuals.join(", "), result.tolerance);
    let _ = writeln!(out, "  problem    {}, nv = {}", count(result.contacts as u64, "contact"), result.nv);
    if let Some(force) = result.required_force {
        let size = if force.is_finite() {
            format!("would take {} N or more", number(force))
        } else {
            "cannot be had by any forces".into()
        };
        let _ = writeln!(out, "  balance    {size}");
    }
    if !result.motion.is_empty() {
        let what = if result.verdict == "must_move" { "collapse  " } else { "motion    " };
        let names: Vec<&str> = result.motion.iter().take(NAMED).map(|m| m.body.as_str()).collect();
        let more = if result.motion.len() > NAMED { ", …" } else { "" };
        let _ = writeln!(out, "  {what} {}: {}{more}", bodies(result.motion.len()), names.join(", "));
    }
    if let Some(limit) = &result.safety {
        out += &safety(limit);
    }
    for body in least_borne(&result.bodies) {
        let push = format!("{} N, {} of its weight", number(body.push), number(body.by_weight));
        let _ = writeln!(out, "  pushed     {} bears {push} at the centre of mass", body.body);
    }
    if let Some(most) = result.forces.iter().max_by(|a, b| a.friction_use.total_cmp(&b.friction_use)) {
        let _ = writeln!(
            out,
            "  friction   up to {} % of it used, {}",
            number(100.0 * most.friction_use),
            most.between.join(" on ")
        );
    }
    if !result.search.is_empty() && result.verdict != "must_move" {
        let moved = result.search.iter().filter(|[_, end]| *end == "moves").count();
        let programs = count(result.enumeration_programs as u64, "program");
        let starts = count(result.search.len() as u64, "start");
        let _ = writeln!(out, "  search     {starts}, {moved} moving; enumeration of modes: {programs}");
    }
    if result.deepest_overlap > 0.0 {
        let _ = writeln!(out, "  overlap    up to {} taken as touching", number(result.deepest_overlap));
    }
    if result.constraint_error > 1e-9 {
        let _ =
            writeln!(out, "  joints     constraints violated by {} taken as closed", number(result.constraint_error));
    }
    out
}

/// The bodies that bear least, as part of their weight.
fn least_borne(bodies: &[CriticalLine]) -> Vec<&CriticalLine> {
    let mut all: Vec<&CriticalLine> = bodies.iter().collect();
    all.sort_by(|a, b| a.by_weight.total_cmp(&b.by_weight));
    all.truncate(NAMED);
    all
}

/// A limit.
fn safety(limit: &SafetyResult) -> String {
    let unit = match limit.what {
        "tilt" => "°",
        "weight" => " kg",
        "push" => " N",
        _ => "",
    };
    let value = |x: f64| if x.is_finite() { format!("{x:.10}{unit}") } else { "never".into() };
    let mut out = format!("  {:10} balance at {}, none at {}\n", limit.what, value(limit.holds), value(limit.falls));
    if let (Some([x, y, z]), Some(least)) = (limit.direction, limit.at_least) {
        let _ = writeln!(
            out,
            "             worst towards ({x:.6}, {y:.6}, {z:.6}); no direction bears less than {}",
            value(least)
        );
    }
    if let (Some([inside, outside]), Some([holds, falls])) = (limit.polygons, limit.circular) {
        let _ = writeln!(
            out,
            "             circular cones: balance at {}, none at {} (polygons inside {}, outside {})",
            value(holds),
            value(falls),
            value(inside),
            value(outside)
        );
    }
    if let Some([still, moves]) = limit.motion {
        let _ = writeln!(out, "             motion: none found at {}, begins at {}", value(still), value(moves));
    }
    out
}
