//! Contact points of random and degenerate pairs against an independent method. The tests run a part; all of it, with
//! a table, is `cargo run --release -p signorini-collision --example cross_check`.
//!
//! What is checked for a pair, with support functions and membership of its own (`reference.rs`):
//! - the gap is the separation of the shapes along the normal, and no direction separates them better. Where the deepest point lies on
//!   both shapes the first implies the second for shapes that are apart: their distance is at most that of the two points and
//!   at least the separation along any direction;
//! - every point lies on both shapes, and the deepest where the normal is normal to both;
//! - exchanging the shapes, or moving both together, changes nothing but the frame;
//! - no point comes twice.

mod poses;
mod reference;

use glamx::glam::DVec3;
use signorini_multibody::{ContactPoint, Geometry, Pose};

pub use poses::{Kind, MODES, Pair, pair};
use reference::{Vantage, outside};

use crate::random::Random;
use crate::scene::Scene;
use crate::support::extent;

/// Contacts are asked for up to this gap, m.
const MARGIN: f64 = 0.3;

/// How far a pair is from what it should be: lengths in m, of shapes of at most a metre.
#[derive(Clone, Copy, Debug, Default)]
pub struct Deviation {
    /// The deepest gap without its sign.
    pub distance: f64,
    /// The deepest gap from the separation along its normal.
    pub gap: f64,
    /// By how much another direction separates the shapes better.
    pub shortfall: f64,
    /// Distance of a point from a shape that it should lie on.
    pub outside: f64,
    /// Of the deepest point from where the shapes reach farthest along the normal.
    pub common_normal: f64,
    /// Change of the gap when the shapes are exchanged, or moved together.
    pub invariance: f64,
    /// Change of the normal likewise, rad; 0 where both normals separate equally well.
    pub turned: f64,
    /// Points that come twice.
    pub twice: u32,
    /// Whether the distance is proven by the points alone, to 1e-9 m.
    pub proven: bool,
}

impl Deviation {
    /// The larger of each, for the table.
    #[allow(dead_code)]
    pub fn merge(&mut self, other: &Self) {
        self.distance = self.distance.max(other.distance);
        self.gap = self.gap.max(other.gap);
        self.shortfall = self.shortfall.max(other.shortfall);
        self.outside = self.outside.max(other.outside);
        self.common_normal = self.common_normal.max(other.common_normal);
        self.invariance = self.invariance.max(other.invariance);
        self.turned = self.turned.max(other.turned);
        self.twice += other.twice;
    }
}

fn deepest(points: &[ContactPoint]) -> Option<&ContactPoint> {
    points.iter().min_by(|p, q| p.gap.total_cmp(&q.gap))
}

/// Checks one pair; nothing where the shapes are farther apart than is looked for, and no point was given.
pub fn check(pair: &Pair) -> Option<Deviation> {
    let (a, b) = ((&pair.a, &pair.x_a), (&pair.b, &pair.x_b));
    let points = Scene::new(&[pair.a.clone(), pair.b.clone()]).find(&[pair.x_a, pair.x_b], MARGIN);
    let vantage = Vantage::new(a, b);
    let Some(first) = deepest(&points) else {
        let best = vantage.best();
        assert!(best > MARGIN - 1e-6, "no contact at a separation of {best}: {pair:?}");
        return None;
    };
    let gap = (vantage.separation(first.normal) - first.gap).abs();
    let mut out = Deviation { gap, distance: first.gap.abs(), ..Deviation::default() };
    for p in &points {
        assert!((p.normal.length() - 1.0).abs() < 1e-12, "{p:?} {pair:?}");
        let half = p.normal * (0.5 * p.gap);
        out.outside = out.outside.max(outside(a, p.position - half)).max(outside(b, p.position + half));
    }
    let half = first.normal * (0.5 * first.gap);
    let (on_a, on_b) = (first.position - half, first.position + half);
    if !matches!(pair.a, Geometry::Plane) {
        out.common_normal = (extent(a.0, a.1, first.normal) - first.normal.dot(on_a)).abs();
    }
    out.common_normal = out.common_normal.max((extent(b.0, b.1, -first.normal) + first.normal.dot(on_b)).abs());
    out.proven = first.gap > 0.0 && outside(a, on_a) + outside(b, on_b) + out.gap < 1e-9;
    if !out.proven {
        out.shortfall = (vantage.best() - first.gap).max(0.0);
    }
    out.twice = twice(&points);
    compare(pair, &vantage, first, &mut out);
    Some(out)
}

