//! Limits: contacts without friction in the coordinate of a joint or the length of a tendon (formulation §5).

use signorini_multibody::glam::{DQuat, DVec3};
use signorini_multibody::{Joint, JointKind, Kinematics, Model, State, rotation_log, tendon_length_into};

use super::builder::ProblemBuilder;
use crate::warm::{ContactKey, joint_limit_key, tendon_limit_key};

/// Below this angle the axis of a ball joint's rotation is not taken from the rotation, rad.
const NO_AXIS: f64 = 1e-6;

impl ProblemBuilder {
    /// Limits that the step cannot reach are left out by the same margin as contact points; see
    /// [`add_crossed_limits`](Self::add_crossed_limits).
    pub(super) fn push_limits(&mut self, model: &Model, kinematics: &Kinematics, state: &State) {
        let dt = self.problem.timestep;
        let v_free = std::mem::take(&mut self.problem.free_velocity);
        for_each_limit(model, state, &v_free, |limit| {
            let reach = 4.0 * dt * limit.rate(&state.v).abs().max(limit.rate(&v_free).abs());
            if limit.gap <= reach && !self.stands[limit.dof] {
                self.push_limit(model, state, limit);
            }
        });
        for (t, limits) in limited_tendons(model) {
            if !self.measure_tendon(model, kinematics, state, t) {
                continue;
            }
            let reach = 4.0 * dt * self.length.rate(&state.v).abs().max(self.length.rate(&v_free).abs());
            for (side, (gap, _)) in gaps(self.length.length, limits).into_iter().enumerate() {
                if gap <= reach {
                    self.push_tendon_limit((model, kinematics), t, side, gap);
                }
            }
        }
        self.problem.free_velocity = v_free;
    }

    /// Adds the limits that `v` would cross in this step although they are not in the problem; whether there were any.
    pub fn add_crossed_limits(&mut self, model: &Model, kinematics: &Kinematics, state: &State, v: &[f64]) -> bool {
        self.add_limits(model, kinematics, state, v, |_, end| end < 0.0)
    }

    /// Adds the limits that are wanted and not in the problem; whether there were any.
    ///
    /// - `v`: velocity at the end of the step
    /// - `wanted`: told the key of a limit and the distance to it at the end of the step
    pub fn add_limits(
        &mut self,
        model: &Model,
        kinematics: &Kinematics,
        state: &State,
        v: &[f64],
        wanted: impl Fn(&ContactKey, f64) -> bool,
    ) -> bool {
        let dt = self.problem.timestep;
        let before = self.keys.len();
        for_each_limit(model, state, v, |limit| {
            let is_wanted = wanted(&limit.key, limit.gap + dt * limit.rate(v)) && !self.stands[limit.dof];
            if is_wanted && !self.keys.contains(&limit.key) {
                self.push_limit(model, state, limit);
            }
        });
        for (t, limits) in limited_tendons(model) {
            if !self.measure_tendon(model, kinematics, state, t) {
                continue;
            }
            let rate = self.length.rate(v);
            for (side, (gap, sign)) in gaps(self.length.length, limits).into_iter().enumerate() {
                let key = tendon_limit_key(t, side as u32);
                if wanted(&key, gap + sign * dt * rate) && !self.keys.contains(&key) {
                    self.push_tendon_limit((model, kinematics), t, side, gap);
                }
            }
        }
        self.keys.len() > before
    }

    /// Visits the limits that are not in the problem: their keys, and the distances to them at the end of the step, rad or m.
    pub fn visit_others(
        &mut self,
        model: &Model,
        kinematics: &Kinematics,
        state: &State,
        v: &[f64],
        mut visit: impl FnMut(&ContactKey, f64),
    ) {
        let dt = self.problem.timestep;
        for_each_limit(model, state, v, |limit| {
            if !self.stands[limit.dof] && !self.keys.contains(&limit.key) {
                visit(&limit.key, limit.gap + dt * limit.rate(v));
            }
        });
        for (t, limits) in limited_tendons(model) {
            if !self.measure_tendon(model, kinematics, state, t) {
                continue;
            }
            let rate = self.length.rate(v);
            for (side, (gap, sign)) in gaps(self.length.length, limits).into_iter().enumerate() {
                let key = tendon_limit_key(t, side as u32);
                if !self.keys.contains(&key) {
                    visit(&key, gap + sign * dt * rate);
                }
            }
        }
    }

