//! Seeded random poses against support functions and brute force.

use std::sync::Arc;

use glamx::glam::{DQuat, DVec3};
use signorini_multibody::model::Mesh;
use signorini_multibody::{ContactPoint, Geometry, Pose};

use crate::scene::{Scene, cuboid, smallest_gap};
use crate::support::{directions, extent, largest_separation, separation};

/// A small generator of random numbers (SplitMix64; Steele, Lea, Flood 2014).
pub struct Random(pub u64);

impl Random {
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    pub fn vector(&mut self) -> DVec3 {
        DVec3::new(self.signed(), self.signed(), self.signed())
    }

    pub fn rotation(&mut self) -> DQuat {
        let q = DQuat::from_xyzw(self.signed(), self.signed(), self.signed(), self.signed());
        if q.length() < 0.1 { DQuat::IDENTITY } else { q.normalize() }
    }
}

/// An irregular polyhedron.
pub fn rock() -> Geometry {
    let mut random = Random(7);
    let vertices = (0..14).map(|_| random.vector().normalize() * DVec3::new(0.5, 0.4, 0.3)).collect();
    Geometry::ConvexMesh(Arc::new(Mesh { vertices, triangles: Vec::new() }))
}

/// A box as a mesh.
pub fn cuboid_mesh(half: DVec3) -> Geometry {
    let corner = |k: u32| {
        let s = |bit: u32| if k & bit != 0 { 1.0 } else { -1.0 };
        half * DVec3::new(s(1), s(2), s(4))
    };
    Geometry::ConvexMesh(Arc::new(Mesh { vertices: (0..8).map(corner).collect(), triangles: Vec::new() }))
}

pub fn convex_shapes() -> Vec<Geometry> {
    vec![
        Geometry::Sphere { radius: 0.4 },
        cuboid(0.5, 0.3, 0.2),
        Geometry::Capsule { radius: 0.2, half_length: 0.4 },
        Geometry::Cylinder { radius: 0.3, half_length: 0.4 },
        Geometry::Cone { radius: 0.4, half_length: 0.5 },
        Geometry::Ellipsoid { semi_axes: DVec3::new(0.5, 0.3, 0.2) },
        rock(),
    ]
}

/// A random pose of B at which it is `gap` from A along the direction that separates them best before the approach.
fn placed_at(random: &mut Random, a: &Geometry, x_a: &Pose, b: &Geometry, gap: f64) -> Pose {
    let mut pose = Pose::new(x_a.position + random.vector().normalize() * 1.5, random.rotation());
    let (apart, n) = largest_separation((a, x_a), (b, &pose));
    pose.position += n * (gap - apart);
    pose
}

fn deepest(points: &[ContactPoint]) -> &ContactPoint {
    points.iter().min_by(|p, q| p.gap.total_cmp(&q.gap)).unwrap()
}

/// For every pair of convex shapes, apart and overlapping: the gap is the separation along the normal, no direction
/// separates better, and every point lies on (or in) both shapes.
#[test]
fn gap_is_the_largest_separation_of_random_convex_pairs() {
    let shapes = convex_shapes();
    let mut random = Random(1);
    for (i, a) in shapes.iter().enumerate() {
        for b in &shapes[i..] {
            let mut scene = Scene::new(&[a.clone(), b.clone()]);
            for round in 0..24 {
                let gap = [0.1, 0.01, 1e-3, -1e-3, -0.02, -0.08][round % 6];
                let x_a = Pose::new(random.vector(), random.rotation());
                let x_b = placed_at(&mut random, a, &x_a, b, gap);
                check_pair(&mut scene, (a, &x_a), (b, &x_b));
            }
        }
    }
}

