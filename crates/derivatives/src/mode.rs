//! What a contact or a friction group does, as the motions it holds, the impulses that hold them, and its margins.

use signorini_contact::{ContactMode, ContactProblem, ContactSolution};

use crate::validity::{InequalityKind, InequalitySource, Margin};

/// The motions that a unit holds and the impulses that are free for it, in the unit's coordinates: normal, first and second tangent.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct UnitMode {
    pub count: usize,
    pub held: [[f64; 3]; 3],
    pub impulse: [[f64; 3]; 3],
    /// The direction at which friction stands per unit of its bound, where it slides.
    pub sliding: [f64; 2],
}

impl UnitMode {
    /// All three motions, each with its own impulse.
    pub const WHOLE: Self = Self {
        count: 3,
        held: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        impulse: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        sliding: [0.0; 2],
    };

    fn push(&mut self, held: [f64; 3], impulse: [f64; 3]) {
        (self.held[self.count], self.impulse[self.count]) = (held, impulse);
        self.count += 1;
    }
}

/// An inequality nearer than this is about to turn: the residuals of a step, 1e-9, times what the worst pivot that is let through makes of them.
pub(crate) const TIE: f64 = 1e-5;

/// Whether an inequality is about to turn.
pub(crate) fn is_tie(margin: &Margin) -> bool {
    margin.value.is_nan() || margin.value <= TIE
}

/// The scales of a step's problem: velocities are compared with the larger of `s_v` and the speeds at contacts, impulses with that over `g`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scales {
    velocity: f64,
    delassus: f64,
}

impl Scales {
    /// - `velocities`: of the step, whose terms along the contacts are what margins are a difference of
    /// - `at_rest`: the speed that margins are compared with where nothing moves along any row, > 0
    /// - `scratch`: memory
    pub fn of(problem: &ContactProblem, velocities: [&[f64]; 2], at_rest: f64, scratch: &mut Vec<f64>) -> Self {
        scratch.clear();
        scratch.resize(problem.nv(), 0.0);
        let terms = |i: usize, v: &[f64]| problem.jacobian.multiply_with_terms(i, v).1;
        let of_contact = |i| velocities.iter().fold(terms(i, &problem.free_velocity), |s, v| s.max(terms(i, v)));
        let speed = (0..problem.contact_count()).map(of_contact).fold(problem.velocity_scale(), f64::max);
        Self { velocity: if speed > 0.0 { speed } else { at_rest }, delassus: problem.delassus_scale_with(scratch) }
    }

    pub fn velocity(&self, v: f64) -> f64 {
        v / self.velocity
    }

    pub fn impulse(&self, p: f64) -> f64 {
        p * self.delassus / self.velocity
    }
}

/// The mode of contact `i`.
pub(crate) fn contact_mode(
    problem: &ContactProblem,
    solution: &ContactSolution,
    i: usize,
    scales: Scales,
    margins: &mut Vec<Margin>,
) -> UnitMode {
    let source = InequalitySource::Contact(i);
    let mut mode = UnitMode::default();
    let [c_n, c_1, c_2] = problem.contact_velocity(i, &solution.velocity);
    let lambda = solution.lambda_n[i];
    if solution.modes[i] == ContactMode::Open || lambda <= 0.0 {
        let value = scales.velocity(problem.gap[i] / problem.timestep + c_n);
        margins.push(Margin { source, kind: InequalityKind::Gap, value });
        return mode;
    }
    margins.push(Margin { source, kind: InequalityKind::NormalImpulse, value: scales.impulse(lambda) });
    let directions = problem.directions_of(i);
    let offset = problem.direction_offsets[i];
    let alpha = &solution.alpha[offset..offset + directions.len()];
    let friction = problem.friction[i];
    let bound = friction * lambda;
    let unit = Friction { source, directions, alpha, bound, slip: [c_1, c_2], lines: 2 };
    let normal = [1.0, 0.0, 0.0];
    if directions.is_empty() || friction == 0.0 {
        mode.push(normal, normal);
        return mode;
    }
    unit.add(solution.modes[i], scales, &mut mode, margins);
    let [x, y] = mode.sliding.map(|d| friction * d);
    let rest = mode;
    mode = UnitMode { sliding: rest.sliding, ..UnitMode::default() };
    mode.push(normal, [1.0, x, y]);
    (0..rest.count).for_each(|r| mode.push(rest.held[r], rest.impulse[r]));
    mode
}

/// The mode of friction group `j`.
pub(crate) fn group_mode(
    problem: &ContactProblem,
    solution: &ContactSolution,
    j: usize,
    scales: Scales,
    margins: &mut Vec<Margin>,
) -> UnitMode {
    let groups = &problem.friction_groups;
    let mut mode = UnitMode::default();
    let bound = groups.bound_at(j, &solution.lambda_n);
    if bound <= 0.0 {
        return mode;
    }
    let directions = groups.directions_of(j);
    let alpha = &solution.group_alpha[groups.direction_range(j)];
    let (slip, source) = (groups.slip(j, &solution.velocity), InequalitySource::FrictionGroup(j));
    let lines = if directions.len() == 2 { 1 } else { 2 };
    let unit = Friction { source, directions, alpha, bound, slip, lines };
    unit.add(solution.group_modes[j], scales, &mut mode, margins);
    mode
}

/// Friction that is bounded, and what it does.
struct Friction<'a> {
    source: InequalitySource,
    directions: &'a [[f64; 2]],
    alpha: &'a [f64],
    bound: f64,
    slip: [f64; 2],
    /// Generalized directions it acts in.
    lines: usize,
}

impl Friction<'_> {
    fn add(&self, contact_mode: ContactMode, scales: Scales, mode: &mut UnitMode, margins: &mut Vec<Margin>) {
        let mut push = |kind, value| margins.push(Margin { source: self.source, kind, value });
        let against = |d: &[f64; 2]| -(d[0] * self.slip[0] + d[1] * self.slip[1]);
        let speed = self.directions.iter().map(against).fold(0.0, f64::max);
        let mut slides = |corners: &[usize]| {
            push(InequalityKind::SlidingSpeed, scales.velocity(speed));
            let others = self.directions.iter().enumerate().filter(|(k, _)| !corners.contains(k));
            let nearest = others.map(|(_, d)| speed - against(d)).fold(f64::INFINITY, f64::min);
            push(InequalityKind::Direction, scales.velocity(nearest));
        };
        match contact_mode {
            ContactMode::Sliding { k } => {
                slides(&[k as usize]);
                mode.sliding = self.directions[k as usize];
            }
            ContactMode::SlidingBetween { j, k } => {
                let (j, k) = (j as usize, k as usize);
                slides(&[j, k]);
                push(InequalityKind::Share, scales.impulse(self.alpha[j].min(self.alpha[k])));
                mode.sliding = self.directions[j];
                let edge = [0, 1].map(|a| self.directions[k][a] - self.directions[j][a]);
                mode.push([0.0, edge[0], edge[1]], [0.0, edge[0], edge[1]]);
            }
            _ => {
                let used: f64 = self.alpha.iter().sum();
                push(InequalityKind::FrictionBound, scales.impulse(self.bound - used));
                mode.push([0.0, 1.0, 0.0], [0.0, 1.0, 0.0]);
                if self.lines == 2 {
                    mode.push([0.0, 0.0, 1.0], [0.0, 0.0, 1.0]);
                }
            }
        }
    }
}
