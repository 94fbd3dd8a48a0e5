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
