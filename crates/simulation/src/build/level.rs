//! Contacts of a flat patch at one height.

use std::ops::Range;

use signorini_multibody::ContactPoint;

use super::pace::LAST_DIGITS;

/// Gaps and overlaps well below this, m, have the same weight in the height of a patch, and from there on next to none: what is about to open, or has yet to
/// close, does not lift what touches, whether it is in the problem or not. Any weights make the rows agree; this is more than steps of motion
/// leave, and with 1e-5 differences of steps no longer resolved the derivatives.
const NEAR: f64 = 1e-4;

/// The weight of what is farther apart, which counts where nothing is nearer. With 1e-4, as of what falls with the fourth power of the gap, heaps that had come to rest
/// moved on when far points came into the problem.
const FAR: f64 = 1e-12;

/// Where a contact point of a step's problem is.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// How far it lies from the middle between its two surfaces, along its normal, m.
    pub offset: f64,
    /// The contact points, itself among them, that have one height: the mean of theirs.
    pub patch: Range<usize>,
    /// Its weight in that; the weights of a patch have the sum one.
    pub weight: f64,
    /// Derivative by its gap of the logarithm of its weight before they were divided by their sum, 1/m.
    pub weight_rate: f64,
}

impl Level {
    /// A point of the step's problem as it was found: midway between its two surfaces.
    pub fn midway(&self, point: &ContactPoint) -> ContactPoint {
        point.with_position(point.position - point.normal * self.offset)
    }
}

/// Brings the points in which two bodies touch with one normal to a mean of their heights along it.
///
/// Midway between two surfaces that are tilted against each other points lie at heights that differ by halves of their gaps. Where all of them stick and the
/// bodies turn to close those gaps, the rows of their tangents contradict each other by the product of the two: by 1e-11 of the velocity of a robot on
/// two flat feet, which decides which contacts slide, and moves impulses a long way. At one height they agree, as those of a rigid body do. Points whose heights
/// differ by more than the largest gap are at different places, as on steps.
pub(super) fn level(points: &mut [ContactPoint], levels: &mut Vec<Level>) {
    levels.clear();
    for patch in points.chunk_by_mut(are_one_patch) {
        let begin = levels.len();
        let all = begin..begin + patch.len();
        if patch.len() == 1 || !are_at_one_place(patch) {
            levels.extend(all.map(|i| Level { offset: 0.0, patch: i..i + 1, weight: 1.0, weight_rate: 0.0 }));
            continue;
        }
        let (mut sum, mut height) = (0.0, 0.0);
        for point in &*patch {
            let near = (1.0 - (point.gap / NEAR).powi(2)).max(0.0);
            let weight = near * near + FAR;
            let weight_rate = -4.0 * point.gap / (NEAR * NEAR) * near / weight;
            (sum, height) = (sum + weight, height + weight * point.normal.dot(point.position));
            levels.push(Level { offset: 0.0, patch: all.clone(), weight, weight_rate });
        }
        for (point, level) in patch.iter_mut().zip(&mut levels[begin..]) {
            level.weight /= sum;
            level.offset = height / sum - point.normal.dot(point.position);
            point.position += point.normal * level.offset;
        }
    }
}

/// Whether two neighbours belong to one patch.
fn are_one_patch(a: &ContactPoint, b: &ContactPoint) -> bool {
    (a.body_a, a.body_b) == (b.body_a, b.body_b) && a.normal == b.normal
}

/// Takes back what [`level`] did.
pub(super) fn take_back(points: &mut [ContactPoint], levels: &[Level]) {
    points.iter_mut().zip(levels).for_each(|(point, level)| *point = level.midway(point));
}

/// Whether the heights of points differ by no more than the largest gap.
fn are_at_one_place(patch: &[ContactPoint]) -> bool {
    let (mut low, mut high, mut gap, mut size) = (f64::INFINITY, f64::NEG_INFINITY, 0.0, 0.0);
    for point in patch {
        let height = point.normal.dot(point.position);
        (low, high, gap) = (low.min(height), high.max(height), f64::max(gap, point.gap.abs()));
        size = f64::max(size, point.position.length());
    }
    high - low <= gap + LAST_DIGITS * size
}

#[cfg(test)]
mod tests {
    use signorini_multibody::glam::DVec3;
    use signorini_multibody::{BodyId, GeomId};

    use super::*;

    /// A point on a floor at a height, that a body nears to a gap.
    fn point(x: f64, height: f64, gap: f64) -> ContactPoint {
        let position = DVec3::new(x, 0.0, height + 0.5 * gap);
        ContactPoint::new([GeomId(0), GeomId(1)], [BodyId(0), BodyId(1)], position, DVec3::Z).with_gap(gap)
    }

    #[test]
    fn points_of_a_flat_patch_come_to_one_height_and_back() {
        let tilted = [point(0.0, 1.0, 1e-7), point(0.1, 1.0, 3e-7), point(0.15, 1.0, 1e-3), point(0.2, 1.0, -1e-7)];
        let (mut points, mut levels) = (tilted, Vec::new());
        level(&mut points, &mut levels);
        // What is far has next to no weight.
        assert!(points.iter().all(|p| (p.position.z - (1.0 + 0.5e-7)).abs() < 1e-12), "{points:?}");
        assert!(points.iter().all(|p| (p.position.z - points[0].position.z).abs() < 1e-15), "{points:?}");
        assert!((levels.iter().map(|level| level.weight).sum::<f64>() - 1.0).abs() < 1e-15, "{levels:?}");
        assert!(levels.iter().all(|level| level.patch == (0..4)), "{levels:?}");
        take_back(&mut points, &levels);
        assert!(points.iter().zip(&tilted).all(|(p, q)| p.position.distance(q.position) < 1e-15));
    }

    #[test]
    fn points_on_steps_and_of_other_normals_stay() {
        let stairs = [point(0.0, 1.0, 1e-6), point(0.1, 1.2, 1e-6)];
        let turned = point(0.2, 1.0, 3e-6).with_normal(DVec3::new(0.6, 0.0, 0.8));
        for before in [stairs, [point(0.0, 1.0, 1e-6), turned]] {
            let (mut points, mut levels) = (before, Vec::new());
            level(&mut points, &mut levels);
            let is_alone = |i: usize| levels[i].offset == 0.0 && levels[i].patch == (i..i + 1);
            assert!(points == before && is_alone(0) && is_alone(1), "{levels:?}");
        }
    }
}
