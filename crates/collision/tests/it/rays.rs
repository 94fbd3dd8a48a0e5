//! Rays at places where faces meet: none slips between them.

use signorini_collision::{Queries, Ray};
use signorini_multibody::glam::{DQuat, DVec3};
use signorini_multibody::model::{HeightField, Mesh};
use signorini_multibody::{Geom, GeomId, Geometry, ModelBuilder, Pose};

use crate::random::{Random, cuboid_mesh};
use crate::surfaces::crumpled;

/// Where the ray to a place of the surface from outside ends, and how far the place is.
fn distances(queries: &Queries, pose: &Pose, place: DVec3, outward: DVec3) -> (f64, f64) {
    let (target, origin) = (pose.transform_point(place), pose.transform_point(place + outward));
    let hit = queries.ray(&Ray::new(origin, target - origin), |_| true);
    (hit.map_or(f64::INFINITY, |hit| hit.distance), (target - origin).length())
}

fn queries(geometry: &Geometry, pose: &Pose) -> Queries {
    let mut builder = ModelBuilder::new("one");
    builder.body("body").shape(Geom::new("geom", geometry.clone())).add().expect("a body");
    let mut queries = Queries::new(&builder.build().expect("a model"));
    queries.place(&[Pose::IDENTITY, *pose]);
    assert_eq!(queries.geom_pose(GeomId(0)), *pose);
    queries
}

/// A place on a rim, a seam, an edge or at a corner of a shape that is seen whole from its origin.
fn where_faces_meet(geometry: &Geometry, random: &mut Random) -> DVec3 {
    let (sin, cos) = (6.3 * random.unit()).sin_cos();
    let side = if random.unit() < 0.5 { 1.0 } else { -1.0 };
    let share = [0.0, 1.0, random.unit()][(3.0 * random.unit()) as usize];
    let on_edge = |mesh: &Mesh, random: &mut Random| {
        let t = mesh.triangles[(random.unit() * mesh.triangles.len() as f64) as usize];
        let k = (3.0 * random.unit()) as usize;
        mesh.vertices[t[k] as usize].lerp(mesh.vertices[t[(k + 1) % 3] as usize], share)
    };
    match geometry {
        Geometry::Cylinder { radius, half_length } | Geometry::Capsule { radius, half_length } => {
            DVec3::new(radius * cos, radius * sin, side * half_length)
        }
        Geometry::Cone { radius, half_length } if side < 0.0 => DVec3::new(radius * cos, radius * sin, -half_length),
        Geometry::Cone { half_length, .. } => DVec3::Z * *half_length,
        Geometry::Box { half_extents } => {
            let sign = |random: &mut Random| if random.unit() < 0.5 { 1.0 } else { -1.0 };
            let corner = *half_extents * DVec3::new(sign(random), sign(random), sign(random));
            corner * DVec3::new(2.0 * share - 1.0, 1.0, 1.0)
        }
        Geometry::ConvexMesh(mesh) => {
            let [a, b] = [mesh.vertices[0], mesh.vertices[1]];
            a.lerp(b, share)
        }
        Geometry::TriangleMesh(mesh) => on_edge(mesh, random),
        other => panic!("no edges of a {}", other.kind_name()),
    }
}

#[test]
fn a_ray_at_a_place_where_faces_meet_ends_there() {
    let mut random = Random(15);
    for case in 0..4000 {
        let [radius, half_length] = [(); 2].map(|()| 0.1 + 0.4 * random.unit());
        let geometry = match case % 6 {
            0 => Geometry::Cylinder { radius, half_length },
            1 => Geometry::Capsule { radius, half_length },
            2 => Geometry::Cone { radius, half_length },
            3 => Geometry::Box { half_extents: DVec3::new(radius, half_length, 0.3) },
            4 => cuboid_mesh(DVec3::new(radius, half_length, 0.2)),
            _ => Geometry::TriangleMesh(crumpled(&mut random).into()),
        };
        let pose = if case % 12 < 6 { Pose::IDENTITY } else { Pose::new(random.vector(), random.rotation()) };
        let world = queries(&geometry, &pose);
        for _ in 0..10 {
            let place = where_faces_meet(&geometry, &mut random);
            // From its origin every one of the shapes is seen from behind all its faces.
            let (found, expected) = distances(&world, &pose, place, place.normalize() * (0.2 + random.unit()));
            let off = (found - expected).abs();
            assert!(off < 1e-7, "case {case}: a {} at {place} is met at {found}, not {expected}", geometry.kind_name());
        }
    }
}

/// A sensor that looks down at the corners of a height field, and at what is between them.
#[test]
fn a_ray_ends_on_the_edges_of_a_height_field() {
    let mut random = Random(16);
    let n = 7;
    for case in 0..200 {
        let heights: Vec<f64> = (0..n * n).map(|_| 0.05 * random.signed()).collect();
        let half = 0.5 + random.unit();
        let field = HeightField { size: [n, n], half_extents: [half, half], heights: heights.clone() };
        let turn = if case % 2 == 0 { DQuat::IDENTITY } else { random.rotation() };
        let pose = Pose::new(random.vector(), turn);
        let world = queries(&Geometry::HeightField(field.into()), &pose);
        let corner = |i: usize, j: usize| {
            let place = |k: usize| half * (2.0 * k as f64 / (n - 1) as f64 - 1.0);
            DVec3::new(place(i), place(j), heights[j * n + i])
        };
        for (i, j) in (1..n - 1).flat_map(|i| (1..n - 1).map(move |j| (i, j))) {
            // To the right, upwards, and along the diagonal that divides the cell.
            for (k, l) in [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)] {
                let place = corner(i, j).lerp(corner(k, l), random.unit());
                let up = DVec3::Z + if case % 4 < 2 { DVec3::ZERO } else { 0.2 * random.vector() };
                let (found, expected) = distances(&world, &pose, place, up);
                assert!((found - expected).abs() < 1e-9, "case {case}: {place} is met at {found}, not {expected}");
            }
        }
    }
}
