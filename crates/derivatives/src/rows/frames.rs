//! What a contact's rows are along, and which friction groups are its own.

use signorini_contact::ContactFrame;
use signorini_multibody::glam::DVec3;
use signorini_simulation::FrictionSource;

use super::system::Step;

/// How the axes of [`ContactFrame::from_normal`] turn with the normal.
pub(super) fn turned_axes(frame: &ContactFrame, change: DVec3) -> [DVec3; 3] {
    let n = frame.normal;
    let reference = if n.x.abs() < 0.9 { DVec3::X } else { DVec3::Y };
    let raw = reference - n * reference.dot(n);
    let raw_change = -(change * reference.dot(n) + n * reference.dot(change));
    let t_1 = frame.tangent_1;
    let first = (raw_change - t_1 * t_1.dot(raw_change)) / raw.length();
    [change, first, change.cross(t_1) + n.cross(first)]
}

/// The friction groups that belong to contact `i`, with their first row among the axes.
pub(super) fn groups_of(step: &Step, i: usize) -> impl Iterator<Item = (usize, FrictionSource)> {
    let problem = step.workspace.problem();
    let groups = 0..problem.friction_groups.len();
    let sources = groups.filter_map(|j| step.workspace.friction_source(j).map(|source| (j, source)));
    sources.filter(move |(_, source)| match *source {
        FrictionSource::Belt { contact }
        | FrictionSource::Spinning { contact }
        | FrictionSource::Rolling { contact } => contact == i,
        FrictionSource::Joint { .. } | FrictionSource::Servo { .. } => false,
    })
}
