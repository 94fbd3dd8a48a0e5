//! The height that the points of a flat patch have in common, and how it moves.

use std::ops::Range;

use signorini_multibody::ContactPoint;
use signorini_multibody::glam::DVec3;

use super::system::{Mover, Step};
use crate::geometry::{NoMotion, PointMotion, SearchMemory, point_motion};

/// The points of a patch, midway between their surfaces, and their mean. Memory is reused.
#[derive(Clone, Debug, Default)]
pub(crate) struct Patch {
    range: Option<Range<usize>>,
    members: Vec<(ContactPoint, PointMotion)>,
    /// Weights of the members in the mean, and the derivatives of their logarithms by gaps.
    weights: Vec<[f64; 2]>,
    /// The mean of their places.
    middle: DVec3,
    /// What each degree of freedom moves it by.
    moved: Vec<DVec3>,
}

/// What a degree of freedom moves the gap, the normal and the place of a point by that is midway between its surfaces.
pub(super) fn moved_by(step: &Step, point: &ContactPoint, motion: &PointMotion, mover: &Mover) -> (f64, DVec3, DVec3) {
    let own = step.end.displacement(mover.dof, point.position);
    let sign = f64::from(mover.of[1]) - f64::from(mover.of[0]);
    let twist = own.to_array().map(|x| x * sign);
    let sum = |columns: &[DVec3; 6]| columns.iter().zip(twist).map(|(column, x)| *column * x).sum::<DVec3>();
    let gap = motion.gap.iter().zip(twist).map(|(gap, x)| gap * x).sum();
    let carried = if mover.of[0] { (own.angular.cross(point.normal), own.linear) } else { Default::default() };
    let turns = motion.normal.iter().any(|n| *n != DVec3::ZERO);
    (gap, if turns { carried.0 + sum(&motion.normal) } else { carried.0 }, carried.1 + sum(&motion.position))
}

impl Patch {
    /// Forgets what is there.
    pub fn forget(&mut self) {
        self.range = None;
    }

    /// Finds the motion of the patch of contact `i`, and gives the contact midway between its surfaces, and its motion.
    ///
    /// - `list`: the degrees of freedom that move its bodies
    pub fn find(
        &mut self,
        step: &mut Step,
        (i, points): (usize, &[ContactPoint]),
        list: &[Mover],
        search: &mut SearchMemory,
    ) -> Result<(ContactPoint, PointMotion), NoMotion> {
        let range = step.workspace.contact_levels()[i].patch.clone();
        let own = i - range.start;
        if self.range.as_ref() == Some(&range) {
            return Ok(self.members[own]);
        }
        self.range = None;
        self.members.clear();
        self.weights.clear();
        for k in range.clone() {
            let level = &step.workspace.contact_levels()[k];
            self.weights.push([level.weight, level.weight_rate]);
            let point = level.midway(&points[k]);
            self.members.push((point, point_motion(step.model, step.workspace, &point, search)?));
        }
        self.middle = self.members.iter().zip(&self.weights).map(|((point, _), [w, _])| point.position * *w).sum();
        let mut moved = std::mem::take(&mut self.moved);
        moved.clear();
        for mover in list {
            moved.push(self.middle_moved(|point, motion| {
                let (gap, _, place) = moved_by(step, point, motion, mover);
                Ok((gap, place))
            })?);
        }
        self.moved = moved;
        self.range = Some(range);
        Ok(self.members[own])
    }

    /// What the mean of the places moves by, given what gaps and places do.
    pub fn middle_moved<E>(
        &self,
        moved: impl Fn(&ContactPoint, &PointMotion) -> Result<(f64, DVec3), E>,
    ) -> Result<DVec3, E> {
        let mut sum = DVec3::ZERO;
        for ((point, motion), [weight, rate]) in self.members.iter().zip(&self.weights) {
            let (gap, place) = moved(point, motion)?;
            sum += (place + (point.position - self.middle) * (rate * gap)) * *weight;
        }
        Ok(sum)
    }

    /// What the place of a point at the patch's height moves by, where midway it moves by `place`, its normal by `normal`, and degree of freedom `k` of
    /// the list does it.
    pub fn level_by(&self, k: usize, point: &ContactPoint, normal: DVec3, place: DVec3) -> DVec3 {
        self.level(self.moved[k], point, normal, place)
    }

    /// The same where the middle moves by `moved`: the place is `p + n n·(p̄ − p)`, with the mean `p̄`.
    pub fn level(&self, moved: DVec3, point: &ContactPoint, normal: DVec3, place: DVec3) -> DVec3 {
        let (n, apart) = (point.normal, self.middle - point.position);
        place + n * (n.dot(moved - place) + normal.dot(apart)) + normal * n.dot(apart)
    }
}
