//! Limits: contacts without friction in the coordinate of a joint or the length of a tendon (formulation §5).

use signorini_multibody::glam::{DQuat, DVec3};
use signorini_multibody::{
    Joint, JointKind, Kinematics, Model, State, right_jacobian, rotation_log, tendon_length_into,
};

use super::builder::ProblemBuilder;
use crate::source::LimitRow;
use crate::warm::{ContactKey, joint_limit_key, tendon_limit_key};

/// Below this angle the axis of a ball joint's rotation is not taken from the rotation, rad.
const NO_AXIS: f64 = 1e-6;

/// Cosine of the angle up to which two axes of a ball joint's limit are one: between them its cone is wider than the planes that touch it by a
/// twentieth of its angle.
const SAME_AXIS: f64 = 0.95;

impl ProblemBuilder {
    /// Limits that the step cannot reach are left out by the same margin as contact points; see
    /// [`add_crossed_limits`](Self::add_crossed_limits).
    pub(super) fn push_limits(&mut self, model: &Model, kinematics: &Kinematics, state: &State) {
        let dt = self.problem.timestep;
        let v_free = std::mem::take(&mut self.problem.free_velocity);
        let of_ball = |j, joint: &Joint| cone(j, joint, state, &v_free);
        for_each_limit(model, state, of_ball, |limit| {
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

    /// Adds the limits that `v` would cross in this step although they are not in the problem; whether there were any. The cone of a ball joint
    /// is in it along the axes of its rows, and gets another one where the step ends about none of them: of such axes there are few on a sphere.
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
        let of_ball = |j, joint: &Joint| cone_ahead(j, joint, state, v, dt);
        for_each_limit(model, state, of_ball, |limit| {
            let is_wanted = wanted(&limit.key, limit.gap + dt * limit.rate(v)) && !self.stands[limit.dof];
            if is_wanted && !self.has_row(limit.key, limit.axis) {
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
        let of_ball = |j, joint: &Joint| cone_ahead(j, joint, state, v, dt);
        for_each_limit(model, state, of_ball, |limit| {
            if !self.stands[limit.dof] && !self.has_row(limit.key, limit.axis) {
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

    /// Whether the limit of a ball joint is in the problem about nearly this axis.
    pub fn has_cone(&self, joint: usize, axis: DVec3) -> bool {
        self.has_row(joint_limit_key(joint, 1), axis)
    }

    /// Adds the limit of a ball joint about this axis, of unit length; whether the joint has one.
    pub fn add_cone(&mut self, model: &Model, state: &State, joint: usize, axis: DVec3) -> bool {
        let ball = model.joints.get(joint).filter(|ball| ball.kind == JointKind::Ball);
        let Some((ball, [_, largest])) = ball.and_then(|ball| Some((ball, ball.limits?))) else { return false };
        self.push_limit(model, state, &cone_about(joint, ball, largest, turn_of(ball, state), axis));
        true
    }

    /// Whether a limit is in the problem: that of a ball joint about nearly the same axis.
    fn has_row(&self, limit: ContactKey, axis: DVec3) -> bool {
        self.rows_of(limit).any(|row| row.axis == axis || row.axis.dot(axis) >= SAME_AXIS)
    }

    /// The rows that the limit with this key, or the first of its keys, has in the problem.
    fn rows_of(&self, limit: ContactKey) -> impl Iterator<Item = &LimitRow> {
        let first = self.keys.len() - self.limits.len();
        let is_same = move |key: &ContactKey| key[..2] == limit[..2] && key[2] % 2 == limit[2] % 2;
        self.keys[first..].iter().zip(&self.limits).filter(move |(key, _)| is_same(key)).map(|(_, row)| row)
    }

    fn push_limit(&mut self, model: &Model, state: &State, limit: &Limit) {
        let [kind, joint, side] = limit.key;
        let earlier = self.rows_of(limit.key).count() as u32;
        let gap = self.pace.joint_limit(model, state, limit.joint, limit.gap, self.problem.timestep);
        self.problem.push_contact(limit.columns(), gap, 0.0, &self.frictionless);
        self.keys.push([kind, joint, side + 2 * earlier]);
        self.limits.push(LimitRow { distance: limit.gap, axis: limit.axis });
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
        let paced = self.pace.tendon_limit(gap, self.problem.timestep, || model.tendons[t].swing(model, kinematics));
        self.problem.push_contact(columns, paced, 0.0, &self.frictionless);
        self.keys.push(tendon_limit_key(t, side as u32));
        self.limits.push(LimitRow { distance: gap, axis: DVec3::ZERO });
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
    /// Axis of the cone of a ball joint; zero for others.
    axis: DVec3,
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

/// Visits the limits of all joints, in the order of their keys. A ball joint has one, which `of_ball` gives.
fn for_each_limit(
    model: &Model,
    state: &State,
    of_ball: impl Fn(usize, &Joint) -> Option<Limit>,
    mut visit: impl FnMut(&Limit),
) {
    for (j, joint) in model.joints.iter().enumerate() {
        if joint.kind == JointKind::Ball {
            of_ball(j, joint).iter().for_each(&mut visit);
            continue;
        }
        let Some([lower, upper]) = joint.limits else { continue };
        let q = state.q[joint.q_index];
        for (side, gap, sign) in [(0, q - lower, 1.0), (1, upper - q, -1.0)] {
            let (key, slope) = (joint_limit_key(j, side), [sign, 0.0, 0.0]);
            visit(&Limit { key, joint: j, gap, dof: joint.v_index, slope, count: 1, axis: DVec3::ZERO });
        }
    }
}

/// The limit of a ball joint at the beginning of a step: its rotation by the angle θ about the axis a stays within its cone, `θ_max − θ`, whose
/// rate is `−a·ω`. `v_free` gives the axis where there is no rotation yet.
fn cone(j: usize, joint: &Joint, state: &State, v_free: &[f64]) -> Option<Limit> {
    let [_, largest] = joint.limits?;
    let turn = turn_of(joint, state);
    let angle = turn.length();
    let axis = if angle > NO_AXIS { turn / angle } else { rate_of(joint, v_free).normalize_or(DVec3::X) };
    let slope = (-axis).to_array();
    Some(Limit {
        key: joint_limit_key(j, 1),
        joint: j,
        gap: largest - angle,
        dof: joint.v_index,
        slope,
        count: 3,
        axis,
    })
}

/// The limit of a ball joint about the axis of the rotation that `v` leads to.
fn cone_ahead(j: usize, joint: &Joint, state: &State, v: &[f64], dt: f64) -> Option<Limit> {
    let [_, largest] = joint.limits?;
    let turn = turn_of(joint, state);
    let end = turn + right_jacobian(turn).inverse() * rate_of(joint, v) * dt;
    let axis = if end.length() > NO_AXIS { end.normalize() } else { rate_of(joint, v).normalize_or(DVec3::X) };
    Some(cone_about(j, joint, largest, turn, axis))
}

/// The limit of a ball joint along an axis a of unit length: of its rotation vector ψ, which stays in the ball of radius θ_max, `θ_max − a·ψ`, whose
/// rate is `−a·ψ̇` with `ψ̇ = J_r(ψ)⁻¹ ω`.
fn cone_about(j: usize, joint: &Joint, largest: f64, turn: DVec3, axis: DVec3) -> Limit {
    let slope = (-(right_jacobian(turn).inverse().transpose() * axis)).to_array();
    let (key, gap) = (joint_limit_key(j, 1), largest - axis.dot(turn));
    Limit { key, joint: j, gap, dof: joint.v_index, slope, count: 3, axis }
}

/// The rotation vector of a ball joint.
fn turn_of(joint: &Joint, state: &State) -> DVec3 {
    let q = &state.q[joint.q_index..];
    rotation_log(DQuat::from_xyzw(q[1], q[2], q[3], q[0]).normalize())
}

/// The rate of a ball joint.
fn rate_of(joint: &Joint, v: &[f64]) -> DVec3 {
    DVec3::from_slice(&v[joint.v_index..])
}

/// Tendons with limits, by index.
fn limited_tendons(model: &Model) -> impl Iterator<Item = (usize, [f64; 2])> + '_ {
    model.tendons.iter().enumerate().filter_map(|(t, tendon)| Some((t, tendon.limits?)))
}

/// For the lower and the upper limit of a length: the distance to it, and how that changes with the rate.
fn gaps(length: f64, [lower, upper]: [f64; 2]) -> [(f64, f64); 2] {
    [(length - lower, 1.0), (upper - length, -1.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Slopes of the limit of a ball joint are differences of its distance, and its axis is that of the rotation at the end of the step, whatever rotates
    /// about what.
    #[test]
    fn cones_change_as_rotations_do() {
        let joint = Joint::ball("ball").with_limits([0.0, 2.0]);
        let exp = DQuat::from_scaled_axis;
        let state_of = |q: DQuat| State::at(vec![q.w, q.x, q.y, q.z], vec![0.0; 3]);
        for k in 0..20 {
            let vector = |seed: f64| DVec3::from([1.3, 2.1, 3.7].map(|a: f64| (a * (f64::from(k) + seed)).sin()));
            let (turn, axis, rate) = (vector(0.1), vector(0.5).normalize(), vector(0.9));
            let state = state_of(exp(turn));
            let distance = |omega: DVec3| 2.0 - axis.dot(rotation_log(exp(turn) * exp(omega)));
            let limit = cone_about(0, &joint, 2.0, turn_of(&joint, &state), axis);
            assert!((limit.gap - distance(DVec3::ZERO)).abs() < 1e-12);
            for (found, unit) in limit.slope.into_iter().zip(DVec3::AXES) {
                let wanted = (distance(1e-6 * unit) - distance(-1e-6 * unit)) / 2e-6;
                assert!((found - wanted).abs() < 1e-8, "{found}, not {wanted}");
            }
            let v = rate.to_array();
            let ahead = cone_ahead(0, &joint, &state, &v, 1e-4).map(|limit| limit.axis);
            let wanted = rotation_log(exp(turn) * exp(1e-4 * rate)).normalize();
            assert!(ahead.is_some_and(|axis| (axis - wanted).length() < 1e-7), "{ahead:?}, not {wanted}");
            let now = cone(0, &joint, &state, &v).map(|limit| (limit.gap, DVec3::from(limit.slope)));
            let (gap, slope) = (2.0 - turn.length(), -turn.normalize());
            assert!(now.is_some_and(|(g, s)| (g - gap).abs() < 1e-12 && (s - slope).length() < 1e-12), "{now:?}");
        }
    }
}