/// Pairs of points with the same feature, or at the same place with the same normal.
fn twice(points: &[ContactPoint]) -> u32 {
    let same = |p: &ContactPoint, q: &ContactPoint| {
        let near = (p.position - q.position).length() < 5e-10 && (p.normal - q.normal).length() < 1e-6;
        near || p.feature == q.feature
    };
    (0..points.len()).map(|i| points[..i].iter().filter(|q| same(&points[i], q)).count() as u32).sum()
}

/// The same pair exchanged, and moved.
fn compare(pair: &Pair, vantage: &Vantage, first: &ContactPoint, out: &mut Deviation) {
    let mut note = |points: &[ContactPoint], normal: &dyn Fn(DVec3) -> DVec3| {
        let Some(other) = deepest(points) else { panic!("{pair:?}: {first:?}, but not seen otherwise") };
        let n = normal(other.normal);
        out.invariance = out.invariance.max((other.gap - first.gap).abs());
        let tie = (vantage.separation(n) - vantage.separation(first.normal)).abs() < 1e-7;
        if !tie {
            out.turned = out.turned.max(n.angle_between(first.normal));
        }
    };
    if matches!(pair.a, Geometry::Plane) {
        let motion = Pose::new(DVec3::new(1.7, -0.4, 0.0), glamx::glam::DQuat::from_rotation_z(0.9));
        let moved = Scene::new(&[pair.b.clone(), pair.a.clone()]).find(&[motion * pair.x_b, Pose::IDENTITY], MARGIN);
        note(&moved, &|n| -n);
        return;
    }
    let swapped = Scene::new(&[pair.b.clone(), pair.a.clone()]).find(&[pair.x_b, pair.x_a], MARGIN);
    note(&swapped, &|n| -n);
    let mut random = Random(pair.seed ^ 0x5eed);
    let motion = Pose::new(random.vector() * 3.0, random.rotation());
    let moved = Scene::new(&[pair.a.clone(), pair.b.clone()]).find(&[motion * pair.x_a, motion * pair.x_b], MARGIN);
    note(&moved, &|n| motion.rotation.conjugate() * n);
}

/// What a pair of shapes is allowed: polyhedra are exact, but points within 1e-8 of the size of each other are one, and the
/// closest points of nearly parallel faces are determined to 2e-7. A disc of half a metre that leans by less than 1e-6 counts as flat,
/// its lowest point as one of eight on the rim: 4e-8.
pub fn within(pair: &Pair, found: &Deviation) -> bool {
    let flat = |shape: &Geometry| matches!(shape, Geometry::Box { .. } | Geometry::ConvexMesh(_) | Geometry::Plane);
    let exact = flat(&pair.a) && flat(&pair.b);
    let (sharp, blunt) = if exact { (1e-8, 2e-7) } else { (4e-8, 1e-5) };
    let boxes = matches!((&pair.a, &pair.b), (Geometry::Box { .. }, Geometry::Box { .. }));
    // A face normal is preferred to an edge axis that is better by less than a thousandth.
    let preference = if boxes { 1.1e-3 * found.distance } else { 0.0 };
    found.gap < sharp
        && found.shortfall < 2e-8 + preference
        && found.outside < blunt
        && found.common_normal < blunt
        && found.invariance < 1e-7
        && found.turned < 1e-3
        && found.twice == 0
}

/// A few pairs of every two kinds of shapes in every sort of pose.
#[test]
fn contact_points_are_those_of_an_independent_method() {
    let mut count = 0;
    for (i, a) in Kind::all().enumerate() {
        for b in Kind::all().skip(i.max(1)) {
            for mode in MODES {
                for round in 0..10 {
                    let pair = pair(a, b, mode, (count as u64) << 8 | round);
                    let Some(found) = check(&pair) else { continue };
                    assert!(within(&pair, &found), "{found:?} {pair:?}");
                    count += 1;
                }
            }
        }
    }
    assert!(count > 2500, "{count}");
}

/// Two boxes as hulls, their edges parallel: supports along their axes may all lie on one line, from which no search starts.
#[test]
fn parallel_hulls_overlap_least_in_the_same_direction_in_every_frame() {
    let pair = pair(Kind::CuboidMesh, Kind::CuboidMesh, poses::Mode::Edges, 4_294_967_393);
    let mut random = Random(5);
    for _ in 0..2000 {
        let motion = Pose::new(random.vector() * 3.0, random.rotation());
        let points =
            Scene::new(&[pair.a.clone(), pair.b.clone()]).find(&[motion * pair.x_a, motion * pair.x_b], MARGIN);
        assert!((deepest(&points).unwrap().gap + 0.02).abs() < 1e-9, "{motion:?}: {points:?}");
    }
}
