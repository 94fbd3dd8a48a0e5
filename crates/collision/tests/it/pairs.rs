//! Closed forms for pairs of shapes.

use glamx::glam::{DQuat, DVec3};
use signorini_multibody::model::Mesh;
use signorini_multibody::{ContactPoint, Geometry, Pose};

use crate::random::{Random, convex_shapes, cuboid_mesh, rock};
use crate::scene::{assert_close, assert_near, assert_positions, at, contacts, cuboid, smallest_gap, turned};
use crate::support::extent;

const QUARTER: f64 = std::f64::consts::FRAC_PI_4;

fn sphere(radius: f64) -> Geometry {
    Geometry::Sphere { radius }
}

fn capsule(radius: f64, half_length: f64) -> Geometry {
    Geometry::Capsule { radius, half_length }
}

fn cylinder(radius: f64, half_length: f64) -> Geometry {
    Geometry::Cylinder { radius, half_length }
}

fn cone(radius: f64, half_length: f64) -> Geometry {
    Geometry::Cone { radius, half_length }
}

fn single(points: &[ContactPoint]) -> &ContactPoint {
    assert_eq!(points.len(), 1, "{points:?}");
    &points[0]
}

#[test]
fn every_convex_shape_has_its_exact_height_over_a_plane() {
    let mut random = Random(11);
    for shape in convex_shapes() {
        for _ in 0..200 {
            let mut pose = Pose::new(random.vector(), random.rotation());
            let height = -extent(&shape, &pose, -DVec3::Z);
            let gap = 0.05 * random.signed();
            pose.position.z += gap - height;
            let points = contacts(&Geometry::Plane, Pose::IDENTITY, &shape, pose, 0.06);
            assert_close(smallest_gap(&points), gap, 1e-12);
            for p in &points {
                assert_eq!(p.normal, DVec3::Z);
                let on_shape = p.position + DVec3::Z * (0.5 * p.gap);
                assert_close(on_shape.z, p.gap, 1e-12);
                let inside =
                    crate::support::directions(200).all(|d| d.dot(on_shape) <= extent(&shape, &pose, d) + 1e-9);
                assert!(inside, "{p:?} is not on the {}", shape.kind_name());
            }
        }
    }
}

#[test]
fn a_tilted_plane_gives_its_own_normal() {
    // A plane cannot be turned by its body in these scenes, so the geom itself is.
    use signorini_multibody::{BodyId, Geom, Inertia, Joint, JointKind, ModelBuilder};
    let mut builder = ModelBuilder::new("slope");
    let slope = DQuat::from_rotation_y(0.3);
    let mut plane = Geom::new("plane", Geometry::Plane);
    plane.placement = Pose::new(DVec3::new(0.0, 0.0, 1.0), slope);
    builder.add_geom(BodyId::WORLD, plane).unwrap();
    let inertia = Inertia { mass: 1.0, rotational: glamx::glam::DMat3::IDENTITY, ..Inertia::ZERO };
    let body = builder.add_body("b", BodyId::WORLD, Pose::IDENTITY, inertia).unwrap();
    builder.add_joint(body, Joint::new("j", JointKind::Free)).unwrap();
    builder.add_geom(body, Geom::new("ball", sphere(0.25))).unwrap();
    let model = builder.build().unwrap();
    let mut collider = signorini_collision::Collider::new(&model).unwrap();
    let normal = slope * DVec3::Z;
    let poses = [Pose::IDENTITY, Pose::from_position(DVec3::Z + normal * 0.24)];
    let mut out = Vec::new();
    collider.find(&model, &poses, &[signorini_collision::Reach::default(); 2], &mut out);
    assert_close(single(&out).gap, -0.01, 1e-15);
    assert_near(out[0].normal, normal, 1e-15);
}

