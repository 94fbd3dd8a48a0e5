//! A contact patch is a patch: of many points with one normal between two shapes a few hold as all do.
//!
//! The corners of a face that lies flat share its load, and any of them whose polygon has the same reach in all directions can carry the same
//! force and moments. The deepest point and the outermost ones stay; the others are watched like all points that a step's problem leaves out
//! (`candidates.rs`): one that the velocity found would close comes back in.

use signorini_multibody::ContactPoint;
use signorini_multibody::glam::{DVec2, DVec3};

/// Normals of one patch differ by rounding.
const SAME_NORMAL: f64 = 1e-9;

/// Buffers of the choice.
#[derive(Clone, Debug, Default)]
pub(crate) struct Patches {
    points: Vec<usize>,
    flat: Vec<DVec2>,
    kept: Vec<usize>,
}

impl Patches {
    /// Leaves at most `most` chosen points to every pair of geoms whose chosen points have one normal; all where `most` is 0.
    ///
    /// - `all`: points in order of their pairs; `chosen`: which of them the problem is to have
    /// - `stays`: points that are left as they are, beside the others
    pub fn limit(
        &mut self,
        all: &[ContactPoint],
        chosen: &mut [bool],
        most: usize,
        stays: impl Fn(&ContactPoint) -> bool,
    ) {
        if most == 0 || all.len() <= most {
            return;
        }
        let mut start = 0;
        for pair in all.chunk_by(|p, q| (p.geom_a, p.geom_b) == (q.geom_a, q.geom_b)) {
            if pair.len() > most {
                self.limit_pair(pair, &mut chosen[start..start + pair.len()], most, &stays);
            }
            start += pair.len();
        }
    }

    fn limit_pair(
        &mut self,
        pair: &[ContactPoint],
        chosen: &mut [bool],
        most: usize,
        stays: impl Fn(&ContactPoint) -> bool,
    ) {
        self.points.clear();
        self.points.extend((0..pair.len()).filter(|&i| chosen[i] && !stays(&pair[i])));
        let normal = pair[0].normal;
        if self.points.len() <= most || pair.iter().any(|p| p.normal.dot(normal) < 1.0 - SAME_NORMAL) {
            return;
        }
        self.flatten(pair, normal);
        self.choose(pair, most);
        for &i in &self.points {
            chosen[i] = false;
        }
        for &at in &self.kept {
            chosen[self.points[at]] = true;
        }
    }

    /// The points in the contact plane, about their middle.
    fn flatten(&mut self, pair: &[ContactPoint], normal: DVec3) {
        let u = normal.any_orthonormal_vector();
        let v = normal.cross(u);
        let sum: DVec3 = self.points.iter().map(|&i| pair[i].position).sum();
        let middle = sum / self.points.len() as f64;
        self.flat.clear();
        self.flat.extend(self.points.iter().map(|&i| {
            let from = pair[i].position - middle;
            DVec2::new(u.dot(from), v.dot(from))
        }));
    }

    /// The deepest point, then the outermost in directions that halve the angles between its own and those before.
    fn choose(&mut self, pair: &[ContactPoint], most: usize) {
        let Self { points, flat, kept } = self;
        kept.clear();
        let gap = |at: &usize| pair[points[*at]].gap;
        kept.extend((0..points.len()).min_by(|p, q| gap(p).total_cmp(&gap(q))));
        let first = kept.first().map_or(DVec2::X, |at| flat[*at].normalize_or(DVec2::X));
        let mut turns = 0;
        while kept.len() < most && turns < 4 * most {
            // Fractions of a turn in the order of van der Corput: 0, 1/2, 1/4, 3/4, 1/8, …
            let part = f64::from((turns as u32).reverse_bits()) / 2f64.powi(32);
            let direction = DVec2::from_angle(std::f64::consts::TAU * part).rotate(first);
            let reach = |at: &usize| direction.dot(flat[*at]);
            let outermost = (0..flat.len()).max_by(|p, q| reach(p).total_cmp(&reach(q)));
            kept.extend(outermost.filter(|at| !kept.contains(at)));
            turns += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use signorini_multibody::{BodyId, GeomId};

    use super::*;

    /// Points on a ring that leans, one of them deepest.
    fn ring(count: usize) -> Vec<ContactPoint> {
        let point = |k: usize| {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / count as f64).sin_cos();
            ContactPoint::new([GeomId(0), GeomId(1)], [BodyId(0), BodyId(1)], DVec3::new(cos, sin, 0.0), DVec3::Z)
                .with_gap(1e-6 * (1.0 + (sin - 0.3 * cos)))
                .with_feature(k as u32)
        };
        (0..count).map(point).collect()
    }

    fn area(points: &[&ContactPoint]) -> f64 {
        let corner = |k: usize| points[k % points.len()].position;
        (0..points.len()).map(|k| 0.5 * corner(k).cross(corner(k + 1)).z).sum()
    }

    #[test]
    fn a_patch_of_eight_points_keeps_area_and_deepest_point() {
        let points = ring(60);
        let mut chosen = vec![true; 60];
        Patches::default().limit(&points, &mut chosen, 8, |_| false);
        let kept: Vec<&ContactPoint> = points.iter().zip(&chosen).filter(|(_, c)| **c).map(|(p, _)| p).collect();
        assert_eq!(kept.len(), 8);
        let deepest = points.iter().min_by(|p, q| p.gap.total_cmp(&q.gap)).unwrap();
        assert!(kept.iter().any(|p| p.feature == deepest.feature));
        // A regular octagon has 90 % of its circle; the corners are at most 3 degrees beside its.
        assert!(area(&kept) > 0.89 * std::f64::consts::PI, "{}", area(&kept));
    }

    #[test]
    fn other_normals_points_that_stay_and_zero_are_left_alone() {
        let points = ring(20);
        let limited = |points: &[ContactPoint], most: usize, stays: fn(&ContactPoint) -> bool| {
            let mut chosen = vec![true; points.len()];
            Patches::default().limit(points, &mut chosen, most, stays);
            chosen.iter().filter(|c| **c).count()
        };
        assert_eq!(limited(&points, 0, |_| false), 20);
        assert_eq!(limited(&points, 8, |_| false), 8);
        assert_eq!(limited(&points, 8, |p| p.feature < 3), 11);
        let mut bent = points.clone();
        bent[4].normal = DVec3::X;
        assert_eq!(limited(&bent, 8, |_| false), 20);
    }
    #[test]
    fn pairs_are_limited_each_by_itself() {
        let of = |pair: u32, count: usize| {
            let mut points = ring(count);
            points.iter_mut().for_each(|point| (point.geom_a, point.geom_b) = (GeomId(pair), GeomId(pair + 7)));
            points
        };
        let pairs = [of(0, 20), of(1, 5), of(2, 33), of(3, 12)];
        let kept = |points: &[ContactPoint]| {
            let mut chosen = vec![true; points.len()];
            Patches::default().limit(points, &mut chosen, 8, |_| false);
            chosen
        };
        assert_eq!(kept(&pairs.concat()), pairs.each_ref().map(|pair| kept(pair)).concat());
    }
}
