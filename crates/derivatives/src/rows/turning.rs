//! How the impulses of contacts turn and move with their bodies.

use signorini_multibody::glam::DVec3;
use signorini_multibody::{BodyId, ContactPoint, SpatialVector};
use signorini_simulation::FrictionSource;

use super::frames::groups_of;
use super::system::{Moved, Mover, Push, Step};

/// `∂(Jᵀ p)/∂q` at fixed `p`, less the part in which the pushes turn with each body, of contacts between the same two bodies: what each degree of
/// freedom does to the wrench on either body is summed before its power along all degrees of freedom is taken.
#[derive(Clone, Debug, Default)]
pub(crate) struct TurnSum {
    bodies: Option<[BodyId; 2]>,
    /// The point of the world that moments are about, m.
    about: DVec3,
    movers: Vec<Mover>,
    /// For each of these the change of the wrench that A gives back and of that on B.
    changes: Vec<[SpatialVector; 2]>,
}

impl TurnSum {
    /// Forgets what is there.
    pub fn forget(&mut self) {
        self.bodies = None;
    }

    /// Adds contact `i`; what is there of other bodies goes into `turning`.
    pub fn add(
        &mut self,
        step: &Step,
        (i, point): (usize, &ContactPoint),
        push: &Push,
        (list, moved): (&[Mover], &[Moved]),
        turning: &mut [f64],
    ) {
        let solution = step.solution;
        let mut about_axes = [0.0; 3];
        for (j, source) in groups_of(step, i) {
            let [x, y] = solution.group_impulse[j];
            match source {
                FrictionSource::Spinning { .. } => about_axes[0] = x,
                _ => (about_axes[1], about_axes[2]) = (x, y),
            }
        }
        if push.force == DVec3::ZERO && push.moment == DVec3::ZERO {
            return;
        }
        let bodies = Some([point.body_a, point.body_b]);
        if self.bodies != bodies {
            self.flush(step, turning);
            (self.bodies, self.about) = (bodies, push.point);
            self.movers.clear();
            self.movers.extend_from_slice(list);
            self.changes.clear();
            self.changes.resize(list.len(), [SpatialVector::ZERO; 2]);
        }
        let lever = push.point - self.about;
        for ((mover, m), changes) in list.iter().zip(moved).zip(&mut self.changes) {
            let force: DVec3 = (0..3).map(|r| m.axes[r] * solution.impulse[i][r]).sum();
            let moment: DVec3 = (0..3).map(|r| m.axes[r] * about_axes[r]).sum();
            for (change, moves) in changes.iter_mut().zip(mover.of) {
                let s = f64::from(moves);
                let arm = m.place - m.shift * s;
                let force = force - m.turn.cross(push.force) * s;
                let moment = moment + arm.cross(push.force) - m.turn.cross(push.moment) * s;
                change.angular += moment + lever.cross(force);
                change.linear += force;
            }
        }
    }

    /// Adds the sums to `turning`, `[nv, nv]`.
    pub fn flush(&mut self, step: &Step, turning: &mut [f64]) {
        if self.bodies.take().is_none() {
            return;
        }
        let nv = step.model.nv;
        for other in &self.movers {
            let along = step.end.displacement(other.dof, self.about);
            let power = |wrench: &SpatialVector| along.angular.dot(wrench.angular) + along.linear.dot(wrench.linear);
            let row = &mut turning[other.dof * nv..(other.dof + 1) * nv];
            for (mover, [of_a, of_b]) in self.movers.iter().zip(&self.changes) {
                if other.of[1] {
                    row[mover.dof] += power(of_b);
                }
                if other.of[0] {
                    row[mover.dof] -= power(of_a);
                }
            }
        }
    }
}