#[test]
fn spheres() {
    for gap in [-0.1, 0.0, 0.1] {
        let d = DVec3::new(2.0, 3.0, 6.0) / 7.0;
        let c = d * (0.7 + gap);
        let points = contacts(&sphere(0.3), at(0.0, 0.0, 0.0), &sphere(0.4), at(c.x, c.y, c.z), 0.2);
        assert_close(single(&points).gap, gap, 1e-15);
        assert_near(points[0].normal, d, 1e-15);
        assert_near(points[0].position, d * (0.3 + 0.5 * gap), 1e-15);
    }
}

#[test]
fn sphere_and_box() {
    let cube = cuboid(0.5, 0.5, 0.5);
    let diagonal = DVec3::new(0.5, 0.5, 0.5);
    let corner = diagonal + DVec3::ONE.normalize() * 0.11;
    let p = contacts(&cube, at(0.0, 0.0, 0.0), &sphere(0.1), at(corner.x, corner.y, corner.z), 0.02);
    assert_close(single(&p).gap, 0.01, 1e-14);
    assert_near(p[0].normal, DVec3::ONE.normalize(), 1e-14);
    // Centre inside: out by the nearest face.
    let p = contacts(&sphere(0.1), at(0.1, 0.2, 0.45), &cube, at(0.0, 0.0, 0.0), 0.0);
    assert_close(single(&p).gap, -0.15, 1e-14);
    assert_near(p[0].normal, -DVec3::Z, 0.0);
}

#[test]
fn sphere_and_round_shapes() {
    let ball = sphere(0.1);
    let beside = |shape: &Geometry, p: DVec3| *single(&contacts(shape, Pose::IDENTITY, &ball, at(p.x, p.y, p.z), 1.0));
    let c = beside(&capsule(0.2, 0.5), DVec3::new(0.3, 0.4, 0.2));
    assert_close(c.gap, 0.2, 1e-15);
    assert_near(c.normal, DVec3::new(0.6, 0.8, 0.0), 1e-15);
    let c = beside(&cylinder(0.2, 0.5), DVec3::new(0.3, 0.4, 0.9));
    assert_close(c.gap, 0.5 - 0.1, 1e-14);
    assert_near(c.normal, DVec3::new(0.6 * 0.6, 0.8 * 0.6, 0.8), 1e-14);
    let c = beside(&cylinder(0.2, 0.5), DVec3::new(0.0, 0.05, 0.1));
    assert_close(c.gap, -0.25, 1e-15);
    assert_near(c.normal, DVec3::Y, 1e-15);
    // Half a cone: side from (0.3, -0.2) to (0, 0.2), outward normal (0.8, 0.6).
    let c = beside(&cone(0.3, 0.2), DVec3::new(0.15 + 0.8 * 0.25, 0.0, 0.6 * 0.25));
    assert_close(c.gap, 0.15, 1e-14);
    assert_near(c.normal, DVec3::new(0.8, 0.0, 0.6), 1e-14);
    let c = beside(&Geometry::Ellipsoid { semi_axes: DVec3::new(0.6, 0.3, 0.2) }, DVec3::new(0.0, 0.0, 0.5));
    assert_close(c.gap, 0.2, 1e-12);
    assert_near(c.normal, DVec3::Z, 1e-9);
}

#[test]
fn capsules() {
    let rod = capsule(0.1, 0.5);
    // Crossed at right angles, one above the other.
    let p = contacts(&rod, at(0.0, 0.0, 0.0), &rod, turned(0.25, 0.0, 0.0, DVec3::X, 2.0 * QUARTER), 0.1);
    assert_close(single(&p).gap, 0.05, 1e-15);
    assert_near(p[0].normal, DVec3::X, 1e-15);
    // Side by side, shifted along the common direction.
    let p = contacts(&rod, at(0.0, 0.0, 0.0), &rod, at(0.19, 0.0, 0.4), 0.1);
    assert_positions(&p, &[DVec3::new(0.095, 0.0, -0.1), DVec3::new(0.095, 0.0, 0.5)], 1e-12);
    assert!(p.iter().all(|c| (c.gap + 0.01).abs() < 1e-12));
    // End to end.
    let p = contacts(&rod, at(0.0, 0.0, 0.0), &rod, at(0.0, 0.0, 1.21), 0.1);
    assert_close(single(&p).gap, 0.01, 1e-14);
    assert_near(p[0].normal, DVec3::Z, 1e-14);
}

