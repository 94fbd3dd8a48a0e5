//! Contact points and limits of joints and tendons become a contact problem.

use signorini_contact::{ContactFrame, ContactProblem, FrictionPolygon};
use signorini_multibody::{
    ContactPoint, FreeMotion, Kinematics, LengthRow, Model, SparseRows, State, contact_rows_into, tendon_length_into,
};

use crate::warm::{ContactKey, joint_limit_key, point_key, tendon_limit_key};

/// The contact problem of a step with what belongs to it, and the storage to build it.
#[derive(Clone, Debug)]
pub(crate) struct ProblemBuilder {
    pub problem: ContactProblem,
    /// Frames of the contact points, in order; limits come after them and have none.
    pub frames: Vec<ContactFrame>,
    /// Identity of every contact of the problem, ascending.
    pub keys: Vec<ContactKey>,
    rows: SparseRows,
    tendon: LengthRow,
    polygon: FrictionPolygon,
    frictionless: FrictionPolygon,
    stabilization: f64,
}

impl ProblemBuilder {
    pub fn new(model: &Model, problem: ContactProblem, polygon: FrictionPolygon, stabilization: f64) -> Self {
        Self {
            problem,
            frames: Vec::new(),
            keys: Vec::new(),
            rows: SparseRows::new(model),
            tendon: LengthRow::new(model),
            polygon,
            frictionless: FrictionPolygon::frictionless(),
            stabilization,
        }
    }

    /// Takes mass matrix, factor and free velocity from `smooth`, which gets the storage of the last step in exchange.
    pub fn take_smooth(&mut self, smooth: &mut FreeMotion, dt: f64) {
        std::mem::swap(&mut self.problem.mass, &mut smooth.mass.matrix);
        std::mem::swap(&mut self.problem.mass_factor, &mut smooth.factor);
        self.problem.free_velocity.copy_from_slice(&smooth.free_velocity);
        self.problem.timestep = dt;
    }

    /// Fills in the contacts: the points in their order, then the limits that can be reached.
    pub fn build(&mut self, model: &Model, state: &State, kinematics: &Kinematics, points: &[ContactPoint]) {
        self.problem.clear_contacts();
        self.frames.clear();
        self.keys.clear();
        for point in points {
            self.push_point(model, kinematics, point);
        }
        self.push_limits(model, state);
    }

    fn push_point(&mut self, model: &Model, kinematics: &Kinematics, point: &ContactPoint) {
        let frame = ContactFrame::from_normal(point.normal);
        let directions = [frame.normal, frame.tangent_1, frame.tangent_2];
        contact_rows_into(model, kinematics, (point.body_a, point.body_b), point.position, &directions, &mut self.rows);
        let columns = self.rows.dofs.iter().map(|&k| k as u32).zip(self.rows.columns.iter().copied());
        let polygon = if point.friction > 0.0 { &self.polygon } else { &self.frictionless };
        self.problem.push_contact(columns, stabilized(point.gap, self.stabilization), point.friction, polygon);
        self.frames.push(frame);
        self.keys.push(point_key(point));
    }

    /// Limits are contacts without friction in the coordinate of a joint or the length of a tendon (formulation §5). Those that the step
    /// cannot reach are left out by the same margin as contact points; see [`add_crossed_limits`](Self::add_crossed_limits).
    fn push_limits(&mut self, model: &Model, state: &State) {
        let dt = self.problem.timestep;
        for limit in limits(model, state) {
            let reach = 4.0 * dt * state.v[limit.dof].abs().max(self.problem.free_velocity[limit.dof].abs());
            if limit.gap <= reach {
                self.push_limit(&limit);
            }
        }
        for (t, limits) in limited_tendons(model) {
            self.measure_tendon(model, state, t);
            let (now, free) = (self.tendon.rate(&state.v), self.tendon.rate(&self.problem.free_velocity));
            let reach = 4.0 * dt * now.abs().max(free.abs());
            for (side, (gap, _)) in gaps(self.tendon.length, limits).into_iter().enumerate() {
                if gap <= reach {
                    self.push_tendon_limit(t, side, gap);
                }
            }
        }
    }

