//! Which law the gaps of contact points follow.

use signorini_multibody::ContactPoint;
use signorini_simulation::RestitutionLaw;

use super::system::Step;
use crate::validity::{InequalityKind, InequalitySource, Margin};

/// How the gap of the problem follows from that of the point.
#[derive(Clone, Copy, Debug)]
pub(super) enum GapLaw {
    /// It is this part of it.
    Part(f64),
    /// It is the rebound `e Δt` of the approach.
    Rebound(f64),
}

pub(super) fn gap_law(
    step: &Step,
    i: usize,
    point: &ContactPoint,
    margins: &mut Vec<Margin>,
) -> Result<GapLaw, &'static str> {
    let (problem, settings) = (step.workspace.problem(), step.settings);
    let (dt, found) = (problem.timestep, problem.gap[i]);
    let mut threshold = |value: f64| {
        let (source, kind) = (InequalitySource::Contact(i), InequalityKind::Threshold);
        margins.push(Margin { source, kind, value: step.scales.velocity(value) });
    };
    let restitution = step.model.pair_restitution(point.geom_a, point.geom_b);
    if restitution > 0.0 {
        let at_rest = step.model.gravity.length() * dt;
        let [approach, ..] = problem.contact_velocity(i, &step.state.v);
        let [free, ..] = problem.contact_velocity(i, &problem.free_velocity);
        let fast = -at_rest - approach;
        let closes = -(point.gap / dt + approach.min(free));
        let is_impact = step.workspace.is_impact(i);
        threshold(if is_impact { fast.abs().min(closes.abs()) } else { fast.min(closes).abs() });
        if is_impact && settings.restitution == RestitutionLaw::Newton && found == dt * restitution * approach {
            return Ok(GapLaw::Rebound(restitution));
        }
    }
    let counted = step.workspace.counted_gap(point);
    if settings.gap_resolution > 0.0 {
        threshold((settings.gap_resolution - point.gap.abs()).abs() / dt);
        if counted == 0.0 && found == 0.0 {
            return Ok(GapLaw::Part(0.0));
        }
    }
    // The law is that of the gap, whose last digits the problem leaves out.
    let is_left_out = found == 0.0 && step.workspace.leaves_out_last_digits(point);
    if point.gap >= 0.0 {
        if settings.stabilization != 1.0 {
            threshold(point.gap / dt);
        }
        let is_own = found == counted || is_left_out;
        return if is_own { Ok(GapLaw::Part(1.0)) } else { Err("its gap is corrected by another law") };
    }
    let asked = settings.stabilization * counted;
    if settings.correction_speed.is_finite() {
        threshold((settings.correction_speed + asked / dt).abs());
    }
    if settings.stabilization != 1.0 {
        threshold(-point.gap / dt);
    }
    if found == asked || is_left_out {
        Ok(GapLaw::Part(settings.stabilization))
    } else {
        Err("its overlap is removed at a bounded speed")
    }
}
