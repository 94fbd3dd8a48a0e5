//! What a step was solved with and to, for a recording.

use signorini_contact::{ContactSolution, FrictionGroups};
use signorini_multibody::Input;
use signorini_recording::{Frame, Impulses, LimitFrame, StepSolution};

use crate::report::{KeptRow, StepReport};
use crate::source::ContactSource;
use crate::workspace::Workspace;

/// Adds to a frame, after [`frame_into`](super::frame_into), what acted in the step and its solution, so that its
/// certificate can be computed again ([`Recertifier`](crate::Recertifier)). A step without solution adds nothing.
///
/// - `input`: what acted during the step
/// - `workspace`, `report`: after the step
pub fn step_solution_into(input: &Input, workspace: &Workspace, report: &StepReport, frame: &mut Frame) {
    let out = &mut frame.solution;
    out.clear();
    if !report.advanced() {
        return;
    }
    out.control.clone_from(&input.control);
    // A recorded force is that of the degrees of freedom, whatever it came from.
    out.generalized_force.clone_from(match input.wrench.is_empty() {
        true => &input.generalized_force,
        false => &workspace.smooth.applied_force,
    });
    out.clipped_gaps = report.clipped_gaps;
    out.theta = (report.theta < 1.0).then_some(report.theta);
    let contacts = workspace.problem().contact_count();
    out.limited.extend(report.kept.iter().map(|kept| match kept.row {
        KeptRow::Contact(i) => i as u32,
        KeptRow::Bilateral(k) => (contacts + k) as u32,
    }));
    out.limited.sort_unstable();
    out.limited.dedup();
    let groups = &workspace.problem().friction_groups;
    if !workspace.solver.keeps_directions() {
        add_directions(groups, out);
        if let Some((problem, _)) = workspace.decompression() {
            add_directions(&problem.friction_groups, out);
        }
    }
    if report.enlargements > 0 {
        out.reach.extend(workspace.reach.reach.iter().map(|reach| [reach.linear, reach.angular]));
    }
    let limits = workspace.contact_points().len()..contacts;
    out.limits.extend(limits.filter_map(|i| limit_frame(workspace, i)));
    copy(workspace.solution(), &mut out.impulses[0]);
    out.phases = 1;
    if let Some((_, solution)) = workspace.decompression() {
        copy(solution, &mut out.impulses[1]);
        out.phases = 2;
    }
}

fn add_directions(groups: &FrictionGroups, out: &mut StepSolution) {
    out.group_directions.extend_from_slice(&groups.directions);
    out.group_direction_counts.extend((0..groups.len()).map(|j| groups.directions_of(j).len() as u32));
}

fn limit_frame(workspace: &Workspace, i: usize) -> Option<LimitFrame> {
    let (tendon, index, upper) = match workspace.contact_source(i)? {
        ContactSource::Point(_) => return None,
        ContactSource::Limit { joint, upper } => (false, joint.0, upper),
        ContactSource::TendonLimit { tendon, upper } => (true, tendon.0, upper),
    };
    let (gap, impulse) = (workspace.problem().gap[i], workspace.contact_impulse(i)[0]);
    let axis = workspace.limit_axis(i).map(|axis| axis.to_array());
    Some(LimitFrame { tendon, index, upper, gap, impulse, axis })
}

fn copy(from: &ContactSolution, to: &mut Impulses) {
    to.velocity.clone_from(&from.velocity);
    to.lambda_n.clone_from(&from.lambda_n);
    to.alpha.clone_from(&from.alpha);
    to.beta.clone_from(&from.beta);
    to.bilateral.clone_from(&from.bilateral);
    to.group_alpha.clone_from(&from.group_alpha);
    to.group_beta.clone_from(&from.group_beta);
}
