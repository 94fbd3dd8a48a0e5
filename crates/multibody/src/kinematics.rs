//! Where every body is and how it moves.
//!
//! All vectors are in world axes. Motions refer to the body's own origin, and a body's origin is reached from its
//! parent's by `offset`, which is never computed as a difference of world positions: what is derived from a
//! [`Kinematics`] is as precise far from the world's origin as near it, and at high speed as at rest.

use glamx::glam::{DMat3, DQuat, DVec3};

use crate::math::{Pose, read_quaternion};
use crate::model::{BodyId, Joint, JointKind, Model};
use crate::standing::{Known, Nothing, StandingTrees};
use crate::state::Input;

/// Poses, velocities, joint axes and velocity-product accelerations at one `(q, v)`.
#[derive(Clone, Debug)]
pub struct Kinematics {
    /// `X_WB` of every body, m.
    pub pose: Vec<Pose>,
    /// Rotation of `X_WB` as a matrix, of every body.
    pub rotation: Vec<DMat3>,
    /// From the parent's origin to the body's, of every body, world axes, m.
    pub offset: Vec<DVec3>,
    /// Centre of mass in world of every body, m.
    pub center_of_mass: Vec<DVec3>,
    /// Angular velocity of every body, world axes, rad/s.
    pub angular_velocity: Vec<DVec3>,
    /// Velocity of every body's origin, world axes, m/s.
    pub linear_velocity: Vec<DVec3>,
    /// Angular velocity of its body per unit of every degree of freedom's rate, world axes.
    pub dof_angular: Vec<DVec3>,
    /// Velocity of its body's origin per unit of every degree of freedom's rate, world axes.
    pub dof_linear: Vec<DVec3>,
    /// Angular acceleration of every body less its parent's, when `v̇ = 0`, world axes, rad/s².
    pub bias_angular: Vec<DVec3>,
    /// Acceleration of every body's origin less what the parent's acceleration gives it, when `v̇ = 0`, world axes, m/s².
    pub bias_linear: Vec<DVec3>,
    /// `X_WB` of the bodies that are moved from outside, `[mocap_bodies]`: read, not written, by [`forward_kinematics_into`].
    pub mocap: Vec<Pose>,
}

impl Kinematics {
    /// Storage for a model: bodies that cannot move are where they stand, every other at the world's origin.
    pub fn new(model: &Model) -> Self {
        let (n, nv) = (model.bodies.len(), model.nv);
        let zeros = vec![DVec3::ZERO; n];
        let mut storage = Self {
            pose: vec![Pose::IDENTITY; n],
            rotation: vec![DMat3::IDENTITY; n],
            offset: zeros.clone(),
            center_of_mass: zeros.clone(),
            angular_velocity: zeros.clone(),
            linear_velocity: zeros.clone(),
            dof_angular: vec![DVec3::ZERO; nv],
            dof_linear: vec![DVec3::ZERO; nv],
            bias_angular: zeros.clone(),
            bias_linear: zeros,
            mocap: model.mocap_bodies.iter().map(|body| model.bodies[body.index()].placement).collect(),
        };
        for i in (1..n).filter(|&i| model.body_weld[i] == BodyId::WORLD) {
            place_body(model, &[], i, &[], &mut storage);
            storage.place_center_of_mass(model, i);
        }
        storage
    }

    fn place_center_of_mass(&mut self, model: &Model, i: usize) {
        self.center_of_mass[i] = self.pose[i].position + self.rotation[i] * model.bodies[i].inertia.center_of_mass;
    }

    /// Takes over where an input has the bodies that are moved from outside: where the model places them if it does not say. The next
    /// [`forward_kinematics_into`] puts them there.
    pub fn place_mocap(&mut self, model: &Model, input: &Input) {
        for (k, (own, body)) in self.mocap.iter_mut().zip(&model.mocap_bodies).enumerate() {
            let pose = input.mocap.get(k).copied().unwrap_or(model.bodies[body.index()].placement);
            *own = Pose::new(pose.position, pose.rotation.normalize());
        }
    }

    /// Velocity of the material point of a body that is at `point` in world, world axes, m/s.
    pub fn point_velocity(&self, body: BodyId, point: DVec3) -> DVec3 {
        let i = body.index();
        self.linear_velocity[i] + self.angular_velocity[i].cross(point - self.pose[i].position)
    }
}

