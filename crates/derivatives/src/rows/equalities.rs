//! Rows of equality constraints: points and frames that stay on each other, coupled joints.

use signorini_multibody::glam::{DMat3, DQuat, DVec3};
use signorini_multibody::{BodyId, EqualityBlock, EqualityKind, JointId, JointKind, Pose, equality_block_into};
use signorini_multibody::{SpatialVector, TendonId, right_jacobian, rotation_log};

use super::parameters::add_violation;
use super::scratch::Scratch;
use super::system::{ModeRows, Mover, Push, Step, movers};
use super::tendons::{add_turning, measure};
use crate::validity::{InequalityKind, InequalitySource, Margin};

/// Rows that the step's problem leaves out, since others say the same or nothing moves them, as if they were in it with impulses of zero.
#[derive(Clone, Debug, Default)]
pub(crate) struct LeftOut {
    pub rows: ModeRows,
    /// The constraint of each row, and the largest motion of one of its ends by a degree of freedom, of which the row is the difference.
    pub of: Vec<(usize, f64)>,
}

/// Adds the rows that are in the step's problem to `rows`, and the others to `left_out`.
pub(super) fn add(
    step: &Step,
    margins: &mut Vec<Margin>,
    (rows, left_out): (&mut ModeRows, &mut LeftOut),
    turning: &mut [f64],
    scratch: &mut Scratch,
) -> Result<(), String> {
    let mut block = scratch.block.take().unwrap_or_else(|| EqualityBlock::new(step.model));
    let result = add_rows(step, &mut block, margins, rows, turning, scratch)
        .and_then(|()| add_left_out(step, &mut block, margins, left_out, turning, scratch));
    scratch.block = Some(block);
    result
}

fn add_rows(
    step: &Step,
    block: &mut EqualityBlock,
    margins: &mut Vec<Margin>,
    rows: &mut ModeRows,
    turning: &mut [f64],
    scratch: &mut Scratch,
) -> Result<(), String> {
    let problem = step.workspace.problem();
    for k in 0..problem.bilateral_violation.len() {
        let Some([equality, part, axis]) = step.workspace.bilateral_row(k) else {
            return Err(format!("bilateral row {k} prescribes a velocity"));
        };
        let equality = &step.model.equalities[equality];
        let refuse = |reason: &str| format!("constraint '{}': {reason}", equality.name);
        equality_block_into(step.model, step.workspace.kinematics(), &step.state.q, &equality.kind, part, block);
        check_pace(step, k, &equality.kind, part, block, margins).map_err(refuse)?;
        let violation = problem.bilateral_violation[k];
        if (violation - step.settings.stabilization * block.violation[axis]).abs() > 1e-12 * (1.0 + violation.abs()) {
            return Err(refuse("it is restored at a bounded speed"));
        }
        let (columns, entries) = problem.bilateral_jacobian.group(k);
        let row = Row {
            kind: &equality.kind,
            part,
            axis,
            source: InequalitySource::Bilateral(k),
            lambda: step.solution.bilateral[k],
        };
        let entries = columns.iter().zip(entries).map(|(&column, entry)| (column as usize, entry[0]));
        row.push(step, entries, margins, rows, turning, scratch).map_err(refuse)?;
        add_violation(rows.len() - 1, violation, problem.timestep, step.directions, rows);
    }
    Ok(())
}

