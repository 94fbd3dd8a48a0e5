//! What a time step asks of the search: reach, filters, friction, order.

use glamx::glam::{DMat3, DVec3};
use signorini_collision::{Collider, CollisionError, Reach};
use signorini_multibody::model::Mesh;
use signorini_multibody::{
    BodyId, ContactPoint, Geom, GeomId, GeomPair, Geometry, Inertia, Joint, JointKind, Model, ModelBuilder, Pose,
};

use crate::random::Random;
use crate::scene::{Scene, assert_close, at, cuboid};

fn free_body(builder: &mut ModelBuilder, name: &str) -> BodyId {
    let inertia = Inertia { mass: 1.0, center_of_mass: DVec3::ZERO, rotational: DMat3::IDENTITY };
    let body = builder.add_body(name, BodyId::WORLD, Pose::IDENTITY, inertia).unwrap();
    builder.add_joint(body, Joint::new(format!("{name} joint"), JointKind::Free)).unwrap();
    body
}

fn find(model: &Model, poses: &[Pose], reach: &[Reach]) -> Vec<ContactPoint> {
    let mut out = Vec::new();
    Collider::new(model).unwrap().find(model, poses, reach, &mut out);
    out
}

/// A wall 1 mm thick and something that flies at 300 m/s with steps of 10 ms: 3 m per step.
#[test]
fn what_flies_through_a_thin_wall_within_the_step_is_found() {
    for shape in [
        Geometry::Sphere { radius: 0.01 },
        cuboid(0.01, 0.02, 0.005),
        Geometry::Capsule { radius: 0.01, half_length: 0.02 },
    ] {
        let mut builder = ModelBuilder::new("shot");
        builder.add_geom(BodyId::WORLD, Geom::new("wall", cuboid(0.0005, 1.0, 1.0))).unwrap();
        let body = free_body(&mut builder, "bullet");
        builder.add_geom(body, Geom::new("shape", shape)).unwrap();
        let model = builder.build().unwrap();
        let moving = [Reach::default(), Reach { linear: 3.0, angular: 0.1 }];
        for distance in [0.1, 1.0, 2.9] {
            let poses = [Pose::IDENTITY, at(-distance, 0.2, 0.1)];
            let p = find(&model, &poses, &moving);
            assert!(p.iter().any(|c| c.gap > 0.0 && c.gap <= distance && c.normal.x < -0.9), "{distance}: {p:?}");
            assert!(find(&model, &poses, &[Reach::default(); 2]).is_empty());
        }
    }
}

/// A long rod that turns reaches with its tip what its origin is far from.
#[test]
fn turning_counts_by_the_farthest_point() {
    let mut builder = ModelBuilder::new("rod");
    builder.add_geom(BodyId::WORLD, Geom::new("floor", Geometry::Plane)).unwrap();
    let body = free_body(&mut builder, "rod");
    let mut rod = Geom::new("rod", cuboid(0.5, 0.01, 0.01));
    rod.placement = at(0.5, 0.0, 0.0);
    builder.add_geom(body, rod).unwrap();
    let model = builder.build().unwrap();
    let poses = [Pose::IDENTITY, at(0.0, 0.0, 0.11)];
    let turning = |angular: f64| find(&model, &poses, &[Reach::default(), Reach { linear: 0.0, angular }]);
    assert!(!turning(0.101).is_empty(), "the tip is 1 m out and 0.1 m up");
    assert!(turning(0.09).is_empty());
}

#[test]
fn every_pair_within_the_margin_is_found_and_no_other() {
    let mut random = Random(31);
    let shapes = vec![cuboid(0.1, 0.1, 0.1); 60];
    let mut scene = Scene::new(&shapes);
    for margin in [0.0, 0.05, 0.2] {
        let poses: Vec<Pose> = shapes.iter().map(|_| Pose::new(random.vector(), random.rotation())).collect();
        let found = scene.find(&poses, margin);
        assert!(found.iter().all(|c| c.gap <= margin + 1e-12));
        for i in 0..shapes.len() {
            for j in i + 1..shapes.len() {
                let alone = Scene::new(&[shapes[i].clone(), shapes[j].clone()]).find(&[poses[i], poses[j]], margin);
                let count = found.iter().filter(|c| (c.geom_a.0, c.geom_b.0) == (i as u32, j as u32)).count();
                assert_eq!(count, alone.len(), "boxes {i} and {j}");
            }
        }
    }
}

