//! Two bodies that a constraint ties to each other: how its rows turn with them, and what its impulses do to them.

use signorini_multibody::glam::{DMat3, DQuat, DVec3};
use signorini_multibody::{BodyId, SpatialVector, right_jacobian, rotation_log};

use super::system::{ModeRows, Mover, Push, Step, movers};

/// Two bodies and a point of each, in world, and the last body that carries both.
pub(super) struct Pair {
    bodies: [BodyId; 2],
    pub points: [DVec3; 2],
    carrier: BodyId,
}

/// Of A and of B.
const SIGNS: [f64; 2] = [-1.0, 1.0];

impl Pair {
    /// `ends`: bodies with points in their frames; `list`: out, what moves them.
    pub fn new(step: &Step, ends: [(BodyId, DVec3); 2], list: &mut Vec<Mover>) -> Self {
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
    pub fn point_slopes(&self, step: &Step, axis: usize, list: &[Mover], part_of_dt: f64, out: &mut [f64]) {
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
    pub fn act(&self, step: &Step, axis: usize, lambda: f64, list: &[Mover], rows: &mut ModeRows, turning: &mut [f64]) {
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
    pub fn twist(
        &self,
        step: &Step,
        axis: usize,
        lambda: f64,
        list: &[Mover],
        rows: &mut ModeRows,
        turning: &mut [f64],
    ) {
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
    pub fn relative_turn(&self, step: &Step, frames: [DQuat; 2]) -> (DVec3, DMat3) {
        let placed = [0, 1].map(|s| step.workspace.kinematics().pose[self.bodies[s].index()].rotation * frames[s]);
        let turn = rotation_log(placed[0].conjugate() * placed[1]);
        let [a, b] = placed.map(DMat3::from_quat);
        (a * turn, a * right_jacobian(turn).inverse() * b.transpose())
    }

    /// Slopes of the relative angular velocity along an axis of the world, and of the violation, which is a rotation vector: `violation`
    /// in world axes and its change by the relative rotation. The row has its own part of the violation already.
    pub fn turn_slopes(
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