fn add_left_out(
    step: &Step,
    block: &mut EqualityBlock,
    margins: &mut Vec<Margin>,
    left_out: &mut LeftOut,
    turning: &mut [f64],
    scratch: &mut Scratch,
) -> Result<(), String> {
    left_out.rows.clear(step.model, 0);
    left_out.of.clear();
    let mut there = (0..).map_while(|k| step.workspace.bilateral_row(k)).peekable();
    for (e, equality) in step.model.equalities.iter().enumerate() {
        for part in 0..equality.kind.block_count() {
            equality_block_into(step.model, step.workspace.kinematics(), &step.state.q, &equality.kind, part, block);
            for axis in 0..block.count {
                if there.next_if_eq(&[e, part, axis]).is_some() {
                    continue;
                }
                let source = InequalitySource::Bilateral(step.solution.bilateral.len() + left_out.of.len());
                let row = Row { kind: &equality.kind, part, axis, source, lambda: 0.0 };
                let entries = block.rows.dofs.iter().zip(&block.rows.columns).map(|(&dof, column)| (dof, column[axis]));
                row.push(step, entries, margins, &mut left_out.rows, turning, scratch)
                    .map_err(|reason| format!("constraint '{}': {reason}", equality.name))?;
                left_out.of.push((e, row.largest_motion(step, scratch)));
            }
        }
    }
    Ok(())
}

/// A row of a constraint.
struct Row<'a> {
    kind: &'a EqualityKind,
    part: usize,
    axis: usize,
    source: InequalitySource,
    /// Its impulse, N·s or N·m·s.
    lambda: f64,
}

impl Row<'_> {
    /// Adds it to `rows`, and how its impulse turns to `turning`.
    ///
    /// - `entries`: degrees of freedom with what they change of the violation
    fn push(
        &self,
        step: &Step,
        entries: impl Iterator<Item = (usize, f64)> + Clone,
        margins: &mut Vec<Margin>,
        rows: &mut ModeRows,
        turning: &mut [f64],
        scratch: &mut Scratch,
    ) -> Result<(), &'static str> {
        let &Self { kind, part, axis, source, lambda } = self;
        let part_of_dt = step.settings.stabilization / step.workspace.problem().timestep;
        let row = rows.push(source);
        for (k, entry) in entries.clone() {
            (row.held[k], row.impulse[k]) = (entry, entry);
            row.by_configuration[k] = part_of_dt * entry;
        }
        let slopes = row.by_configuration;
        match *kind {
            EqualityKind::Tendon { tendon, driver, polynomial } => {
                let pull = Follower { tendon, driver, polynomial, source };
                pull.turn(step, lambda, margins, (slopes, turning), scratch)?;
                entries.for_each(|(k, entry)| rows.coordinate_impulse[k] += lambda * entry);
            }
            EqualityKind::Joint { driver, polynomial, .. } => {
                bend(step, driver, polynomial, lambda, (slopes, turning));
                entries.for_each(|(k, entry)| rows.coordinate_impulse[k] += lambda * entry);
            }
            EqualityKind::Weld { body_a, frame_a, body_b, frame_b } if part == 1 => {
                let pair = Pair::new(step, [(body_a, DVec3::ZERO), (body_b, DVec3::ZERO)], &mut scratch.list);
                let list = &scratch.list;
                let turn = pair.relative_turn(step, [frame_a.rotation, frame_b.rotation]);
                pair.turn_slopes(step, axis, list, turn, part_of_dt, slopes);
                pair.twist(step, axis, lambda, list, rows, turning);
            }
            EqualityKind::Weld {
                body_a,
                frame_a: Pose { position: point_a, .. },
                body_b,
                frame_b: Pose { position: point_b, .. },
            }
            | EqualityKind::Connect { body_a, point_a, body_b, point_b } => {
                let pair = Pair::new(step, [(body_a, point_a), (body_b, point_b)], &mut scratch.list);
                let list = &scratch.list;
                pair.point_slopes(step, axis, list, part_of_dt, slopes);
                pair.act(step, axis, lambda, list, rows, turning);
            }
        }
        Ok(())
    }

    /// The largest displacement of one of the two ends, m or rad, by a degree of freedom; 1 of coupled coordinates.
    fn largest_motion(&self, step: &Step, scratch: &mut Scratch) -> f64 {
        let ends = match *self.kind {
            EqualityKind::Tendon { .. } | EqualityKind::Joint { .. } => return 1.0,
            EqualityKind::Weld { body_a, frame_a, body_b, frame_b } => {
                [(body_a, frame_a.position), (body_b, frame_b.position)]
            }
            EqualityKind::Connect { body_a, point_a, body_b, point_b } => [(body_a, point_a), (body_b, point_b)],
        };
        let is_angular = matches!(self.kind, EqualityKind::Weld { .. }) && self.part == 1;
        let pair = Pair::new(step, ends, &mut scratch.list);
        let moved = scratch.list.iter().flat_map(|mover| (0..2).filter(|&s| mover.of[s]).map(|s| (mover.dof, s)));
        let size = moved.map(|(dof, s)| {
            let displacement = step.end.displacement(dof, pair.points[s]);
            if is_angular { displacement.angular.length() } else { displacement.linear.length() }
        });
        size.fold(0.0, f64::max)
    }
}

