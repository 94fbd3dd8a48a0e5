//! What contacts owe to nothing but the shapes: units of length, places in the world, names.

use std::sync::Arc;

use glamx::glam::{DQuat, DVec3};
use signorini_collision::Reach;
use signorini_multibody::model::Mesh;
use signorini_multibody::{ContactPoint, Geometry, Pose};

use crate::random::{Random, convex_shapes, cuboid_mesh};
use crate::scene::{Scene, assert_close, assert_near, contacts, cuboid};
use crate::support::largest_separation;

/// A shape in other units of length.
fn scaled(shape: &Geometry, by: f64) -> Geometry {
    let mesh = |mesh: &Mesh| {
        Arc::new(Mesh { vertices: mesh.vertices.iter().map(|p| *p * by).collect(), triangles: mesh.triangles.clone() })
    };
    match shape {
        Geometry::Plane => Geometry::Plane,
        Geometry::Sphere { radius } => Geometry::Sphere { radius: radius * by },
        Geometry::Box { half_extents } => Geometry::Box { half_extents: *half_extents * by },
        Geometry::Capsule { radius, half_length } => {
            Geometry::Capsule { radius: radius * by, half_length: half_length * by }
        }
        Geometry::Cylinder { radius, half_length } => {
            Geometry::Cylinder { radius: radius * by, half_length: half_length * by }
        }
        Geometry::Cone { radius, half_length } => Geometry::Cone { radius: radius * by, half_length: half_length * by },
        Geometry::Ellipsoid { semi_axes } => Geometry::Ellipsoid { semi_axes: *semi_axes * by },
        Geometry::ConvexMesh(own) => Geometry::ConvexMesh(mesh(own)),
        Geometry::TriangleMesh(own) => Geometry::TriangleMesh(mesh(own)),
        other => panic!("no scale for a {}", other.kind_name()),
    }
}

/// Random shapes and shapes that lie on each other, of every kind; the last two are fixed to the world.
fn shapes() -> Vec<Geometry> {
    let sheet = Mesh {
        vertices: vec![
            DVec3::new(-2.0, -2.0, 0.1),
            DVec3::new(2.0, -2.0, 0.0),
            DVec3::new(2.0, 2.0, 0.1),
            DVec3::new(-2.0, 2.0, 0.0),
        ],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    };
    let mut shapes = convex_shapes();
    shapes.push(cuboid(0.4, 0.4, 0.3));
    shapes.push(cuboid_mesh(DVec3::new(0.5, 0.3, 0.2)));
    shapes.push(Geometry::TriangleMesh(sheet.into()));
    shapes.push(Geometry::Plane);
    shapes
}

/// The contacts of two shapes that travel by half of `margin` each and turn by a little.
fn find_turning(scene: &mut Scene, poses: &[Pose; 2], margin: f64) -> Vec<ContactPoint> {
    let mut body_pose = vec![Pose::IDENTITY; scene.model.bodies.len()];
    scene.bodies.iter().zip(poses).filter(|(body, _)| **body > 0).for_each(|(body, pose)| body_pose[*body] = *pose);
    let reach = vec![Reach { linear: 0.5 * margin, angular: 0.03 }; body_pose.len()];
    let mut out = Vec::new();
    scene.collider.find(&scene.model, &body_pose, &reach, &mut out);
    out
}

