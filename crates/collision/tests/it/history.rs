//! A search knows nothing of the searches before it, although it keeps their order.

use glamx::glam::{DQuat, DVec3};
use signorini_collision::{Collider, Reach};
use signorini_multibody::{ContactPoint, GeomId, Geometry, Pose};

use crate::random::{Random, rock};
use crate::scene::{Scene, contacts, cuboid};

const COUNT: usize = 24;

fn shapes(random: &mut Random) -> Vec<Geometry> {
    let size = |random: &mut Random| 0.1 + 0.2 * random.unit();
    let shape = |random: &mut Random, k: usize| match k % 4 {
        0 => Geometry::Sphere { radius: size(random) },
        1 => cuboid(size(random), size(random), size(random)),
        2 => Geometry::Cylinder { radius: size(random), half_length: size(random) },
        _ => rock(),
    };
    let bodies = (0..COUNT).map(|k| shape(random, k)).collect::<Vec<_>>();
    [vec![Geometry::Plane], bodies].concat()
}

/// Poses in a box that is long in x, then in z; mostly small steps, now and then everything anew, once a pose that is none.
fn walk(random: &mut Random, poses: &mut [Pose], step: usize) {
    for pose in poses.iter_mut().skip(1) {
        if step.is_multiple_of(50) {
            let extent = if step < 100 { DVec3::new(3.0, 0.5, 0.3) } else { DVec3::new(0.5, 0.5, 3.0) };
            *pose = Pose::new(random.vector() * extent, random.rotation());
        } else {
            pose.position += random.vector() * 0.02;
            pose.rotation = (pose.rotation * DQuat::from_scaled_axis(random.vector() * 0.05)).normalize();
        }
    }
    if step == 75 {
        poses[COUNT / 2].position.y = f64::NAN;
    } else if step == 76 {
        poses[COUNT / 2].position.y = 0.1;
    }
}

fn same_bits(a: &[ContactPoint], b: &[ContactPoint]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a == b && a.gap.to_bits() == b.gap.to_bits())
}

#[test]
fn the_answer_depends_on_the_poses_alone() {
    let mut random = Random(3);
    let mut scene = Scene::new(&shapes(&mut random));
    let mut poses = vec![Pose::IDENTITY; COUNT + 1];
    let mut most = 0;
    for step in 0..200 {
        walk(&mut random, &mut poses, step);
        let found = scene.find(&poses, 0.05);
        let experienced = std::mem::replace(&mut scene.collider, Collider::new(&scene.model).unwrap());
        let afresh = scene.find(&poses, 0.05);
        scene.collider = experienced;
        assert!(same_bits(&found, &afresh), "step {step}: {} and {} points", found.len(), afresh.len());
        most = most.max(found.len());
    }
    assert!(most > 20, "the scene should be crowded, but had {most} points");
}

/// Pairs that stand still for a while, between some that move; margins, friction and single pairs in between.
#[test]
fn what_stands_still_is_found_as_by_a_collider_that_never_saw_it() {
    let mut random = Random(5);
    let mut scene = Scene::new(&shapes(&mut random));
    let mut poses = vec![Pose::IDENTITY; COUNT + 1];
    walk(&mut random, &mut poses, 0);
    let (mut stood, mut most) = (0, 0);
    let mut before = Vec::new();
    for step in 1..300 {
        for pose in poses.iter_mut().skip(1) {
            if random.unit() < 0.05 {
                pose.position += random.vector() * 0.02;
            }
        }
        let margin = if step % 40 < 30 { 0.05 } else { 0.1 };
        if step % 31 == 0 {
            scene.model.geoms[3].friction += 0.1;
            scene.collider.take_laws(&scene.model);
        }
        if step % 7 == 0 {
            let elsewhere: Vec<Pose> = scene.model.bodies.iter().map(|_| Pose::IDENTITY).collect();
            let reach = vec![Reach::default(); elsewhere.len()];
            let pair = [GeomId(2), GeomId(3)];
            scene.collider.find_pair(&scene.model, &elsewhere, &reach, pair, &mut Vec::new());
        }
        let found = scene.find(&poses, margin);
        let experienced = std::mem::replace(&mut scene.collider, Collider::new(&scene.model).unwrap());
        let afresh = scene.find(&poses, margin);
        scene.collider = experienced;
        assert!(same_bits(&found, &afresh), "step {step}: {} and {} points", found.len(), afresh.len());
        stood += found.iter().filter(|point| before.contains(*point)).count();
        most = most.max(found.len());
        before = found;
    }
    assert!(most > 20 && stood > 1000, "{stood} of at most {most} points a step stood still");
}

#[test]
fn every_pair_is_found_that_touches_when_it_is_alone() {
    let mut random = Random(4);
    let shapes = shapes(&mut random);
    let mut scene = Scene::new(&shapes);
    let mut poses = vec![Pose::IDENTITY; COUNT + 1];
    for step in 0..4 {
        walk(&mut random, &mut poses, 50 * step);
        let found = scene.find(&poses, 0.05);
        let places = |points: &[ContactPoint]| points.iter().map(|p| (p.position, p.gap)).collect::<Vec<_>>();
        let mut expected = Vec::new();
        for i in 0..=COUNT {
            for j in i + 1..=COUNT {
                expected.extend(places(&contacts(&shapes[i], poses[i], &shapes[j], poses[j], 0.05)));
            }
        }
        assert_eq!(places(&found), expected, "step {step}");
    }
}