    /// Adds the limits that `v` would cross in this step although they are not in the problem; whether there were any.
    pub fn add_crossed_limits(&mut self, model: &Model, state: &State, v: &[f64]) -> bool {
        let dt = self.problem.timestep;
        let before = self.keys.len();
        for limit in limits(model, state) {
            let crosses = limit.gap + limit.sign * dt * v[limit.dof] < 0.0;
            if crosses && !self.keys.contains(&limit.key) {
                self.push_limit(&limit);
            }
        }
        for (t, limits) in limited_tendons(model) {
            self.measure_tendon(model, state, t);
            let rate = self.tendon.rate(v);
            for (side, (gap, sign)) in gaps(self.tendon.length, limits).into_iter().enumerate() {
                let crosses = gap + sign * dt * rate < 0.0;
                if crosses && !self.keys.contains(&tendon_limit_key(t, side as u32)) {
                    self.push_tendon_limit(t, side, gap);
                }
            }
        }
        self.keys.len() > before
    }

    fn measure_tendon(&mut self, model: &Model, state: &State, t: usize) {
        tendon_length_into(model, &state.q, &model.tendons[t], &mut self.tendon);
    }

    /// Adds the lower (`side` 0) or upper (1) limit of the tendon that was measured last.
    fn push_tendon_limit(&mut self, t: usize, side: usize, gap: f64) {
        let sign = if side == 0 { 1.0 } else { -1.0 };
        let columns = self.tendon.dofs.iter().zip(&self.tendon.gradient);
        let columns = columns.map(|(&k, &g)| (k as u32, [sign * g, 0.0, 0.0]));
        self.problem.push_contact(columns, stabilized(gap, self.stabilization), 0.0, &self.frictionless);
        self.keys.push(tendon_limit_key(t, side as u32));
    }

    fn push_limit(&mut self, limit: &Limit) {
        let column = [(limit.dof as u32, [limit.sign, 0.0, 0.0])];
        self.problem.push_contact(column, stabilized(limit.gap, self.stabilization), 0.0, &self.frictionless);
        self.keys.push(limit.key);
    }

    /// Takes negative gaps as zero; whether there were any.
    pub fn clip_gaps(&mut self) -> bool {
        let negative = self.problem.gap.iter().any(|&phi| phi < 0.0);
        self.problem.gap.iter_mut().for_each(|phi| *phi = phi.max(0.0));
        negative
    }
}

/// One side of a joint's range.
struct Limit {
    key: ContactKey,
    /// Degree of freedom of the joint.
    dof: usize,
    /// Distance to the limit, rad or m.
    gap: f64,
    /// How the distance changes with the joint's rate.
    sign: f64,
}

/// Tendons with limits, by index.
fn limited_tendons(model: &Model) -> impl Iterator<Item = (usize, [f64; 2])> + '_ {
    model.tendons.iter().enumerate().filter_map(|(t, tendon)| Some((t, tendon.limits?)))
}

/// For the lower and the upper limit of a length: the distance to it, and how that changes with the rate.
fn gaps(length: f64, [lower, upper]: [f64; 2]) -> [(f64, f64); 2] {
    [(length - lower, 1.0), (upper - length, -1.0)]
}

/// The limits of all joints, in the order of their keys.
fn limits<'a>(model: &'a Model, state: &'a State) -> impl Iterator<Item = Limit> + 'a {
    model.joints.iter().enumerate().filter_map(|(j, joint)| Some((j, joint, joint.limits?))).flat_map(
        |(j, joint, [lower, upper])| {
            let (q, dof) = (state.q[joint.q_index], joint.v_index);
            [
                Limit { key: joint_limit_key(j, 0), dof, gap: q - lower, sign: 1.0 },
                Limit { key: joint_limit_key(j, 1), dof, gap: upper - q, sign: -1.0 },
            ]
        },
    )
}

fn stabilized(gap: f64, stabilization: f64) -> f64 {
    if gap < 0.0 { stabilization * gap } else { gap }
}
