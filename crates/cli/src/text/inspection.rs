//! The result of `inspect` in words.

use std::fmt::Write;

use super::{bodies, count, import, number, numbers};
use crate::results::{BodyLine, Inspection};

/// A model: sizes, tree, actuators, keyframes, import report.
pub fn inspection(result: &Inspection) -> String {
    let bodies = bodies(result.bodies.len() - 1);
    let mut out = format!("model        {} ({})\n", result.model, result.source);
    let _ = writeln!(out, "sizes        nq {}, nv {}", result.nq, result.nv);
    let _ = writeln!(
        out,
        "parts        {bodies}, {}, {}, {}",
        count(result.geom_count() as u64, "geom"),
        count(result.actuators.len() as u64, "actuator"),
        count(result.keyframes.len() as u64, "keyframe")
    );
    let _ = writeln!(out, "mass         {} kg", number(result.mass));
    let _ = writeln!(out, "time step    {} s, gravity {} m/s²", number(result.timestep), numbers(&result.gravity));
    out.push_str(&import(&result.warnings));
    out.push_str("tree\n");
    result.tree().into_iter().for_each(|body| tree_lines(body, &mut out));
    for actuator in &result.actuators {
        let _ = writeln!(out, "actuator     {}: {} on {}", actuator.name, actuator.kind, actuator.target);
    }
    if !result.keyframes.is_empty() {
        let _ = writeln!(out, "keyframes    {}", result.keyframes.join(", "));
    }
    out
}

fn tree_lines(body: &BodyLine, out: &mut String) {
    let indent = "  ".repeat(body.depth + 1);
    let mass = if body.parent.is_some() { format!("  {} kg", number(body.mass)) } else { String::new() };
    let welded = if body.parent.is_some() && body.joints.is_empty() { "  welded" } else { "" };
    let _ = writeln!(out, "{indent}{}{mass}{welded}", body.name);
    for joint in &body.joints {
        let axis = joint.axis.map(|axis| format!(" about {}", numbers(&axis))).unwrap_or_default();
        let axis = if joint.kind == "slide" { axis.replace("about", "along") } else { axis };
        let limits = joint.limits.map(|limits| format!(", limits {}", numbers(&limits))).unwrap_or_default();
        let _ = writeln!(
            out,
            "{indent}  joint {}: {}{axis}{limits}, q[{}], v[{}]",
            joint.name, joint.kind, joint.q_index, joint.v_index
        );
    }
    for geom in &body.geoms {
        let size = if geom.size.is_empty() { String::new() } else { format!(" {}", numbers(&geom.size)) };
        let _ = writeln!(out, "{indent}  geom {}: {}{size}, friction {}", geom.name, geom.shape, number(geom.friction));
    }
}