/// A row of coupled joints turns with the driver's coordinate, by the second derivative of the polynomial.
fn bend(
    step: &Step,
    driver: Option<JointId>,
    polynomial: [f64; 5],
    lambda: f64,
    (slopes, turning): (&mut [f64], &mut [f64]),
) {
    let Some(driver) = driver else { return };
    let joint = &step.model.joints[driver.index()];
    let x = step.state.q[joint.q_index] - joint.reference;
    let [_, _, a_2, a_3, a_4] = polynomial;
    let bend = 2.0 * a_2 + x * (6.0 * a_3 + x * 12.0 * a_4);
    let k = joint.v_index;
    slopes[k] -= bend * step.solution.velocity[k];
    turning[k * step.model.nv + k] -= lambda * bend;
}

/// A tendon that follows another by a polynomial.
struct Follower {
    tendon: TendonId,
    driver: Option<TendonId>,
    polynomial: [f64; 5],
    source: InequalitySource,
}

impl Follower {
    /// Adds how its row `g − p′(x) g′` turns, with the driver's row `g′` and its length `x` from the reference.
    fn turn(
        &self,
        step: &Step,
        lambda: f64,
        margins: &mut Vec<Margin>,
        (slopes, turning): (&mut [f64], &mut [f64]),
        scratch: &mut Scratch,
    ) -> Result<(), &'static str> {
        add_turning(step, (self.tendon, 1.0, self.source), lambda, margins, (slopes, turning), scratch)?;
        let Some(driver) = self.driver else { return Ok(()) };
        measure(step, driver, (&mut scratch.length, &mut scratch.turns));
        let x = scratch.length.length - step.model.tendons[driver.index()].reference_length;
        let [_, a_1, a_2, a_3, a_4] = self.polynomial;
        let slope = a_1 + x * (2.0 * a_2 + x * (3.0 * a_3 + x * 4.0 * a_4));
        let bend = 2.0 * a_2 + x * (6.0 * a_3 + x * 12.0 * a_4);
        add_turning(step, (driver, -slope, self.source), lambda, margins, (slopes, turning), scratch)?;
        let row = &scratch.length;
        let rate = row.rate(&step.solution.velocity);
        for (&l, other) in row.dofs.iter().zip(&row.gradient) {
            slopes[l] -= bend * rate * other;
            for (&k, g) in row.dofs.iter().zip(&row.gradient) {
                turning[k * step.model.nv + l] -= lambda * bend * g * other;
            }
        }
        Ok(())
    }
}

/// Notes how far the violation is from what is removed in one step.
fn check_pace(
    step: &Step,
    k: usize,
    kind: &EqualityKind,
    part: usize,
    block: &EqualityBlock,
    margins: &mut Vec<Margin>,
) -> Result<(), &'static str> {
    let is_angular = match *kind {
        EqualityKind::Connect { .. } | EqualityKind::Tendon { .. } => false,
        EqualityKind::Weld { .. } => part == 1,
        EqualityKind::Joint { joint, .. } => !matches!(step.model.joints[joint.index()].kind, JointKind::Slide { .. }),
    };
    let settings = step.settings;
    let speed = if is_angular { settings.correction_angular_speed } else { settings.correction_speed };
    let asked = settings.stabilization * DVec3::from(block.violation).length() / step.workspace.problem().timestep;
    if asked > speed {
        return Err("it is restored at a bounded speed");
    }
    if speed.is_finite() {
        let (source, kind) = (InequalitySource::Bilateral(k), InequalityKind::Threshold);
        margins.push(Margin { source, kind, value: step.scales.velocity(speed - asked) });
    }
    Ok(())
}

