//! Pairs whose bodies move against each other by less than they travel.

use glamx::glam::DVec3;
use signorini_collision::{Reach, RelativeMotion};
use signorini_multibody::{ContactPoint, Geometry, Pose};

use crate::random::{Random, rock};
use crate::scene::{Scene, at, cuboid};

/// The points of two bodies that both travel by `travel` (m) and of which the second one moves by `way` against the first one.
fn find(scene: &mut Scene, poses: [Pose; 2], travel: f64, way: DVec3) -> Vec<ContactPoint> {
    let body_pose = [Pose::IDENTITY, poses[0], poses[1]];
    let reach = [Reach { linear: travel, angular: 0.0 }; 3];
    let relative = |_, _| RelativeMotion { linear: [way, DVec3::ZERO], ..RelativeMotion::default() };
    let mut out = Vec::new();
    scene.collider.find_moving(&scene.model, &body_pose, (&reach, &[]), relative, &mut out);
    out
}

fn shapes() -> Vec<Geometry> {
    vec![
        cuboid(0.1, 0.2, 0.3),
        rock(),
        Geometry::Sphere { radius: 0.2 },
        Geometry::Capsule { radius: 0.1, half_length: 0.2 },
        Geometry::Cylinder { radius: 0.2, half_length: 0.1 },
    ]
}

#[test]
fn bodies_that_travel_together_find_nothing() {
    let both = [at(0.0, 0.0, 0.0), at(1.5, 0.0, 0.0)];
    for a in shapes() {
        for b in shapes() {
            let mut scene = Scene::of_moving(&[a.clone(), b]);
            assert!(!scene.find(&both, 10.0).is_empty());
            assert!(find(&mut scene, both, 5.0, DVec3::ZERO).is_empty());
        }
    }
}

/// Balls half a metre apart that fly by metres, and come nearer by no more than they move beside their common motion.
#[test]
fn what_moves_beside_a_common_motion_is_looked_for_there() {
    let mut scene = Scene::of_moving(&[Geometry::Sphere { radius: 0.2 }, Geometry::Sphere { radius: 0.2 }]);
    let body_pose = [at(0.0, 0.0, 0.0), at(0.0, 0.0, 0.0), at(0.9, 0.0, 0.0)];
    let reach = [Reach { linear: 5.0, angular: 0.1 }; 3];
    for (beside, expected) in [([].as_slice(), 1), (&[0.0, 0.2, 0.2], 0), (&[0.0, 0.2, 0.4], 1), (&[9.0; 3], 1)] {
        let relative = |_, _| RelativeMotion { linear: [-9.0 * DVec3::X; 2], ..RelativeMotion::default() };
        let mut out = Vec::new();
        scene.collider.find_moving(&scene.model, &body_pose, (&reach, beside), relative, &mut out);
        assert_eq!(out.len(), expected, "{beside:?}");
    }
}

/// What overlaps anywhere on a straight way has points before it sets out, whichever of the two is called first.
#[test]
fn what_a_motion_brings_together_is_found() {
    let mut random = Random(5);
    let (mut meet, mut spared) = (0, 0);
    for a in shapes() {
        for b in shapes() {
            let mut scene = Scene::of_moving(&[a.clone(), b]);
            for _ in 0..40 {
                let apart = 0.9 * random.vector();
                let poses = [Pose::new(DVec3::ZERO, random.rotation()), Pose::new(apart, random.rotation())];
                let way = random.vector() - 0.7 * apart;
                let travel = way.length();
                let overlaps = |scene: &mut Scene, part: f64| {
                    let moved = Pose::new(apart + part * way, poses[1].rotation);
                    scene.find(&[poses[0], moved], 0.0).iter().any(|point| point.gap < -1e-6)
                };
                let meets = (0..=30).any(|k| overlaps(&mut scene, f64::from(k) / 30.0));
                let all = scene.find(&poses, 2.0 * travel);
                let found = find(&mut scene, poses, travel, way);
                assert!(!meets || !found.is_empty(), "{poses:?}, {way:?}");
                meet += usize::from(meets);
                spared += usize::from(found.is_empty() && !all.is_empty());
            }
        }
    }
    assert!(meet > 200 && spared > 200, "{meet} meet, {spared} are spared");
}

/// A small round shape beside a large one comes nearer along the line of their centres by what it moves along it, by what it is carried along it where it turns, and by
/// what it does besides: they have a contact where that is as much as what is between them and their margins, and none otherwise.
#[test]
fn a_pair_is_searched_as_far_as_it_can_come_together() {
    let mut random = Random(6);
    let [small, large] = [0.1, 0.4];
    let mut counts = [0; 2];
    for case in 0..600 {
        let round = |radius| Geometry::Ellipsoid { semi_axes: DVec3::splat(radius) };
        let mut scene = Scene::of_moving(&[round(small), round(large)]);
        let margins = [0.0, 0.02 * random.unit()][case % 2];
        scene.model.geoms[case % 2].margin = margins;
        scene.collider.take_laws(&scene.model);
        let gap = 0.05 + 0.2 * random.unit();
        let n = random.vector().normalize();
        let mut body_pose = [Pose::IDENTITY, Pose::from_position(random.vector()), Pose::IDENTITY];
        body_pose[2].position = body_pose[1].position + n * (small + large + gap);
        let wanted = |k: usize| (case / 2 % 16) & (1 << k) != 0;
        let part = |k: usize, random: &mut Random| if wanted(k) { gap * random.unit() } else { 0.0 };
        let motion = RelativeMotion {
            linear: [0, 1].map(|_| n.any_orthonormal_vector() * 0.1 - n * part(0, &mut random)),
            angular: [0, 1].map(|_| n * 2.0 + n.any_orthonormal_vector() * (part(1, &mut random) / small)),
            besides: Reach { linear: part(2, &mut random), angular: part(3, &mut random) / small },
        };
        let reach = [Reach { linear: 5.0, angular: 0.0 }; 3];
        let mut out = Vec::new();
        let place = body_pose[1].position;
        let relative = |_, at: DVec3| {
            assert!((at - place).length() < 1e-12, "the place is the centre of the smaller one");
            motion
        };
        scene.collider.find_moving(&scene.model, &body_pose, (&reach, &[]), relative, &mut out);
        let [known] = scene.collider.pair_reaches() else { panic!("one pair") };
        assert!(known.radius >= small && known.radius < 2.0 * small);
        let nearer = [0, 1].map(|k| {
            let carried = motion.angular[k].cross(n).length() + motion.besides.angular;
            carried * known.radius - motion.linear[k].dot(n) + motion.besides.linear
        });
        let can_touch = nearer[0].max(nearer[1]) >= gap - margins;
        assert_eq!(!out.is_empty(), can_touch, "case {case}: {nearer:?} of {gap} less {margins}");
        counts[usize::from(can_touch)] += 1;
    }
    assert!(counts.iter().all(|count| *count > 100), "{counts:?}");
}