    fn push_limit(&mut self, model: &Model, state: &State, limit: &Limit) {
        let gap = self.pace.joint_limit(model, state, limit.joint, limit.gap, self.problem.timestep);
        self.problem.push_contact(limit.columns(), gap, 0.0, &self.frictionless);
        self.keys.push(limit.key);
    }

    /// Measures a tendon; whether it moves anything that does not stand. One between places of one rigid body has its length for ever.
    fn measure_tendon(&mut self, model: &Model, kinematics: &Kinematics, state: &State, t: usize) -> bool {
        tendon_length_into(model, kinematics, &state.q, &model.tendons[t], &mut self.length);
        self.length.dofs.iter().any(|&dof| !self.stands[dof])
    }

    /// Adds the lower (`side` 0) or upper (1) limit of the tendon that was measured last.
    fn push_tendon_limit(&mut self, (model, kinematics): (&Model, &Kinematics), t: usize, side: usize, gap: f64) {
        let sign = if side == 0 { 1.0 } else { -1.0 };
        let columns = self.length.dofs.iter().zip(&self.length.gradient);
        let columns = columns.map(|(&k, &g)| (k as u32, [sign * g, 0.0, 0.0]));
        let gap = self.pace.tendon_limit(gap, self.problem.timestep, || model.tendons[t].swing(model, kinematics));
        self.problem.push_contact(columns, gap, 0.0, &self.frictionless);
        self.keys.push(tendon_limit_key(t, side as u32));
    }
}

/// One side of a joint's range.
struct Limit {
    key: ContactKey,
    /// Index of the joint.
    joint: usize,
    /// Distance to the limit, rad or m.
    gap: f64,
    /// First degree of freedom of the joint.
    dof: usize,
    /// How the distance changes with the joint's rates.
    slope: [f64; 3],
    count: usize,
}

impl Limit {
    /// The columns of its row.
    fn columns(&self) -> impl Iterator<Item = (u32, [f64; 3])> + '_ {
        self.slope[..self.count].iter().enumerate().map(|(a, s)| ((self.dof + a) as u32, [*s, 0.0, 0.0]))
    }

    /// How fast the distance grows at velocity `v`.
    fn rate(&self, v: &[f64]) -> f64 {
        self.slope[..self.count].iter().zip(&v[self.dof..]).map(|(s, v)| s * v).sum()
    }
}

/// Visits the limits of all joints, in the order of their keys. A ball joint has one: its rotation by the angle θ about the axis a
/// stays within its cone, `θ_max − θ`, whose rate is `−a·ω`. `v_free` gives the axis where there is no rotation yet.
fn for_each_limit(model: &Model, state: &State, v_free: &[f64], mut visit: impl FnMut(&Limit)) {
    for (j, joint) in model.joints.iter().enumerate() {
        let Some([lower, upper]) = joint.limits else { continue };
        if joint.kind == JointKind::Ball {
            visit(&cone(j, joint, upper, state, v_free));
            continue;
        }
        let q = state.q[joint.q_index];
        for (side, gap, sign) in [(0, q - lower, 1.0), (1, upper - q, -1.0)] {
            let (key, slope) = (joint_limit_key(j, side), [sign, 0.0, 0.0]);
            visit(&Limit { key, joint: j, gap, dof: joint.v_index, slope, count: 1 });
        }
    }
}

fn cone(j: usize, joint: &Joint, largest: f64, state: &State, v_free: &[f64]) -> Limit {
    let (dof, q) = (joint.v_index, &state.q[joint.q_index..]);
    let turn = rotation_log(DQuat::from_xyzw(q[1], q[2], q[3], q[0]).normalize());
    let angle = turn.length();
    let towards = DVec3::new(v_free[dof], v_free[dof + 1], v_free[dof + 2]).normalize_or(DVec3::X);
    let axis = if angle > NO_AXIS { turn / angle } else { towards };
    let slope = (-axis).to_array();
    Limit { key: joint_limit_key(j, 1), joint: j, gap: largest - angle, dof, slope, count: 3 }
}

/// Tendons with limits, by index.
fn limited_tendons(model: &Model) -> impl Iterator<Item = (usize, [f64; 2])> + '_ {
    model.tendons.iter().enumerate().filter_map(|(t, tendon)| Some((t, tendon.limits?)))
}

/// For the lower and the upper limit of a length: the distance to it, and how that changes with the rate.
fn gaps(length: f64, [lower, upper]: [f64; 2]) -> [(f64, f64); 2] {
    [(length - lower, 1.0), (upper - length, -1.0)]
}