/// Two bodies and a point of each, in world, and the last body that carries both.
struct Pair {
    bodies: [BodyId; 2],
    points: [DVec3; 2],
    carrier: BodyId,
}

/// Of A and of B.
const SIGNS: [f64; 2] = [-1.0, 1.0];

impl Pair {
    /// `ends`: bodies with points in their frames; `list`: out, what moves them.
    fn new(step: &Step, ends: [(BodyId, DVec3); 2], list: &mut Vec<Mover>) -> Self {
        let bodies = ends.map(|(body, _)| body);
        movers(step.model, bodies, list);
        let place =
            |(body, point): (BodyId, DVec3)| step.workspace.kinematics().pose[body.index()].transform_point(point);
        Self { bodies, points: ends.map(place), carrier: carrier(step, bodies) }
    }

    /// The vector from the point of A to that of B.
    fn apart(&self) -> DVec3 {
        self.points[1] - self.points[0]
    }

    /// Slopes of the relative velocity of the points along an axis of the world, as it is seen from what carries both, and of the part of the violation
    /// that the row has none of: what carries both turns it.
    fn point_slopes(&self, step: &Step, axis: usize, list: &[Mover], part_of_dt: f64, out: &mut [f64]) {
        let carried = step.end.velocity(self.carrier, DVec3::ZERO).angular;
        for mover in list {
            let relative = self.sides(mover).map(|s| {
                let (body, point) = (self.bodies[s], self.points[s]);
                let shift = step.end.displacement(mover.dof, point).linear;
                let turning = step.end.velocity(body, point).angular - carried;
                (step.end.velocity_slope(body, mover.dof, point).linear + turning.cross(shift)) * SIGNS[s]
            });
            let mut slope: DVec3 = relative.sum();
            if mover.moves_both() {
                let turn = step.end.displacement(mover.dof, DVec3::ZERO).angular;
                slope -= step.end.velocity_slope(self.carrier, mover.dof, DVec3::ZERO).angular.cross(self.apart());
                slope += part_of_dt * turn.cross(self.apart());
            }
            out[mover.dof] += slope[axis];
        }
    }

    /// A force on B, its opposite on A, and on what carries both the opposite of their moment, along an axis of the world: it does not turn with them.
    fn act(&self, step: &Step, axis: usize, lambda: f64, list: &[Mover], rows: &mut ModeRows, turning: &mut [f64]) {
        let force = DVec3::AXES[axis] * lambda;
        for s in 0..2 {
            let push = Push { point: self.points[s], force, moment: DVec3::ZERO };
            push.act(step, self.bodies[s], SIGNS[s], &mut rows.wrenches);
        }
        let couple = Push { point: self.points[0], force: DVec3::ZERO, moment: force.cross(self.apart()) };
        couple.act(step, self.carrier, 1.0, &mut rows.wrenches);
        self.hold(step, list, turning, |own, row| row.linear.dot(own.angular.cross(force)));
        // What moves one of the points alone changes the moment of the two forces about what moves both.
        for (mover, other) in pairs(list).filter(|(mover, other)| other.moves_both() && !mover.moves_both()) {
            let shift: DVec3 = self.sides(mover).map(|s| self.displacement(step, mover, s).linear * SIGNS[s]).sum();
            let axis = self.displacement(step, other, 0).angular;
            turning[other.dof * step.model.nv + mover.dof] -= axis.dot(shift.cross(force));
        }
    }

