//! Lengths of tendons: combinations of joint coordinates, and paths along sites and around geoms.

use glamx::glam::DVec3;

use crate::frame::{Frame, ReferenceFrame, frame_bias_acceleration};
use crate::kinematics::Kinematics;
use crate::length::LengthRow;
use crate::math::Pose;
use crate::model::{BodyId, Model, Tendon, walk};

/// Length of a tendon with its row.
///
/// - `kinematics`: from [`forward_kinematics_into`](crate::forward_kinematics_into) at `q`
/// - `q`: `[nq]`
///
/// # Source
/// MuJoCo's tendons. What lies on a geom moves along it at right angles to what the string could gain, so that only the straight parts
/// of the path are in the row.
pub fn tendon_length_into(model: &Model, kinematics: &Kinematics, q: &[f64], tendon: &Tendon, out: &mut LengthRow) {
    out.clear();
    for &(joint, coefficient) in &tendon.terms {
        out.add(model.joints[joint.index()].v_index, coefficient);
    }
    out.length = joint_part(model, q, tendon)
        + walk(
            model,
            |body| kinematics.pose[body.index()],
            &tendon.path,
            |segment| {
                let [from, to] = segment.ends;
                if from.0 != to.0 {
                    out.add_force(model, kinematics, to, [segment.direction() * segment.weight, DVec3::ZERO], from);
                }
            },
        );
}

impl Tendon {
    /// Its length at a configuration, m (rad where it combines angles).
    ///
    /// - `kinematics`: from [`forward_kinematics_into`](crate::forward_kinematics_into) at `q`
    /// - `q`: `[nq]`
    pub fn length(&self, model: &Model, kinematics: &Kinematics, q: &[f64]) -> f64 {
        joint_part(model, q, self) + walk(model, |body| kinematics.pose[body.index()], &self.path, |_| {})
    }

    /// The rate of its length, m/s.
    ///
    /// - `kinematics`: from [`forward_kinematics_into`](crate::forward_kinematics_into) at the state
    /// - `v`: `[nv]`
    pub fn rate(&self, model: &Model, kinematics: &Kinematics, v: &[f64]) -> f64 {
        let mut rate = self.terms.iter().map(|&(joint, c)| c * v[model.joints[joint.index()].v_index]).sum();
        walk(
            model,
            |body| kinematics.pose[body.index()],
            &self.path,
            |segment| {
                let [a, b] = segment.ends.map(|(body, point)| kinematics.point_velocity(body, point));
                rate += segment.weight * segment.direction().dot(b - a);
            },
        );
        rate
    }

    /// What a unit force along its length does to bodies: visits each force, N, in world, with the body and the point, m, where it acts. Terms
    /// of joints are not in it.
    ///
    /// - `kinematics`: from [`forward_kinematics_into`](crate::forward_kinematics_into)
    pub fn visit_forces(&self, model: &Model, kinematics: &Kinematics, mut visit: impl FnMut(BodyId, DVec3, DVec3)) {
        walk(
            model,
            |body| kinematics.pose[body.index()],
            &self.path,
            |segment| {
                let ([from, to], force) = (segment.ends, segment.direction() * segment.weight);
                visit(from.0, from.1, -force);
                visit(to.0, to.1, force);
            },
        );
    }

    /// A bound of the second derivative of its length when `v̇ = 0`, m/s².
    ///
    /// - `kinematics`: from [`forward_kinematics_into`](crate::forward_kinematics_into) at the state
    pub fn swing(&self, model: &Model, kinematics: &Kinematics) -> f64 {
        let mut bound = 0.0;
        walk(
            model,
            |body| kinematics.pose[body.index()],
            &self.path,
            |segment| {
                let acceleration = |(body, point): (BodyId, DVec3)| {
                    let placement = Pose::from_position(kinematics.pose[body.index()].inverse().transform_point(point));
                    let frame = Frame { body, placement };
                    frame_bias_acceleration(model, kinematics, &frame, ReferenceFrame::LocalWorldAligned).linear
                };
                let velocity = |(body, point)| kinematics.point_velocity(body, point);
                let [a, b] = segment.ends;
                let turning = (velocity(b) - velocity(a)).length_squared() / segment.way().length();
                let turning = if turning.is_nan() { 0.0 } else { turning };
                bound += segment.weight * ((acceleration(b) - acceleration(a)).length() + turning);
            },
        );
        bound
    }
}

fn joint_part(model: &Model, q: &[f64], tendon: &Tendon) -> f64 {
    tendon.terms.iter().map(|&(joint, c)| c * q[model.joints[joint.index()].q_index]).sum()
}
