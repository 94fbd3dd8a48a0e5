//! What algorithms that go along the paths of a tree need of a body, in one place.

use super::{Body, BodyId, Joint, JointKind};
use crate::math::Pose;

/// A body on the way to the root.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PathStep {
    /// Its parent.
    pub parent: usize,
    /// The nearest ancestor with joints of its own; the world if there is none.
    pub above: usize,
    /// First of the degrees of freedom of its own joints.
    pub first_dof: usize,
    /// One after the last of them.
    pub end_dof: usize,
    /// Whether its joint is a free one.
    pub free: bool,
}

impl PathStep {
    /// Those of all bodies.
    pub fn all(bodies: &[Body], joints: &[Joint]) -> Vec<Self> {
        let mut steps: Vec<Self> = Vec::with_capacity(bodies.len());
        for body in bodies {
            let own = &joints[body.first_joint..body.first_joint + body.joint_count];
            let parent = body.parent.index();
            let above = match steps.get(parent) {
                Some(step) if step.first_dof == step.end_dof => step.above,
                Some(_) => parent,
                None => 0,
            };
            let first_dof = own.first().map_or(0, |joint| joint.v_index);
            let end_dof = own.last().map_or(0, |joint| joint.v_index + joint.kind.nv());
            let free = matches!(own, [joint] if joint.kind == JointKind::Free);
            steps.push(Self { parent, above, first_dof, end_dof, free });
        }
        steps
    }
}

/// `X_WB` of a body at the reference configuration, where every body is at its placement.
pub(super) fn reference_pose(bodies: &[Body], body: BodyId) -> Pose {
    let (mut pose, mut id) = (Pose::IDENTITY, body);
    while id != BodyId::WORLD {
        let body = &bodies[id.index()];
        (pose, id) = (body.placement * pose, body.parent);
    }
    pose
}
