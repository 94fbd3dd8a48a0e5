//! What is not in a step's problem and all but in it: points that almost touch at the end of the step, and limits that are almost reached.

use signorini_multibody::ContactPoint;
use signorini_simulation::ContactSource;

use super::system::Step;
use crate::validity::{InequalityKind, InequalitySource, Margin};

/// Margins larger than this are not told.
const CLOSE: f64 = 1e-3;

pub(super) fn note_others(step: &mut Step, margins: &mut Vec<Margin>) {
    note_points(step, margins);
    note_limits(step, margins);
}

fn note_points(step: &Step, margins: &mut Vec<Margin>) {
    let problem = step.workspace.problem();
    let in_problem = step.workspace.contact_points();
    for point in step.workspace.candidate_points() {
        let relative =
            step.end.velocity(point.body_b, point.position) - step.end.velocity(point.body_a, point.position);
        let value = step.scales.velocity(point.gap / problem.timestep + point.normal.dot(relative.linear));
        let is_same = |other: &ContactPoint| {
            (other.geom_a, other.geom_b, other.feature) == (point.geom_a, point.geom_b, point.feature)
        };
        if value < CLOSE && !in_problem.iter().any(is_same) {
            let source = InequalitySource::Candidate([point.geom_a, point.geom_b]);
            margins.push(Margin { source, kind: InequalityKind::Gap, value });
        }
    }
}

/// A limit that nothing moves towards is not in the problem, even where the joint stands at it.
fn note_limits(step: &mut Step, margins: &mut Vec<Margin>) {
    let (dt, scales) = (step.workspace.problem().timestep, step.scales);
    step.workspace.visit_other_limits(step.model, step.state, |limit, distance| {
        let value = scales.velocity(distance / dt);
        let source = match limit {
            ContactSource::Limit { joint, .. } => InequalitySource::JointLimit(joint),
            ContactSource::TendonLimit { tendon, .. } => InequalitySource::TendonLimit(tendon),
            ContactSource::Point(_) => return,
        };
        if value < CLOSE {
            margins.push(Margin { source, kind: InequalityKind::Gap, value });
        }
    });
}