#[test]
fn capsule_and_cylinder_lying_on_a_box_touch_at_both_ends() {
    let table = cuboid(1.0, 1.0, 0.5);
    for shape in [capsule(0.1, 0.4), cylinder(0.1, 0.4)] {
        for gap in [-1e-3, -1e-9, 0.0, 1e-9, 1e-3] {
            let lying = turned(0.1, 0.2, 0.6 + gap, DVec3::Y, 2.0 * QUARTER);
            let p = contacts(&table, at(0.0, 0.0, 0.0), &shape, lying, 2e-3);
            let z = 0.5 + 0.5 * gap;
            assert_positions(&p, &[DVec3::new(-0.3, 0.2, z), DVec3::new(0.5, 0.2, z)], 1e-9);
            assert!(p.iter().all(|c| (c.gap - gap).abs() < 1e-12 && (c.normal - DVec3::Z).length() < 1e-9), "{p:?}");
        }
    }
}

#[test]
fn a_capsule_standing_on_its_end_touches_at_one_point() {
    let rod = capsule(0.1, 0.4);
    for (tilt, gap) in [(0.0, 0.0), (1e-12, 0.0), (1e-9, 1e-3), (1e-6, -1e-3), (1e-3, 0.0), (0.1, 1e-9), (1.0, 0.0)] {
        let height = 0.1 + 0.4 * f64::cos(tilt) + gap;
        let p =
            contacts(&cuboid(2.0, 2.0, 0.5), at(0.0, 0.0, -0.5), &rod, turned(0.0, 0.0, height, DVec3::X, tilt), 2e-3);
        assert_close(single(&p).gap, gap, 1e-12);
        assert_near(p[0].normal, DVec3::Z, 1e-9);
        assert_near(p[0].position, DVec3::new(0.0, 0.4 * f64::sin(tilt), 0.5 * gap), 1e-9);
    }
}

#[test]
fn a_cylinder_standing_flat_touches_at_eight_points_of_its_rim() {
    let can = cylinder(0.1, 0.2);
    let ring = |z: f64| {
        (0..8).map(move |k| DVec3::new(0.1 * (f64::from(k) * QUARTER).cos(), 0.1 * (f64::from(k) * QUARTER).sin(), z))
    };
    let on_plane = contacts(&Geometry::Plane, Pose::IDENTITY, &can, at(0.0, 0.0, 0.2), 1e-6);
    assert_positions(&on_plane, &ring(0.0).collect::<Vec<_>>(), 1e-12);
    for other in [can.clone(), cuboid(0.5, 0.5, 0.2), cylinder(0.3, 0.2)] {
        for gap in [-1e-3, 0.0, 1e-12, 1e-3] {
            let p = contacts(&other, Pose::IDENTITY, &can, at(0.0, 0.0, 0.4 + gap), 2e-3);
            assert_positions(&p, &ring(0.2 + 0.5 * gap).collect::<Vec<_>>(), 1e-9);
            assert!(p.iter().all(|c| (c.gap - gap).abs() < 1e-12 && (c.normal - DVec3::Z).length() < 1e-12), "{p:?}");
        }
    }
}