#[test]
fn filters_and_friction_are_those_of_the_model() {
    let mut builder = ModelBuilder::new("pile");
    let mut geoms = Vec::new();
    for k in 0..4 {
        let body = free_body(&mut builder, &format!("b{k}"));
        let mut geom = Geom::new(format!("g{k}"), Geometry::Sphere { radius: 0.5 });
        geom.friction = 0.1 * f64::from(k);
        geoms.push(builder.add_geom(body, geom).unwrap());
    }
    builder.exclude(BodyId(1), BodyId(2));
    builder.add_pair(GeomPair::new(geoms[3], geoms[0], 0.77));
    let model = builder.build().unwrap();
    let p = find(
        &model,
        &[Pose::IDENTITY; 5].map(|x| Pose { position: x.position + DVec3::X * 0.1, ..x }),
        &[Reach::default(); 5],
    );
    let pairs: Vec<(u32, u32)> = p.iter().map(|c| (c.geom_a.0, c.geom_b.0)).collect();
    assert_eq!(pairs, [(0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]);
    for c in &p {
        assert_close(c.friction, model.pair_friction(c.geom_a, c.geom_b), 0.0);
        assert_eq!((c.body_a.0, c.body_b.0), (c.geom_a.0 + 1, c.geom_b.0 + 1));
    }
    assert_close(p[1].friction, 0.77, 0.0);
}

/// Geoms whose masks let them meet nothing meet what a pair names with them, with the margin of the pair, and nothing else.
#[test]
fn pairs_are_met_whatever_the_masks_say() {
    for (a, b) in [(0, 1), (1, 0), (2, 0), (1, 2)] {
        let mut builder = ModelBuilder::new("named");
        for k in 0..3 {
            let body = free_body(&mut builder, &format!("b{k}"));
            let mut geom = Geom::new(format!("g{k}"), Geometry::Sphere { radius: 0.5 });
            (geom.contact_type, geom.contact_affinity, geom.margin) = (0, 0, 0.01);
            builder.add_geom(body, geom).unwrap();
        }
        builder.add_pair(GeomPair::new(GeomId(a), GeomId(b), 0.3).with_margin(0.2));
        let model = builder.build().unwrap();
        let apart = 0.15;
        let places =
            [at(0.0, 0.0, 0.0), at(1.0 + apart, 0.0, 0.0), at(0.5 + 0.5 * apart, 0.75_f64.sqrt() * (1.0 + apart), 0.0)];
        let poses = [&[Pose::IDENTITY], &places[..]].concat();
        let p = find(&model, &poses, &[Reach { linear: 1e-3, angular: 0.0 }; 4]);
        assert_eq!(p.iter().map(|c| [c.geom_a.0, c.geom_b.0]).collect::<Vec<_>>(), [[a.min(b), a.max(b)]]);
        assert_close(p[0].gap, apart - 0.2, 1e-12);
    }
}

/// So many geoms that no table is kept of who may touch whom.
#[test]
fn filters_hold_among_many_geoms() {
    let mut builder = ModelBuilder::new("chain");
    let count = 1100;
    let mut poses = vec![Pose::IDENTITY];
    for k in 0..count {
        let body = free_body(&mut builder, &format!("b{k}"));
        builder.add_geom(body, Geom::new(format!("g{k}"), Geometry::Sphere { radius: 0.5 })).unwrap();
        poses.push(at(0.9 * f64::from(k), 0.0, 0.0));
    }
    builder.exclude(BodyId(8), BodyId(7));
    let model = builder.build().unwrap();
    let mut collider = Collider::new(&model).unwrap();
    let reach = vec![Reach::default(); poses.len()];
    let mut expected: Vec<[u32; 2]> = (1..count as u32).map(|k| [k - 1, k]).filter(|pair| *pair != [6, 7]).collect();
    for excluded in [None, Some([20, 21]), Some([31, 30])] {
        if let Some([a, b]) = excluded {
            collider.exclude([[GeomId(a), GeomId(b)]]);
            expected.retain(|pair| *pair != [a.min(b), a.max(b)]);
        }
        let mut found = Vec::new();
        collider.find(&model, &poses, &reach, &mut found);
        assert!(found.iter().map(|p| [p.geom_a.0, p.geom_b.0]).eq(expected.iter().copied()), "{excluded:?}");
    }
}

#[test]
fn features_stay_while_the_same_corners_touch() {
    let cube = cuboid(0.5, 0.5, 0.5);
    let mut scene = Scene::new(&[Geometry::Plane, cube.clone(), cube]);
    let mut keys = Vec::new();
    for k in 0..10 {
        let shift = 0.01 * f64::from(k);
        let p = scene.find(&[Pose::IDENTITY, at(shift, 0.0, 0.5), at(shift + 0.2, 0.3 + 0.1 * shift, 1.5)], 1e-6);
        keys.push(p.iter().map(|c| (c.geom_a, c.geom_b, c.feature)).collect::<Vec<_>>());
    }
    assert_eq!(keys[0].len(), 8);
    assert!(keys.iter().all(|k| *k == keys[0]), "{keys:?}");
}

#[test]
fn geom_pose_follows_the_body() {
    let mut builder = ModelBuilder::new("offset");
    let body = free_body(&mut builder, "b");
    let mut geom = Geom::new("g", Geometry::Sphere { radius: 0.1 });
    geom.placement = at(1.0, 2.0, 3.0);
    builder.add_geom(body, geom).unwrap();
    let model = builder.build().unwrap();
    let pose = Collider::new(&model).unwrap().geom_pose(GeomId(0), &[Pose::IDENTITY, at(10.0, 0.0, 0.0)]);
    assert_eq!(pose.position, DVec3::new(11.0, 2.0, 3.0));
}

#[test]
fn shapes_that_cannot_be_prepared_are_refused() {
    let flat = Mesh { vertices: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::X + DVec3::Y], triangles: Vec::new() };
    let mut builder = ModelBuilder::new("flat");
    builder.add_geom(BodyId::WORLD, Geom::new("sheet", Geometry::ConvexMesh(flat.into()))).unwrap();
    assert!(Collider::new(&builder.clone().build().unwrap()).is_ok(), "alone it need not be prepared");
    let ball = free_body(&mut builder, "ball");
    builder.add_geom(ball, Geom::new("ball", Geometry::Sphere { radius: 0.1 })).unwrap();
    let error = Collider::new(&builder.build().unwrap()).unwrap_err();
    assert!(matches!(&error, CollisionError::FlatHull { geom, .. } if geom == "sheet"), "{error}");
}
