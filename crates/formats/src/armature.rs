//! Joints that get an armature: those that move no mass, and those that move nothing that other joints do not move, as four slides of one body.

use signorini_multibody::{
    BlockDiagonal, Joint, JointId, JointKind, Kinematics, MassError, MassMatrix, Model, forward_kinematics_into,
    mass_matrix_into,
};

use crate::parts::Parts;
use crate::report::Reporter;

/// What a joint gets that moves nothing of its own, as a part of the inertia that it moves: little against that, much against rounding.
const ARMATURE: f64 = 1e-6;

/// What a joint that moves no mass gets, kg of a prismatic joint and kg·m² of others: little against any link that somebody weighed, much
/// against rounding.
const LEAST: [f64; 2] = [1e-2, 1e-4];

/// So many joints are named in one warning.
const NAMED: usize = 5;

/// Gives joints that move no mass an armature: files have frames that move and weigh nothing, a caster's fork, a sensor on a hinge.
pub(crate) fn arm_massless_joints(parts: &mut Parts, report: &mut Reporter) {
    let [mass, inertia] = LEAST;
    let names = parts.builder.arm_massless_joints(mass, inertia);
    let Some(first) = names.first() else { return };
    let mut what = names.iter().take(NAMED).map(|name| format!("'{name}'")).collect::<Vec<_>>().join(", ");
    match (names.len(), names.len().saturating_sub(NAMED)) {
        (1, _) => what.push_str(" moves no mass"),
        (_, 0) => what.push_str(" move no mass"),
        (_, more) => what.push_str(&format!(" and {more} more move no mass")),
    }
    let effect = format!("armature of {inertia} kg m² ({mass} kg if prismatic): give their links an <inertial>");
    report.motion(parts.joint_place(first), "joint", what, effect);
}

/// Gives joints without which the mass matrix, at the reference configuration, would not be singular an armature, and reports them. Those that
/// move no mass at all stay as they are.
pub(crate) fn arm_dependent_joints(model: &mut Model, parts: &Parts, report: &mut Reporter) {
    for joint in find_and_arm(model) {
        let name = &model.joints[joint.index()].name;
        let what = format!("'{name}' moves nothing that other joints do not move");
        let effect =
            format!("it has an armature of {ARMATURE} times the inertia that it moves: leave it out, or give it one");
        report.motion(parts.joint_place(name), "joint", what, effect);
    }
}

fn find_and_arm(model: &mut Model) -> Vec<JointId> {
    let mut found = Vec::new();
    let mut kinematics = Kinematics::new(model);
    forward_kinematics_into(model, &model.reference_configuration(), &vec![0.0; model.nv], &mut kinematics);
    let mut mass = MassMatrix::new(model);
    mass_matrix_into(model, &kinematics, &mut mass);
    while let Some(dof) = dependent_dof(&mass.matrix) {
        let first = model.dof_joint[dof];
        let joint = if model.joints[first.index()].kind == JointKind::Free {
            beside_free(model, &mass.matrix, dof, &found).unwrap_or(first)
        } else {
            first
        };
        if found.contains(&joint) {
            break;
        }
        let Some(armature) = arm(model, &mut mass.matrix, joint) else { break };
        model.joints[joint.index()].armature += armature;
        found.push(joint);
    }
    found
}

/// A degree of freedom that moves nothing that those factorised before it do not move.
fn dependent_dof(mass: &BlockDiagonal) -> Option<usize> {
    match mass.factor() {
        Err(MassError::NotPositiveDefinite { dof, .. }) => Some(dof),
        _ => None,
    }
}

/// Adds an armature to a joint's degrees of freedom, and returns it; none where the joint moves no mass.
fn arm(model: &Model, mass: &mut BlockDiagonal, joint: JointId) -> Option<f64> {
    let joint = &model.joints[joint.index()];
    let dofs = joint.v_index..joint.v_index + joint.kind.nv();
    let least = dofs.clone().map(|k| mass.get(k, k)).fold(f64::INFINITY, f64::min);
    let armature = ARMATURE * least;
    if !(armature > 0.0 && armature.is_finite()) {
        return None;
    }
    dofs.for_each(|k| mass.add_to_diagonal(k, armature));
    Some(armature)
}

/// The first joint on a free body that turns or slides as the body itself does: bodies keep their inertia as it is.
fn beside_free(model: &Model, mass: &BlockDiagonal, dof: usize, found: &[JointId]) -> Option<JointId> {
    let tree = mass.block_of(dof);
    let own = |joint: &Joint| joint.kind != JointKind::Free && mass.block_of(joint.v_index) == tree;
    let joints = (0..).map(JointId).zip(&model.joints).filter(|(_, joint)| own(joint)).map(|(id, _)| id);
    joints.filter(|id| !found.contains(id)).find(|&id| {
        let mut armed = mass.clone();
        arm(model, &mut armed, id).is_some() && dependent_dof(&armed) != Some(dof)
    })
}
