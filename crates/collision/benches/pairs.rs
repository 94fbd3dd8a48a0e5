//! How long does a contact search take, per pair of shapes and for a pile of boxes?

use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

use glamx::glam::{DMat3, DQuat, DVec3};
use signorini_collision::{Collider, Reach};
use signorini_multibody::model::{HeightField, Mesh};
use signorini_multibody::{BodyId, Geom, Geometry, Inertia, Joint, JointKind, Model, ModelBuilder, Pose};

fn scene(shapes: &[Geometry]) -> Model {
    let mut builder = ModelBuilder::new("bench");
    for (i, shape) in shapes.iter().enumerate() {
        let fixed = matches!(shape, Geometry::Plane | Geometry::TriangleMesh(_) | Geometry::HeightField(_));
        let mut body = BodyId::WORLD;
        if !fixed {
            let inertia = Inertia { mass: 1.0, center_of_mass: DVec3::ZERO, rotational: DMat3::IDENTITY };
            body = builder.add_body(format!("b{i}"), BodyId::WORLD, Pose::IDENTITY, inertia).expect("a body");
            builder.add_joint(body, Joint::new(format!("j{i}"), JointKind::Free)).expect("a joint");
        }
        builder.add_geom(body, Geom::new(format!("g{i}"), shape.clone())).expect("a geom");
    }
    builder.build().expect("a model")
}

/// Nanoseconds per call, the best of several rounds, and the number of points.
fn time(model: &Model, poses: &[Pose], margin: f64) -> (f64, usize) {
    let mut collider = Collider::new(model).expect("a collider");
    let reach = vec![Reach { linear: 0.5 * margin, angular: 0.0 }; poses.len()];
    let mut out = Vec::new();
    let calls = (4000 / model.geoms.len()).max(1);
    let mut best = f64::INFINITY;
    // Many short rounds: on a busy machine some of them run undisturbed.
    for _ in 0..60 {
        let start = Instant::now();
        for _ in 0..calls {
            collider.find(black_box(model), black_box(poses), &reach, &mut out);
        }
        best = best.min(start.elapsed().as_secs_f64() / calls as f64);
    }
    (best * 1e9, out.len())
}

fn pair(name: &str, lower: &Geometry, upper: &Geometry, pose: Pose) {
    let model = scene(&[lower.clone(), upper.clone()]);
    let poses: Vec<Pose> =
        if model.bodies.len() == 3 { vec![Pose::IDENTITY, Pose::IDENTITY, pose] } else { vec![Pose::IDENTITY, pose] };
    let (ns, points) = time(&model, &poses, 0.01);
    println!("{name:32} {ns:9.0} ns {points:3} points");
}

fn main() {
    let up = |z: f64| Pose::from_position(DVec3::new(0.02, 0.03, z));
    let tilted =
        |z: f64| Pose::new(DVec3::new(0.02, 0.03, z), DQuat::from_euler(glamx::glam::EulerRot::XYZ, 0.3, 0.2, 0.1));
    let cube = Geometry::Box { half_extents: DVec3::splat(0.5) };
    let ball = Geometry::Sphere { radius: 0.5 };
    let rod = Geometry::Capsule { radius: 0.2, half_length: 0.5 };
    let can = Geometry::Cylinder { radius: 0.3, half_length: 0.5 };
    let egg = Geometry::Ellipsoid { semi_axes: DVec3::new(0.3, 0.4, 0.5) };
    let corners =
        (0..8).map(|k| DVec3::new(f64::from(k & 1) - 0.5, f64::from(k >> 1 & 1) - 0.5, f64::from(k >> 2) - 0.5));
    let hull = Geometry::ConvexMesh(Arc::new(Mesh { vertices: corners.collect(), triangles: Vec::new() }));
    let ground = Geometry::HeightField(Arc::new(HeightField {
        size: [21, 21],
        half_extents: [5.0, 5.0],
        heights: vec![0.0; 441],
    }));
    pair("plane - box", &Geometry::Plane, &cube, up(0.5));
    pair("plane - cylinder", &Geometry::Plane, &can, up(0.5));
    pair("sphere - sphere", &ball, &ball, up(1.0));
    pair("box - sphere", &cube, &ball, up(1.0));
    pair("capsule - capsule", &rod, &rod, tilted(1.1));
    pair("box - box, face on face", &cube, &cube, up(1.0));
    pair("box - box, tilted", &cube, &cube, tilted(1.2));
    pair("box - box, apart corner-wise", &cube, &cube, Pose::from_position(DVec3::splat(1.002)));
    pair("box - capsule, apart", &cube, &rod, tilted(1.19));
    pair("box - cylinder, flat", &cube, &can, up(1.0));
    pair("box - cylinder, tilted", &cube, &can, tilted(1.08));
    pair("box - cylinder, overlapping", &cube, &can, tilted(1.05));
    pair("cylinder - cylinder, coaxial", &can, &can, Pose::from_position(DVec3::Z));
    pair("ellipsoid - ellipsoid", &egg, &egg, tilted(0.98));
    pair("hull - hull, face on face", &hull, &hull, up(1.0));
    pair("height field - box", &ground, &cube, up(0.5));
    pair("height field - sphere", &ground, &ball, up(0.5));
    for side in [5_usize, 10, 20] {
        let count = side.pow(3);
        let mut shapes = vec![cube.clone(); count];
        shapes.push(Geometry::Plane);
        let mut poses = vec![Pose::IDENTITY];
        poses.extend((0..count).map(|k| {
            let at = |i: usize| i as f64;
            Pose::from_position(DVec3::new(1.02 * at(k % side), 1.02 * at(k / side % side), 0.5 + at(k / side / side)))
        }));
        let (ns, points) = time(&scene(&shapes), &poses, 0.001);
        println!("{:32} {:9.1} us {points:6} points", format!("{count} stacked boxes on a plane"), ns / 1e3);
    }
}