    /// A moment on B, and its opposite on A, about an axis of the world.
    fn twist(&self, step: &Step, axis: usize, lambda: f64, list: &[Mover], rows: &mut ModeRows, turning: &mut [f64]) {
        let moment = DVec3::AXES[axis] * lambda;
        for s in 0..2 {
            let push = Push { point: self.points[s], force: DVec3::ZERO, moment };
            push.act(step, self.bodies[s], SIGNS[s], &mut rows.wrenches);
        }
        self.hold(step, list, turning, |own, row| row.angular.dot(own.angular.cross(moment)));
    }

    /// Takes back that an impulse turns with its bodies. `power`: of the turned impulse, from the displacement that turns it and the
    /// one that it acts on.
    fn hold(
        &self,
        step: &Step,
        list: &[Mover],
        turning: &mut [f64],
        power: impl Fn(SpatialVector, SpatialVector) -> f64,
    ) {
        // What moves both is not moved by the two, as their moments are taken up by what carries both.
        for (mover, other) in pairs(list).filter(|(mover, other)| !(mover.moves_both() && other.moves_both())) {
            for s in self.sides(mover).filter(|&s| other.of[s]) {
                turning[other.dof * step.model.nv + mover.dof] -=
                    SIGNS[s] * power(self.displacement(step, mover, s), self.displacement(step, other, s));
            }
        }
    }

    /// The bodies that a degree of freedom moves.
    fn sides(&self, mover: &Mover) -> impl Iterator<Item = usize> + use<> {
        let of = mover.of;
        (0..2).filter(move |&s| of[s])
    }

    /// Rotation and displacement of a body at its point by a degree of freedom.
    fn displacement(&self, step: &Step, mover: &Mover, s: usize) -> SpatialVector {
        step.end.displacement(mover.dof, self.points[s])
    }

    /// The rotation vector from a frame on A to one on B in world axes, and its change by a relative rotation in world axes. `frames`: in the
    /// bodies' frames.
    fn relative_turn(&self, step: &Step, frames: [DQuat; 2]) -> (DVec3, DMat3) {
        let placed = [0, 1].map(|s| step.workspace.kinematics().pose[self.bodies[s].index()].rotation * frames[s]);
        let turn = rotation_log(placed[0].conjugate() * placed[1]);
        let [a, b] = placed.map(DMat3::from_quat);
        (a * turn, a * right_jacobian(turn).inverse() * b.transpose())
    }

    /// Slopes of the relative angular velocity along an axis of the world, and of the violation, which is a rotation vector: `violation`
    /// in world axes and its change by the relative rotation. The row has its own part of the violation already.
    fn turn_slopes(
        &self,
        step: &Step,
        axis: usize,
        list: &[Mover],
        (violation, by_relative): (DVec3, DMat3),
        part_of_dt: f64,
        out: &mut [f64],
    ) {
        for mover in list {
            let turn = step.end.displacement(mover.dof, self.points[0]).angular;
            let slope = |s: usize| step.end.velocity_slope(self.bodies[s], mover.dof, self.points[s]).angular[axis];
            out[mover.dof] += self.sides(mover).map(|s| SIGNS[s] * slope(s)).sum::<f64>();
            let carried = if mover.of[0] { turn.cross(violation) } else { DVec3::ZERO };
            let relative = turn * (f64::from(mover.of[1]) - f64::from(mover.of[0]));
            out[mover.dof] += part_of_dt * (carried + by_relative * relative - relative)[axis];
        }
    }
}

/// The last body that carries two others, which may be one of them.
fn carrier(step: &Step, [mut a, mut b]: [BodyId; 2]) -> BodyId {
    while a != b {
        let later = if a > b { &mut a } else { &mut b };
        *later = step.model.bodies[later.index()].parent;
    }
    a
}

/// All pairs of degrees of freedom: one that moves, and one that is acted on.
fn pairs(list: &[Mover]) -> impl Iterator<Item = (&Mover, &Mover)> {
    list.iter().flat_map(move |mover| list.iter().map(move |other| (mover, other)))
}
