//! Which of the points that could touch within a step its problem has, and the watch over the others.
//!
//! The collider finds every point that the bodies could bring together if they moved straight towards each other. The problem has those
//! that can close at the velocities at hand; the others have no impulse. After the solve their gaps are looked at with the velocity
//! found: where one would close, it comes into the problem, and that is solved again. With zero impulses and gaps that stay open the points
//! left out obey the laws of contact, so that the solution is one of the problem with all points.

use signorini_multibody::glam::DVec3;
use signorini_multibody::{ContactPoint, Kinematics};

use crate::patches::Patches;
use crate::reach::Velocities;

/// Factor between what the velocities at hand close and the gaps that are looked at.
const MARGIN: f64 = 2.0;

/// The points of a step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Candidates {
    /// All that bodies could bring together, in order.
    pub all: Vec<ContactPoint>,
    /// For each whether the problem has it.
    chosen: Vec<bool>,
    /// Those that the velocity found brought in, by geoms and feature, in order: they stay for the step.
    brought: Vec<[u32; 3]>,
    /// Those of the problem at hand, by geoms and feature.
    written: Vec<[u32; 3]>,
    /// Whether the problem at hand lacks more than points.
    is_stale: bool,
    patches: Patches,
}

impl Candidates {
    /// Begins a step.
    pub fn begin(&mut self) {
        self.brought.clear();
    }

    /// Chooses all.
    pub fn choose_all(&mut self) {
        self.chosen.clear();
        self.chosen.resize(self.all.len(), true);
    }

    /// Chooses those that can close.
    ///
    /// - `free`: velocities without contact; `gap`: what counts of a point's, m
    pub fn choose(&mut self, kinematics: &Kinematics, free: &Velocities, dt: f64, gap: impl Fn(&ContactPoint) -> f64) {
        let Self { all, chosen, brought, .. } = self;
        chosen.clear();
        chosen.extend(all.iter().map(|point| {
            gap(point) <= MARGIN * dt * closing_speed(point, kinematics, free) || is_among(brought, point)
        }));
    }

    /// Leaves at most `most` of the chosen points to a patch, beside those that were brought in; 0: all. Points that overlap stay: what they are
    /// corrected by does not follow from the others.
    pub fn limit_patches(&mut self, most: usize, overlaps: impl Fn(&ContactPoint) -> bool) {
        let Self { all, chosen, brought, patches, .. } = self;
        patches.limit(all, chosen, most, |point| is_among(brought, point) || overlaps(point));
    }

    /// Chooses these, which are some of all in their order; whether they are all there.
    pub fn choose_these(&mut self, count: usize, same: impl Fn(usize, &ContactPoint) -> bool) -> bool {
        let mut next = 0;
        self.chosen.clear();
        for point in &self.all {
            let is_next = next < count && same(next, point);
            self.chosen.push(is_next);
            next += usize::from(is_next);
        }
        next == count
    }

    /// Those that were brought in since the step began.
    pub fn brought(&self) -> impl Iterator<Item = &ContactPoint> {
        self.all.iter().filter(|point| is_among(&self.brought, point))
    }

    /// How many are chosen.
    pub fn count(&self) -> usize {
        self.chosen.iter().filter(|chosen| **chosen).count()
    }

    fn chosen_points(&self) -> impl Iterator<Item = &ContactPoint> {
        self.all.iter().zip(&self.chosen).filter(|(_, chosen)| **chosen).map(|(point, _)| point)
    }

    /// Writes the points that are chosen, for a problem.
    pub fn write(&mut self, out: &mut Vec<ContactPoint>) {
        out.clear();
        out.extend(self.chosen_points());
        self.is_stale = false;
        self.written.clear();
        self.written.extend(out.iter().map(identity));
    }

    /// Whether the points that are chosen are those that were written.
    pub fn are_written(&self) -> bool {
        !self.is_stale && self.chosen_points().map(identity).eq(self.written.iter().copied())
    }

    /// Takes the problem at hand for one that lacks rows, whatever points are chosen.
    pub fn note_stale(&mut self) {
        self.is_stale = true;
    }

    /// Chooses the points left out that close faster than `tolerance` after the step, `φ/Δt + c_N < -tolerance` (m/s); whether there are
    /// any. What overlaps is chosen from the beginning.
    ///
    /// - `end`: velocities of the bodies at the end of the step; `gap`: what counts of a point's, m
    pub fn bring_in(
        &mut self,
        kinematics: &Kinematics,
        end: &Velocities,
        dt: f64,
        tolerance: f64,
        gap: impl Fn(&ContactPoint) -> f64,
    ) -> bool {
        let before = self.brought.len();
        for (point, chosen) in self.all.iter().zip(&mut self.chosen) {
            if !*chosen && gap(point) / dt + normal_velocity(point, kinematics, end) < -tolerance {
                *chosen = true;
                self.brought.push(identity(point));
            }
        }
        let is_more = self.brought.len() > before;
        self.brought.sort_unstable();
        is_more
    }
}

/// What a point is known by, as long as the configuration is the same.
fn identity(point: &ContactPoint) -> [u32; 3] {
    [point.geom_a.0, point.geom_b.0, point.feature]
}

fn is_among(brought: &[[u32; 3]], point: &ContactPoint) -> bool {
    brought.binary_search(&identity(point)).is_ok()
}

/// Velocity of B relative to A along the normal, m/s.
fn normal_velocity(point: &ContactPoint, kinematics: &Kinematics, of: &Velocities) -> f64 {
    let [a, b] = [point.body_a, point.body_b].map(|body| of.at(body, kinematics, point.position));
    point.normal.dot(b - a)
}

/// How fast a gap can close: at the beginning of the step or without contact, and beside that what forces change of both velocities,
/// which contacts may have to take away from one body alone.
fn closing_speed(point: &ContactPoint, kinematics: &Kinematics, free: &Velocities) -> f64 {
    let (mut now, mut without, mut forced) = (DVec3::ZERO, DVec3::ZERO, 0.0);
    for (body, sign) in [(point.body_a, -1.0), (point.body_b, 1.0)] {
        let before = kinematics.point_velocity(body, point.position);
        let after = free.at(body, kinematics, point.position);
        now += sign * before;
        without += sign * after;
        forced += (after - before).length();
    }
    (-point.normal.dot(now)).max(-point.normal.dot(without)).max(0.0) + forced
}