fn check_pair(scene: &mut Scene, a: (&Geometry, &Pose), b: (&Geometry, &Pose)) {
    let name = format!("{} at {:?}, {} at {:?}", a.0.kind_name(), a.1, b.0.kind_name(), b.1);
    let points = scene.find(&[*a.1, *b.1], 0.3);
    assert!(!points.is_empty(), "{name}");
    let first = deepest(&points);
    let own = separation(a, b, first.normal);
    assert!((own - first.gap).abs() < 2e-8, "{name}: gap {} but separation {own} along its normal", first.gap);
    let best = largest_separation(a, b).0;
    assert!(first.gap > best - 2e-8 - 1.1e-3 * best.abs(), "{name}: gap {} but {best} is possible", first.gap);
    assert!((first.normal.length() - 1.0).abs() < 1e-12);
    // Closest points of curved shapes are found less sharply than their distance.
    let flat = |shape: &Geometry| matches!(shape, Geometry::Box { .. } | Geometry::ConvexMesh(_));
    let tolerance = if flat(a.0) && flat(b.0) { 1e-8 } else { 1e-5 };
    for p in &points {
        let (on_a, on_b) = (p.position - p.normal * (0.5 * p.gap), p.position + p.normal * (0.5 * p.gap));
        for d in directions(300) {
            assert!(d.dot(on_a) <= extent(a.0, a.1, d) + tolerance, "{name}: {p:?} is not on A");
            assert!(d.dot(on_b) <= extent(b.0, b.1, d) + tolerance, "{name}: {p:?} is not on B");
        }
    }
}

/// An irregular polyhedron of many small faces and of a few large ones.
fn boulder(random: &mut Random) -> Geometry {
    let vertices = (0..80).map(|k| {
        let unit = random.vector().normalize_or(DVec3::Z);
        if k < 60 { 0.4 * unit.with_z(unit.z.abs()) } else { DVec3::new(0.6, 0.5, 0.3) * unit }
    });
    Geometry::ConvexMesh(Arc::new(Mesh { vertices: vertices.collect(), triangles: Vec::new() }))
}

/// Bodies at rest move by rounding. Where that changed the points in which polyhedra touch, a heap at rest would be another problem in every step.
#[test]
fn points_of_polyhedra_stay_where_these_move_by_rounding() {
    let mut random = Random(8);
    let mut found = 0;
    for round in 0..300 {
        let [a, b] = if round % 3 == 0 { [rock(), rock()] } else { [(); 2].map(|()| boulder(&mut random)) };
        let x_a = Pose::new(random.vector(), random.rotation());
        let x_b = placed_at(&mut random, &a, &x_a, &b, [0.0, 1e-3, -1e-7][round % 3]);
        let mut scene = Scene::new(&[a, b]);
        let points = scene.find(&[x_a, x_b], 0.03);
        found += points.len();
        for _ in 0..8 {
            let by_rounding = |pose: &Pose, random: &mut Random| {
                let turn = DQuat::from_scaled_axis(1e-13 * random.vector());
                Pose::new(pose.position + 1e-13 * random.vector(), (turn * pose.rotation).normalize())
            };
            let moved = [x_a, x_b].map(|pose| by_rounding(&pose, &mut random));
            let again = scene.find(&moved, 0.03);
            let features = |points: &[ContactPoint]| points.iter().map(|p| p.feature).collect::<Vec<_>>();
            assert_eq!(features(&points), features(&again), "round {round}: {points:?} {again:?}");
            let apart = points.iter().zip(&again).map(|(p, q)| (p.position - q.position).length());
            assert!(apart.fold(0.0, f64::max) < 1e-8, "round {round}");
        }
    }
    assert!(found > 600, "{found}");
}

/// Poses on a grid, turned by multiples of 45°: parallel edges, coinciding planes and axes, ties everywhere.
#[test]
fn symmetric_poses_are_not_special() {
    let shapes = convex_shapes();
    let mut random = Random(6);
    for (i, a) in shapes.iter().enumerate() {
        for b in &shapes[i..] {
            let mut scene = Scene::new(&[a.clone(), b.clone()]);
            for _ in 0..40 {
                let mut eighths = || (random.unit() * 8.0).floor() * std::f64::consts::FRAC_PI_4;
                let rotation = DQuat::from_rotation_z(eighths()) * DQuat::from_rotation_x(eighths());
                let place = |x: f64| (x * 4.0).round() * 0.1;
                let position = DVec3::new(place(random.signed()), place(random.signed()), place(random.signed()));
                let (x_a, x_b) = (Pose::IDENTITY, Pose::new(position, rotation));
                if separation_is_near(largest_separation((a, &x_a), (b, &x_b)).0) {
                    check_pair(&mut scene, (a, &x_a), (b, &x_b));
                }
            }
        }
    }
}

/// Within the margin of [`check_pair`], and not so deep that bodies of revolution on one axis have a whole ring of
/// directions of least overlap.
fn separation_is_near(gap: f64) -> bool {
    (-0.2..0.29).contains(&gap)
}