#[test]
fn a_tilted_cylinder_touches_at_the_lowest_point_of_its_rim() {
    let can = cylinder(0.1, 0.2);
    for tilt in [1e-5_f64, 1e-3, 0.2, 0.7, 1.0] {
        let axis = DVec3::new((7.0 * tilt).cos(), (7.0 * tilt).sin(), 0.0);
        let height = 0.1 * tilt.sin() + 0.2 * tilt.cos();
        let pose = turned(0.0, 0.0, height, axis, tilt);
        let p = contacts(&Geometry::Plane, Pose::IDENTITY, &can, pose, 1e-7);
        assert_close(single(&p).gap, 0.0, 1e-12);
        let q = contacts(&cuboid(1.0, 1.0, 1.0), at(0.0, 0.0, -1.0), &can, pose, 1e-7);
        assert_close(smallest_gap(&q), 0.0, 1e-9);
        assert_near(single(&q).position, p[0].position, 1e-9);
    }
}

/// Symmetric poses, at which an expanding polytope started from a degenerate simplex goes wrong.
#[test]
fn coaxial_round_shapes_push_each_other_along_the_axis() {
    let shapes = [cylinder(0.3, 0.4), cone(0.3, 0.4), Geometry::Ellipsoid { semi_axes: DVec3::new(0.3, 0.3, 0.4) }];
    for lower in &shapes {
        for upper in &shapes {
            for gap in [-0.02, -1e-3, -1e-9, 0.0, 1e-9, 1e-3, 0.02] {
                for turn in [0.0, 0.3, QUARTER] {
                    let pose = turned(0.0, 0.0, 0.8 + gap, DVec3::Z, turn);
                    let p = contacts(lower, Pose::IDENTITY, upper, pose, 0.03);
                    let name = format!("{} under {} at {gap}", lower.kind_name(), upper.kind_name());
                    let found = p.iter().min_by(|x, y| x.gap.total_cmp(&y.gap)).expect(&name);
                    assert!((found.gap - gap).abs() < 1e-9, "{name}: {p:?}");
                    assert!((found.normal - DVec3::Z).length() < 1e-6, "{name}: {p:?}");
                }
            }
        }
    }
}

#[test]
fn parallel_cylinders_touch_along_their_sides() {
    let log = cylinder(0.1, 0.5);
    for gap in [-1e-3, -1e-10, 0.0, 1e-10, 1e-3] {
        for angle in [0.0, 0.5, 2.0] {
            let (sin, cos) = f64::sin_cos(angle);
            let p = contacts(&log, Pose::IDENTITY, &log, at((0.2 + gap) * cos, (0.2 + gap) * sin, 0.2), 2e-3);
            assert_eq!(p.len(), 2, "{gap}: {p:?}");
            let middle = DVec3::new(cos, sin, 0.0) * (0.1 + 0.5 * gap);
            assert_positions(&p, &[middle - DVec3::Z * 0.3, middle + DVec3::Z * 0.5], 1e-8);
            assert!(p.iter().all(|c| (c.gap - gap).abs() < 1e-9), "{gap}: {p:?}");
        }
    }
}

#[test]
fn crossed_cylinders_touch_at_one_point() {
    let log = cylinder(0.1, 0.5);
    for gap in [-1e-3, 0.0, 1e-3] {
        let p = contacts(&log, Pose::IDENTITY, &log, turned(0.2 + gap, 0.0, 0.0, DVec3::X, 1.0), 2e-3);
        assert_close(single(&p).gap, gap, 1e-12);
        assert_near(p[0].normal, DVec3::X, 1e-9);
        assert_near(p[0].position, DVec3::X * (0.1 + 0.5 * gap), 1e-9);
    }
}

#[test]
fn a_cone_on_its_base_stands_on_its_rim_and_on_its_side_along_a_line() {
    let hat = cone(0.3, 0.2);
    let p = contacts(&cuboid(1.0, 1.0, 0.1), at(0.0, 0.0, -0.1), &hat, at(0.0, 0.0, 0.2), 1e-6);
    assert_eq!(p.len(), 8);
    assert!(p.iter().all(|c| c.gap.abs() < 1e-12 && (c.normal - DVec3::Z).length() < 1e-9));
    // Turned so that the side normal (0.8, 0, 0.6) points down.
    let turn = DQuat::from_rotation_arc(DVec3::new(0.8, 0.0, 0.6), -DVec3::Z);
    let height = 0.6 * 0.2;
    let p = contacts(&cuboid(1.0, 1.0, 0.1), at(0.0, 0.0, -0.1), &hat, Pose::new(DVec3::Z * height, turn), 1e-6);
    assert_eq!(p.len(), 2, "{p:?}");
    assert_close((p[0].position - p[1].position).length(), 0.5, 1e-9);
    assert!(p.iter().all(|c| c.gap.abs() < 1e-9));
}