/// Lengths in units that are a power of two of one another have the same digits, and so has all that follows from them: whatever is an absolute
/// length in the search, or has the wrong power of a length, shows.
#[test]
fn contacts_do_not_depend_on_the_unit_of_length() {
    let mut random = Random(17);
    let shapes = shapes();
    let mut points = 0;
    for (i, a) in shapes.iter().enumerate() {
        for b in &shapes[..shapes.len() - 2] {
            let units = [-11, -4, 3, 9].map(|power| 2.0_f64.powi(power));
            let mut own = Scene::new(&[a.clone(), b.clone()]);
            let mut others = units.map(|by| Scene::new(&[scaled(a, by), scaled(b, by)]));
            for round in 0..12 {
                let eighths = |random: &mut Random| (random.unit() * 8.0).floor() * std::f64::consts::FRAC_PI_4;
                let rotation = match round % 3 {
                    0 => DQuat::from_rotation_z(eighths(&mut random)) * DQuat::from_rotation_x(eighths(&mut random)),
                    _ => random.rotation(),
                };
                let fixed = i + 2 >= shapes.len();
                let x_a = if fixed { Pose::IDENTITY } else { Pose::new(random.vector(), DQuat::IDENTITY) };
                let mut x_b = Pose::new(x_a.position + random.vector().normalize() * 1.5, rotation);
                if fixed {
                    x_b.position = DVec3::new(0.1, 0.2, 0.3 * random.unit());
                } else {
                    let (apart, n) = largest_separation((a, &x_a), (b, &x_b));
                    x_b.position += n * ([0.02, 0.0, -1e-3, -0.05][round % 4] - apart);
                }
                let found = find_turning(&mut own, &[x_a, x_b], 0.1);
                points += found.len();
                for (by, other) in units.iter().zip(&mut others) {
                    let moved = [x_a, x_b].map(|x| Pose::new(x.position * *by, x.rotation));
                    let found_there = find_turning(other, &moved, 0.1 * by);
                    let name = || format!("{} and {} times {by}", a.kind_name(), b.kind_name());
                    let same = |(p, q): (&ContactPoint, &ContactPoint)| {
                        (p.gap * by, p.position * *by, p.normal, p.feature) == (q.gap, q.position, q.normal, q.feature)
                    };
                    assert!(
                        found.len() == found_there.len() && found.iter().zip(&found_there).all(same),
                        "{}: {found:?}, {found_there:?}",
                        name()
                    );
                }
            }
        }
    }
    assert!(points > 1000, "{points}");
}

/// Capsules that lie along each other touch at the two ends of what they have in common, however they are turned, and where both end at one place too.
#[test]
fn capsules_along_each_other_touch_at_two_points_in_every_frame() {
    let mut random = Random(18);
    for case in 0..2000 {
        let half_length = 0.2 + 0.3 * random.unit();
        let [long, short] = [half_length, if case % 2 == 0 { half_length } else { 0.1 * half_length }];
        let shape = |half_length| Geometry::Capsule { radius: 0.1, half_length };
        let shift = if case % 4 < 2 { 0.0 } else { 0.5 * half_length * random.signed() };
        let turn = random.rotation();
        let angle = 6.0 * random.unit();
        let aside = DVec3::new(0.2 * angle.cos(), 0.2 * angle.sin(), shift);
        let flipped = if case % 3 == 0 { DQuat::from_rotation_x(std::f64::consts::PI) } else { DQuat::IDENTITY };
        let poses = [Pose::new(random.vector(), turn); 2];
        let poses = [poses[0], Pose::new(poses[0].position + turn * aside, turn * flipped)];
        let found = Scene::new(&[shape(long), shape(short)]).find(&poses, 1e-3);
        let low = (-long).max(shift - short);
        let high = long.min(shift + short);
        let expected = [low, high].map(|z| poses[0].transform_point(DVec3::new(0.5 * aside.x, 0.5 * aside.y, z)));
        let near = |p: &ContactPoint, e: &DVec3| (p.position - *e).length() < 1e-9 && p.gap.abs() < 1e-12;
        assert!(
            found.len() == 2 && expected.iter().all(|e| found.iter().any(|p| near(p, e))),
            "case {case}: {found:?}, not at {expected:?}"
        );
    }
}

/// Where an edge of one box touches an edge of another one that is turned about it, the faces of both separate them: the normal is in the middle, whichever
/// is called first.
#[test]
fn between_two_edges_no_box_is_preferred() {
    let (half_a, half_b) = (DVec3::new(0.5, 0.4, 0.3), DVec3::new(0.2, 0.3, 0.6));
    for angle in [0.1_f64, 0.4, 0.8, 1.2, 1.5] {
        let turn = DQuat::from_rotation_y(angle);
        let edge = DVec3::new(half_a.x, 0.0, half_a.z);
        let place = Pose::new(edge + turn * DVec3::new(half_b.x, 0.0, half_b.z), turn);
        let [a, b] = [half_a, half_b].map(|half_extents| Geometry::Box { half_extents });
        let expected = (DVec3::X + turn * DVec3::Z).normalize();
        for (points, sign) in [
            (contacts(&a, Pose::IDENTITY, &b, place, 1e-3), 1.0),
            (contacts(&b, place, &a, Pose::IDENTITY, 1e-3), -1.0),
        ] {
            assert_eq!(points.len(), 2, "{points:?}");
            for point in points {
                assert_near(point.normal * sign, expected, 1e-9);
                assert_close(point.gap, 0.0, 1e-12);
                assert_near(point.position, edge + DVec3::Y * 0.3_f64.copysign(point.position.y), 1e-9);
            }
        }
    }
}