/// Poses and velocities of all bodies.
///
/// Joints move their body in order: each has its anchor and axis in the body frame as the earlier joints of the same body
/// left it; hinges and balls turn about the anchor, which stays where it is.
/// - `q`: configuration, `[nq]`; quaternions are normalised when read
/// - `v`: generalized velocity, `[nv]`
/// - `kinematics`: out
///
/// # Panics
/// If a length does not fit the model ([`State::check`](crate::State::check) reports it as an error).
///
/// # Cost
/// O(bodies + dofs), no allocation.
pub fn forward_kinematics_into(model: &Model, q: &[f64], v: &[f64], kinematics: &mut Kinematics) {
    forward_kinematics_of(model, q, v, Nothing, kinematics);
}

/// [`forward_kinematics_into`] where some trees stand as `kinematics` has them.
///
/// # Panics
/// As there, or if `standing` is of another model.
pub fn forward_kinematics_beside(
    model: &Model,
    q: &[f64],
    v: &[f64],
    standing: &StandingTrees,
    kinematics: &mut Kinematics,
) {
    forward_kinematics_of(model, q, v, standing, kinematics);
}

fn forward_kinematics_of(model: &Model, q: &[f64], v: &[f64], known: impl Known, kinematics: &mut Kinematics) {
    assert_eq!(q.len(), model.nq, "q must have nq entries");
    assert_eq!(v.len(), model.nv, "v must have nv entries");
    assert_eq!(kinematics.pose.len(), model.bodies.len(), "the kinematics belong to another model");
    for i in (1..model.bodies.len()).filter(|&i| !known.has_body(i)) {
        let joints = model.joints_of(BodyId(i as u32));
        if model.path[i].free {
            place_free_body(&joints[0], i, q, kinematics);
            move_free_body(&joints[0], i, v, kinematics);
        } else {
            place_body(model, joints, i, q, kinematics);
            move_body(model, joints, i, v, kinematics);
        }
        kinematics.place_center_of_mass(model, i);
    }
}

/// Velocities of all bodies for a generalized velocity at the configuration of `kinematics`, world axes.
///
/// - `v`: `[nv]`
/// - `angular`: out, angular velocity of every body, rad/s
/// - `linear`: out, velocity of every body's origin, m/s
///
/// # Panics
/// If a length does not fit the model.
///
/// # Cost
/// O(bodies + dofs), no allocation once the outputs have had their size.
pub fn body_velocities_into(
    model: &Model,
    kinematics: &Kinematics,
    v: &[f64],
    angular: &mut Vec<DVec3>,
    linear: &mut Vec<DVec3>,
) {
    assert_eq!(v.len(), model.nv, "v must have nv entries");
    angular.resize(model.bodies.len(), DVec3::ZERO);
    linear.resize(model.bodies.len(), DVec3::ZERO);
    (angular[0], linear[0]) = (DVec3::ZERO, DVec3::ZERO);
    for (i, step) in model.path.iter().enumerate().skip(1) {
        if step.free {
            let v = &v[step.first_dof..step.first_dof + 6];
            linear[i] = DVec3::new(v[0], v[1], v[2]);
            angular[i] = kinematics.rotation[i] * DVec3::new(v[3], v[4], v[5]);
            continue;
        }
        let (mut w, mut u) = (angular[step.parent], linear[step.parent]);
        u += w.cross(kinematics.offset[i]);
        for k in step.first_dof..step.end_dof {
            w += kinematics.dof_angular[k] * v[k];
            u += kinematics.dof_linear[k] * v[k];
        }
        (angular[i], linear[i]) = (w, u);
    }
}

fn place_free_body(joint: &Joint, i: usize, q: &[f64], out: &mut Kinematics) {
    let q = &q[joint.q_index..joint.q_index + 7];
    let position = DVec3::new(q[0], q[1], q[2]);
    let rotation = read_quaternion(&q[3..]);
    let matrix = DMat3::from_quat(rotation);
    out.pose[i] = Pose::new(position, rotation);
    out.rotation[i] = matrix;
    out.offset[i] = position;
    let k = joint.v_index;
    for (a, (axis, column)) in DVec3::AXES.into_iter().zip([matrix.x_axis, matrix.y_axis, matrix.z_axis]).enumerate() {
        (out.dof_angular[k + a], out.dof_linear[k + a]) = (DVec3::ZERO, axis);
        (out.dof_angular[k + 3 + a], out.dof_linear[k + 3 + a]) = (column, DVec3::ZERO);
    }
}

fn move_free_body(joint: &Joint, i: usize, v: &[f64], out: &mut Kinematics) {
    let v = &v[joint.v_index..joint.v_index + 6];
    out.linear_velocity[i] = DVec3::new(v[0], v[1], v[2]);
    out.angular_velocity[i] = out.rotation[i] * DVec3::new(v[3], v[4], v[5]);
    (out.bias_angular[i], out.bias_linear[i]) = (DVec3::ZERO, DVec3::ZERO);
}