#[test]
fn exchanging_the_shapes_flips_the_normal() {
    let shapes = convex_shapes();
    let mut random = Random(2);
    for a in &shapes {
        for b in &shapes {
            let (mut forth, mut back) = (Scene::new(&[a.clone(), b.clone()]), Scene::new(&[b.clone(), a.clone()]));
            for round in 0..6 {
                let x_a = Pose::new(random.vector(), random.rotation());
                let x_b = placed_at(&mut random, a, &x_a, b, [0.05, -0.01][round % 2]);
                let (p, q) = (forth.find(&[x_a, x_b], 0.2), back.find(&[x_b, x_a], 0.2));
                let (p, q) = (deepest(&p), deepest(&q));
                let name = format!("{} {}", a.kind_name(), b.kind_name());
                assert!((p.gap - q.gap).abs() < 1e-7, "{name}: {p:?} {q:?}");
                assert!((p.normal + q.normal).length() < 1e-3, "{name}: {p:?} {q:?}");
            }
        }
    }
}

/// Of shapes of a metre. A patch that is deeper than the separation by a hundred-millionth of the size stands for it, and whether one is may
/// depend on rounding.
#[test]
fn moving_both_shapes_together_moves_the_points_along() {
    let shapes = convex_shapes();
    for seed in 3..11 {
        let mut random = Random(seed);
        for (i, a) in shapes.iter().enumerate() {
            for b in &shapes[i..] {
                let mut scene = Scene::new(&[a.clone(), b.clone()]);
                for round in 0..6 {
                    let x_a = Pose::new(random.vector(), random.rotation());
                    let x_b = placed_at(&mut random, a, &x_a, b, [0.05, -0.01][round % 2]);
                    let motion = Pose::new(random.vector() * 10.0, random.rotation());
                    let (p, q) = (scene.find(&[x_a, x_b], 0.2), scene.find(&[motion * x_a, motion * x_b], 0.2));
                    let name = format!("{} {}, seed {seed}", a.kind_name(), b.kind_name());
                    assert!((smallest_gap(&p) - smallest_gap(&q)).abs() < 1.5e-8, "{name}: {p:?} {q:?}");
                    let (p, q) = (deepest(&p), deepest(&q));
                    assert!((motion.rotation * p.normal - q.normal).length() < 1e-4, "{name}: {p:?} {q:?}");
                }
            }
        }
    }
}

#[test]
fn a_box_and_its_hull_agree() {
    let (half_a, half_b) = (DVec3::new(0.5, 0.3, 0.2), DVec3::new(0.1, 0.4, 0.3));
    let [a, b] = [half_a, half_b].map(|half_extents| Geometry::Box { half_extents });
    let (hull_a, hull_b) = (cuboid_mesh(half_a), cuboid_mesh(half_b));
    let (mut boxes, mut hulls) = (Scene::new(&[a.clone(), b.clone()]), Scene::new(&[hull_a, hull_b]));
    let mut random = Random(4);
    for round in 0..300 {
        let x_a = Pose::new(random.vector(), random.rotation());
        let x_b = placed_at(&mut random, &a, &x_a, &b, [0.05, 1e-4, -1e-4, -0.03][round % 4]);
        let (p, q) = (boxes.find(&[x_a, x_b], 0.1), hulls.find(&[x_a, x_b], 0.1));
        let (p, q) = (deepest(&p), deepest(&q));
        // The boxes may prefer a face to an edge that separates better by a thousandth.
        assert!((p.gap - q.gap).abs() < 1e-7 + 1.1e-3 * q.gap.abs(), "{p:?} {q:?}");
    }
}

#[test]
fn the_result_depends_on_the_poses_alone() {
    let shapes = convex_shapes();
    let mut random = Random(5);
    let mut used = Scene::new(&shapes);
    for _ in 0..20 {
        let poses: Vec<Pose> = shapes.iter().map(|_| Pose::new(random.vector() * 0.6, random.rotation())).collect();
        let found = used.find(&poses, 0.05);
        assert_eq!(found, Scene::new(&shapes).find(&poses, 0.05));
        let keys: Vec<_> = found.iter().map(|p| (p.geom_a, p.geom_b, p.feature)).collect();
        assert!(keys.windows(2).all(|w| w[0] < w[1]), "sorted and unique: {keys:?}");
    }
}
