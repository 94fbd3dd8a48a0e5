//! A search knows nothing of the searches before it, although it keeps their order.

use glamx::glam::{DMat3, DQuat, DVec3};
use signorini_collision::{Collider, Reach};
use signorini_multibody::{
    BodyId, ContactPoint, Geom, GeomId, Geometry, Inertia, Joint, JointKind, ModelBuilder, Pose,
};

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

/// A terrain of fixed shapes, some on the world and some on bodies welded to it, one of which is set aside now and then.
#[test]
fn a_terrain_meets_what_each_of_its_parts_would_meet_alone() {
    let mut random = Random(9);
    let mut builder = ModelBuilder::new("terrain");
    let geom = |random: &mut Random, k: usize| {
        let mut geom = Geom::new(format!("g{k}"), shapes(random)[k % COUNT + 1].clone());
        geom.placement = Pose::new(random.vector(), random.rotation());
        geom
    };
    for k in 0..80 {
        let body = if k % 3 > 0 {
            BodyId::WORLD
        } else {
            builder
                .add_body(
                    format!("b{k}"),
                    BodyId::WORLD,
                    Pose::IDENTITY,
                    Inertia { mass: 0.0, center_of_mass: DVec3::ZERO, rotational: DMat3::ZERO },
                )
                .unwrap()
        };
        builder.add_geom(body, geom(&mut random, k)).unwrap();
    }
    let inertia = Inertia { mass: 1.0, center_of_mass: DVec3::ZERO, rotational: DMat3::IDENTITY };
    for k in 80..92 {
        let body = builder.add_body(format!("b{k}"), BodyId::WORLD, Pose::IDENTITY, inertia).unwrap();
        builder.add_joint(body, Joint::new(format!("j{k}"), JointKind::Free)).unwrap();
        builder.add_geom(body, geom(&mut random, k)).unwrap();
    }
    let model = builder.build().unwrap();
    let mut collider = Collider::new(&model).unwrap();
    let reach = vec![Reach { linear: 0.02, angular: 0.0 }; model.bodies.len()];
    let mut poses = vec![Pose::IDENTITY; model.bodies.len()];
    let (mut found, mut alone, mut most) = (Vec::new(), Vec::new(), 0);
    for step in 0..30 {
        for (pose, weld) in poses.iter_mut().zip(&model.body_weld) {
            if *weld != BodyId::WORLD && random.unit() < 0.7 {
                *pose = Pose::new(0.8 * random.vector(), random.rotation());
            }
        }
        poses[1].position.x = f64::from(step / 10);
        collider.find(&model, &poses, &reach, &mut found);
        let mut expected = Vec::new();
        for (i, j) in (0..92).flat_map(|i| (i.max(79) + 1..92).map(move |j| (i, j))) {
            let mut afresh = Collider::new(&model).unwrap();
            afresh.find_pair(&model, &poses, &reach, [GeomId(i), GeomId(j)], &mut alone);
            expected.append(&mut alone);
        }
        assert!(same_bits(&found, &expected), "step {step}: {} and {} points", found.len(), expected.len());
        most = most.max(found.len());
    }
    assert!(most > 50, "the terrain should be touched, but was in at most {most} points");
}

/// Bodies that stand are searched against those that move, and not against each other; who stands changes.
#[test]
fn what_stands_is_searched_against_what_moves() {
    let mut random = Random(10);
    let mut scene = Scene::new(&shapes(&mut random));
    let mut poses = vec![Pose::IDENTITY; COUNT + 1];
    walk(&mut random, &mut poses, 0);
    let (mut between, mut left) = (0, 0);
    let mut stands = vec![false; COUNT + 1];
    for step in 0..120 {
        if step % 6 == 0 {
            stands = (0..=COUNT).map(|_| step % 24 > 0 && random.unit() < 0.7).collect();
            let bodies = &scene.bodies;
            let is_standing = |body: BodyId| (1..=COUNT).any(|k| bodies[k] == body.index() && stands[k]);
            scene.collider.let_stand(is_standing);
        }
        for (pose, _) in poses.iter_mut().zip(&stands).skip(1).filter(|(_, stands)| !**stands) {
            pose.position += random.vector() * 0.02;
        }
        let found = scene.find(&poses, 0.05);
        let experienced = std::mem::replace(&mut scene.collider, Collider::new(&scene.model).unwrap());
        let mut expected = scene.find(&poses, 0.05);
        scene.collider = experienced;
        let before = expected.len();
        // The ground moves as little as what stands.
        let moves = |geom: GeomId| geom.index() > 0 && !stands[geom.index()];
        expected.retain(|p| moves(p.geom_a) || moves(p.geom_b));
        assert!(same_bits(&found, &expected), "step {step}: {} and {} points", found.len(), expected.len());
        between += expected.iter().filter(|p| moves(p.geom_a) != moves(p.geom_b)).count();
        left += before - expected.len();
    }
    assert!(between > 300 && left > 300, "{between} between, {left} left out");
}

/// Pairs that are excluded after a search touch no more, down to the last one.
#[test]
fn excluded_pairs_touch_no_more() {
    let mut scene = Scene::new(&vec![Geometry::Sphere { radius: 0.5 }; 5]);
    let poses: Vec<Pose> = (0..5).map(|k| Pose::from_position(0.1 * f64::from(k) * DVec3::X)).collect();
    let mut left = scene.find(&poses, 1e-3);
    assert_eq!(left.len(), 10);
    while let Some(point) = left.pop() {
        scene.collider.exclude([[point.geom_b, point.geom_a]]);
        assert!(same_bits(&scene.find(&poses, 1e-3), &left), "{} points are left", left.len());
    }
}