fn place_body(model: &Model, joints: &[Joint], i: usize, q: &[f64], out: &mut Kinematics) {
    let (body, parent) = (&model.bodies[i], model.path[i].parent);
    let before = out.pose[parent].rotation;
    let placement = body.mocap.map_or(body.placement, |k| out.mocap[k]);
    let turned = placement.rotation != DQuat::IDENTITY;
    let mut rotation = if turned { before * placement.rotation } else { before };
    let mut offset = out.rotation[parent] * placement.position;
    if let [Joint { kind: JointKind::Hinge { axis }, anchor: DVec3::ZERO, q_index, v_index, reference, .. }] = joints {
        rotation *= DQuat::from_axis_angle(*axis, q[*q_index] - reference);
        let matrix = DMat3::from_quat(rotation);
        (out.dof_angular[*v_index], out.dof_linear[*v_index]) = (matrix * *axis, DVec3::ZERO);
        out.rotation[i] = matrix;
    } else {
        let first_dof = model.path[i].first_dof;
        for joint in joints {
            let step = apply_joint(joint, q, &mut rotation, out);
            // The origin has moved on: the earlier joints of this body now carry it with a longer lever.
            for k in first_dof..joint.v_index {
                out.dof_linear[k] += out.dof_angular[k].cross(step);
            }
            offset += step;
        }
        out.rotation[i] = DMat3::from_quat(rotation);
    }
    out.pose[i] = Pose::new(out.pose[parent].position + offset, rotation);
    out.offset[i] = offset;
}

/// Turns `rotation` by one joint, stores the joint's axes, and returns how far the body's origin moved.
fn apply_joint(joint: &Joint, q: &[f64], rotation: &mut DQuat, out: &mut Kinematics) -> DVec3 {
    let k = joint.v_index;
    let turn = match joint.kind {
        JointKind::Slide { axis } => {
            let axis = *rotation * axis;
            (out.dof_angular[k], out.dof_linear[k]) = (DVec3::ZERO, axis);
            return axis * (q[joint.q_index] - joint.reference);
        }
        JointKind::Hinge { axis } => DQuat::from_axis_angle(axis, q[joint.q_index] - joint.reference),
        JointKind::Ball | JointKind::Free => read_quaternion(&q[joint.q_index..joint.q_index + 4]),
    };
    // Most joints sit at their body's origin, which they then leave where it is.
    let at_origin = joint.anchor == DVec3::ZERO;
    let before = if at_origin { DVec3::ZERO } else { *rotation * joint.anchor };
    *rotation *= turn;
    let after = if at_origin { DVec3::ZERO } else { *rotation * joint.anchor };
    if let JointKind::Hinge { axis } = joint.kind {
        let axis = *rotation * axis;
        (out.dof_angular[k], out.dof_linear[k]) = (axis, after.cross(axis));
    } else {
        for (a, axis) in DVec3::AXES.into_iter().enumerate() {
            let axis = *rotation * axis;
            (out.dof_angular[k + a], out.dof_linear[k + a]) = (axis, after.cross(axis));
        }
    }
    before - after
}

/// Velocities and velocity-product accelerations, joint by joint.
///
/// `u` is the velocity of the body's origin as if the parent's origin were at rest, so that a common velocity of the whole
/// mechanism does not enter the accelerations (Featherstone 2008, ch. 2.11 and 4.4, with classical accelerations).
fn move_body(model: &Model, joints: &[Joint], i: usize, v: &[f64], out: &mut Kinematics) {
    let parent = model.bodies[i].parent.index();
    let mut w = out.angular_velocity[parent];
    let mut u = w.cross(out.offset[i]);
    let (mut bias_angular, mut bias_linear) = (DVec3::ZERO, DVec3::ZERO);
    for joint in joints {
        let (mut joint_w, mut joint_u) = (DVec3::ZERO, DVec3::ZERO);
        for k in joint.v_index..joint.v_index + joint.kind.nv() {
            joint_w += out.dof_angular[k] * v[k];
            joint_u += out.dof_linear[k] * v[k];
        }
        bias_angular += w.cross(joint_w);
        bias_linear += w.cross(joint_u) + u.cross(joint_w);
        w += joint_w;
        u += joint_u;
    }
    out.angular_velocity[i] = w;
    out.linear_velocity[i] = out.linear_velocity[parent] + u;
    out.bias_angular[i] = bias_angular;
    out.bias_linear[i] = bias_linear + w.cross(u);
}
