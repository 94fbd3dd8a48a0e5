//! What the last step tells of itself, and what all steps add up to.

use crate::error::{guarded, signorini_status, SIGNORINI_OK};
use crate::pointers::{owned, shared};
use crate::simulation::signorini_simulation;

/// Residuals of the laws of the last step; each is 0 for an exact solution and has no unit.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct signorini_certificate {
    /// Momentum balance.
    pub momentum: f64,
    /// The complementarity problem, in one unit.
    pub natural_map: f64,
    /// Signorini's condition.
    pub signorini: f64,
    /// The friction bound.
    pub friction: f64,
    /// Maximum dissipation.
    pub dissipation: f64,
    /// Equality constraints.
    pub bilateral: f64,
    /// The largest of them.
    pub worst: f64,
}

impl From<&signorini::contact::Certificate> for signorini_certificate {
    fn from(c: &signorini::contact::Certificate) -> Self {
        Self {
            momentum: c.momentum,
            natural_map: c.natural_map,
            signorini: c.signorini,
            friction: c.friction,
            dissipation: c.dissipation,
            bilateral: c.bilateral,
            worst: c.worst(),
        }
    }
}

/// The certificate of the last step.
#[no_mangle]
pub unsafe extern "C" fn signorini_step_certificate(
    simulation: *const signorini_simulation,
    certificate: *mut signorini_certificate,
) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let (handle, certificate) = unsafe { (shared(simulation, "simulation")?, owned(certificate, "certificate")?) };
        *certificate = signorini_certificate::from(&handle.inner.report().certificate);
        Ok(SIGNORINI_OK)
    })
}

/// How the last step went.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct signorini_report {
    /// Contacts in its problem, limits of joints included.
    pub contacts: usize,
    /// Contact problems that were solved.
    pub solves: u32,
    /// Overlaps and violations that it kept a part of, because the laws permit to remove no more, or not with as little energy.
    pub kept: usize,
    /// Contact points that overlap and that nothing can move along their normal; they are not in the problem.
    pub left_out: usize,
    /// Part of the overlaps and violations that it removes: 1 where it is all that was asked for.
    pub theta: f64,
    /// The most that it kept of what corrections at their speed would remove, m or rad.
    pub deepest_kept: f64,
    /// Work of the impulses along the corrections, J.
    pub correction_energy: f64,
    /// Largest violation of an equality constraint at its beginning, m or rad.
    pub constraint_error: f64,
    /// Root mean square of the residuals where the budget of sweeps was used up; otherwise 0.
    pub residual_rms: f64,
    /// Whether a residual exceeds the tolerance.
    pub missed_tolerance: bool,
    /// Whether the budget of sweeps was used up.
    pub unfinished: bool,
    /// Whether negative gaps were taken as zero.
    pub clipped_gaps: bool,
}

/// The report of the last step.
#[no_mangle]
pub unsafe extern "C" fn signorini_step_report(
    simulation: *const signorini_simulation,
    report: *mut signorini_report,
) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let (handle, place) = unsafe { (shared(simulation, "simulation")?, owned(report, "report")?) };
        let report = handle.inner.report();
        *place = signorini_report {
            contacts: report.contacts,
            solves: report.solves,
            kept: report.kept.len(),
            left_out: report.left_out,
            theta: report.theta,
            deepest_kept: report.kept.iter().fold(0.0, |deepest, kept| deepest.max(kept.size)),
            correction_energy: report.correction_energy,
            constraint_error: report.constraint_error,
            residual_rms: report.spread.as_ref().map_or(0.0, |spread| spread.rms),
            missed_tolerance: report.missed_tolerance,
            unfinished: report.spread.is_some(),
            clipped_gaps: report.clipped_gaps,
        };
        Ok(SIGNORINI_OK)
    })
}

/// What all steps of a simulation add up to.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct signorini_summary {
    /// Steps made.
    pub steps: u64,
    /// Steps whose residuals exceed the tolerance.
    pub missed_steps: u64,
    /// Steps whose budget of sweeps was used up.
    pub unfinished_steps: u64,
    /// Steps that kept a part of their overlaps and violations (theta < 1).
    pub limited_steps: u64,
    /// The most contacts of a step.
    pub contacts_max: usize,
    /// The smallest theta of a step; 1 where none was limited.
    pub smallest_theta: f64,
    /// The most that a step kept of what corrections at their speed would remove, m or rad.
    pub deepest_kept: f64,
    /// The deepest penetration of a contact point at the beginning of a step, m.
    pub deepest_penetration: f64,
    /// Work of the impulses along the corrections of all steps, J.
    pub correction_energy: f64,
    /// The largest residual of each law.
    pub worst: signorini_certificate,
}

/// The sums over all steps so far.
#[no_mangle]
pub unsafe extern "C" fn signorini_summary_of(
    simulation: *const signorini_simulation,
    summary: *mut signorini_summary,
) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let (handle, place) = unsafe { (shared(simulation, "simulation")?, owned(summary, "summary")?) };
        let summary = handle.inner.summary();
        *place = signorini_summary {
            steps: summary.steps,
            missed_steps: summary.missed_steps,
            unfinished_steps: summary.unfinished_steps,
            limited_steps: summary.limited_steps,
            contacts_max: summary.contacts_max,
            smallest_theta: summary.smallest_theta,
            deepest_kept: summary.deepest_kept,
            deepest_penetration: summary.deepest_penetration,
            correction_energy: summary.correction_energy,
            worst: signorini_certificate::from(&summary.worst),
        };
        Ok(SIGNORINI_OK)
    })
}