/// Pairs of shapes that lie on each other, flush where they can be, in places where much coincides.
fn flush_pairs() -> Vec<[(Geometry, Pose); 2]> {
    let half = DVec3::new(0.3, 0.2, 0.1);
    let (cuboid, hull) = (Geometry::Box { half_extents: half }, cuboid_mesh(half));
    let (can, rod, hat) = (
        Geometry::Cylinder { radius: 0.1, half_length: 0.3 },
        Geometry::Capsule { radius: 0.1, half_length: 0.3 },
        Geometry::Cone { radius: 0.1, half_length: 0.3 },
    );
    let ring = |k: u32| DVec3::new(0.3 * (f64::from(k) * 1.05).cos(), 0.3 * (f64::from(k) * 1.05).sin(), 0.1);
    let prism = (0..6).flat_map(|k| [ring(k), ring(k).with_z(-0.1)]).collect();
    let prism = Geometry::ConvexMesh(Mesh { vertices: prism, triangles: Vec::new() }.into());
    let corners = (0..8).map(|k| {
        let sign = |bit: u32| if k & bit > 0 { 1.0 } else { -1.0 };
        half * DVec3::new(sign(1), sign(2), sign(4))
    });
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let shell = Geometry::TriangleMesh(Mesh { vertices: corners.collect(), triangles }.into());
    let lying = DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2);
    let above = |z: f64| Pose::from_position(DVec3::Z * z);
    let mut pairs = Vec::new();
    for lower in [&cuboid, &hull, &shell] {
        for upper in [&cuboid, &hull, &shell] {
            for place in
                [DVec3::Z * 0.2, DVec3::new(0.1, 0.0, 0.2), DVec3::new(0.6, 0.0, 0.0), DVec3::new(0.3, 0.2, 0.2)]
            {
                pairs.push([(lower.clone(), Pose::IDENTITY), (upper.clone(), Pose::from_position(place))]);
            }
        }
        for shape in [&can, &rod] {
            pairs.push([(lower.clone(), Pose::IDENTITY), (shape.clone(), Pose::new(DVec3::Z * 0.2, lying))]);
            pairs.push([(lower.clone(), Pose::IDENTITY), (shape.clone(), Pose::new(DVec3::new(0.0, 0.2, 0.2), lying))]);
        }
        for shape in [&can, &hat] {
            pairs.push([(lower.clone(), Pose::IDENTITY), (shape.clone(), above(0.4))]);
        }
        pairs.push([(lower.clone(), Pose::IDENTITY), (rod.clone(), above(0.5))]);
    }
    pairs.push([(prism.clone(), Pose::IDENTITY), (prism.clone(), above(0.2))]);
    pairs.push([(prism.clone(), Pose::IDENTITY), (cuboid.clone(), above(0.2))]);
    for shape in [&can, &rod] {
        for shift in [0.0, 0.2, 0.6] {
            pairs.push([
                (can.clone(), Pose::IDENTITY),
                (shape.clone(), Pose::from_position(DVec3::new(0.2, 0.0, shift))),
            ]);
        }
    }
    pairs.push([(can.clone(), Pose::IDENTITY), (can.clone(), above(0.6))]);
    pairs.push([(can.clone(), Pose::IDENTITY), (hat.clone(), above(0.6))]);
    pairs
}

/// Where everything coincides rounding decides what is inside of what: the points are those of a frame in which there is none, and none overlaps.
#[test]
fn flush_shapes_touch_at_the_same_points_in_every_frame() {
    let mut random = Random(19);
    for (case, [(a, x_a), (b, x_b)]) in flush_pairs().into_iter().enumerate() {
        let mut scene = Scene::of_moving(&[a.clone(), b.clone()]);
        let expected = scene.find(&[x_a, x_b], 1e-4);
        let kinds = [&a, &b].map(|shape| shape.kind_name());
        assert!(!expected.is_empty());
        for _ in 0..60 {
            let frame = Pose::new(random.vector(), random.rotation());
            let found = scene.find(&[frame * x_a, frame * x_b], 1e-4);
            let name = format!("case {case}: {kinds:?} in {frame:?}");
            assert!(found.iter().all(|p| p.gap.abs() < 1e-9), "{name}: {found:?}");
            assert_eq!(found.len(), expected.len(), "{name}: {found:?}, not {expected:?}");
            for point in &expected {
                let place = frame.transform_point(point.position);
                let is_there = found.iter().any(|p| (p.position - place).length() < 1e-7);
                assert!(is_there, "{name}: nothing at {place} but {found:?}");
            }
        }
    }
}