#[test]
fn a_hull_rests_on_its_faces_like_a_box() {
    let half = DVec3::new(0.3, 0.2, 0.1);
    let hull = cuboid_mesh(half);
    let corners = [[-0.3, -0.2], [0.3, -0.2], [-0.3, 0.2], [0.3, 0.2]].map(|[x, y]| DVec3::new(x, y, 0.0));
    let p = contacts(&Geometry::Plane, Pose::IDENTITY, &hull, at(0.0, 0.0, 0.1), 1e-6);
    assert_positions(&p, &corners, 1e-12);
    for gap in [-1e-4, 0.0, 1e-4] {
        let p = contacts(&cuboid(1.0, 1.0, 1.0), at(0.0, 0.0, -1.0), &hull, at(0.0, 0.0, 0.1 + gap), 1e-3);
        assert_positions(&p, &corners.map(|c| c + DVec3::Z * (0.5 * gap)), 1e-9);
        let p = contacts(&hull, Pose::IDENTITY, &hull, at(0.6 + gap, 0.1, 0.05), 1e-3);
        assert_eq!(p.len(), 4, "{p:?}");
        assert!(p.iter().all(|c| (c.normal - DVec3::X).length() < 1e-9 && (c.gap - gap).abs() < 1e-12));
    }
}

#[test]
fn coincident_shapes_give_finite_contacts() {
    let mut shapes = convex_shapes();
    shapes.push(cuboid_mesh(DVec3::splat(0.2)));
    for a in &shapes {
        for b in &shapes {
            let p = contacts(a, Pose::IDENTITY, b, Pose::IDENTITY, 0.01);
            assert!(smallest_gap(&p) < -0.1, "{} {}: {p:?}", a.kind_name(), b.kind_name());
            for c in &p {
                assert!(c.position.is_finite() && c.gap.is_finite(), "{c:?}");
                assert_close(c.normal.length(), 1.0, 1e-9);
            }
        }
    }
}

#[test]
fn poses_that_are_not_numbers_touch_nothing() {
    let nan = Pose::from_position(DVec3::NAN);
    for shape in [Geometry::Plane, cuboid(1.0, 1.0, 1.0), rock()] {
        assert!(contacts(&shape, Pose::IDENTITY, &cuboid(1.0, 1.0, 1.0), nan, 0.1).is_empty());
    }
}

/// A blunt hull near a floor: a wide upper ring and a small lower one inside it. The lower ring closes first, so none of its
/// points may be left out, although the outline is the upper ring.
#[test]
fn low_vertices_inside_the_outline_are_kept() {
    let ring = |count: usize, radius: f64, z: f64| {
        (0..count).map(move |k| {
            let angle = std::f64::consts::TAU * k as f64 / count as f64;
            DVec3::new(radius * angle.cos(), radius * angle.sin(), z)
        })
    };
    let vertices: Vec<DVec3> = ring(12, 0.1, 0.007).chain(ring(5, 0.03, 0.0001)).chain(ring(4, 0.05, 0.1)).collect();
    let hull = Geometry::ConvexMesh(std::sync::Arc::new(Mesh { vertices, triangles: Vec::new() }));
    let points = contacts(&Geometry::Plane, Pose::IDENTITY, &hull, Pose::IDENTITY, 0.01);
    let low = points.iter().filter(|p| (p.gap - 0.0001).abs() < 1e-12).count();
    assert_eq!(low, 5, "{points:?}");
}
