//! Joint limits: contacts without friction in the joint's own coordinate (formulation §5).

use signorini_multibody::{Joint, JointKind, Model, State, rotation_log};

use crate::warm::{ContactKey, limit_key};
use signorini_multibody::glam::{DQuat, DVec3};

/// Below this angle the axis of a ball joint's rotation is not taken from the rotation, rad.
const NO_AXIS: f64 = 1e-6;

/// One side of a joint's range.
pub(super) struct Limit {
    pub key: ContactKey,
    /// Distance to the limit, rad or m.
    pub gap: f64,
    /// First degree of freedom of the joint.
    dof: usize,
    /// How the distance changes with the joint's rates.
    slope: [f64; 3],
    count: usize,
}

impl Limit {
    /// The columns of its row.
    pub fn columns(&self) -> impl Iterator<Item = (u32, [f64; 3])> + '_ {
        self.slope[..self.count].iter().enumerate().map(|(a, s)| ((self.dof + a) as u32, [*s, 0.0, 0.0]))
    }

    /// How fast the distance grows at velocity `v`.
    pub fn rate(&self, v: &[f64]) -> f64 {
        self.slope[..self.count].iter().zip(&v[self.dof..]).map(|(s, v)| s * v).sum()
    }
}

/// The limits of all joints, in the order of their keys. A ball joint has one: its rotation by the angle θ about the axis a
/// stays within its cone, `θ_max − θ`, whose rate is `−a·ω`. `v_free` gives the axis where there is no rotation yet.
pub(super) fn limits<'a>(model: &'a Model, state: &'a State, v_free: &'a [f64]) -> impl Iterator<Item = Limit> + 'a {
    let limited = model.joints.iter().enumerate().filter_map(|(j, joint)| Some((j, joint, joint.limits?)));
    limited.flat_map(move |(j, joint, [lower, upper])| {
        let dof = joint.v_index;
        let both = match joint.kind {
            JointKind::Ball => [None, Some(cone(j, joint, upper, state, v_free))],
            _ => {
                let q = state.q[joint.q_index];
                let side = |key, gap, sign: f64| Some(Limit { key, gap, dof, slope: [sign, 0.0, 0.0], count: 1 });
                [side(limit_key(j, 0), q - lower, 1.0), side(limit_key(j, 1), upper - q, -1.0)]
            }
        };
        both.into_iter().flatten()
    })
}

fn cone(j: usize, joint: &Joint, largest: f64, state: &State, v_free: &[f64]) -> Limit {
    let (dof, q) = (joint.v_index, &state.q[joint.q_index..]);
    let turn = rotation_log(DQuat::from_xyzw(q[1], q[2], q[3], q[0]).normalize());
    let angle = turn.length();
    let towards = DVec3::new(v_free[dof], v_free[dof + 1], v_free[dof + 2]).normalize_or(DVec3::X);
    let axis = if angle > NO_AXIS { turn / angle } else { towards };
    Limit { key: limit_key(j, 1), gap: largest - angle, dof, slope: (-axis).to_array(), count: 3 }
}
