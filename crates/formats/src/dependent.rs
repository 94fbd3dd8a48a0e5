//! Joints that move nothing that other joints do not move: four slides of one body.

use signorini_multibody::{
    JointId, Kinematics, MassError, MassMatrix, Model, forward_kinematics_into, mass_matrix_into,
};

use crate::parts::Parts;
use crate::report::Reporter;

/// What such a joint gets as armature, as a part of the inertia that it moves: little against that, much against rounding.
const ARMATURE: f64 = 1e-6;

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
    while let Err(MassError::NotPositiveDefinite { dof, .. }) = mass.matrix.factor() {
        let armature = ARMATURE * mass.matrix.get(dof, dof);
        let joint = model.dof_joint[dof];
        if !(armature > 0.0 && armature.is_finite()) || found.contains(&joint) {
            break;
        }
        let of_joint = &mut model.joints[joint.index()];
        of_joint.armature += armature;
        (0..of_joint.kind.nv()).for_each(|k| mass.matrix.add_to_diagonal(of_joint.v_index + k, armature));
        found.push(joint);
    }
    found
}
