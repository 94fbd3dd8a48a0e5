//! Triangle meshes and height fields.

use std::sync::Arc;

use glamx::glam::{DQuat, DVec3};
use signorini_multibody::model::{HeightField, Mesh};
use signorini_multibody::{ContactPoint, Geometry, Pose};

use crate::random::{Random, convex_shapes, cuboid_mesh};
use crate::scene::{Scene, assert_close, assert_near, assert_positions, at, contacts, cuboid, smallest_gap, turned};
use crate::support::{directions, extent};

/// A surface over [−1, 1]² as a mesh of 2·n² triangles.
fn sheet(n: u32, height: impl Fn(f64, f64) -> f64) -> Geometry {
    let place = |i: u32| 2.0 * f64::from(i) / f64::from(n) - 1.0;
    let side = n + 1;
    let vertices = (0..side * side)
        .map(|k| (place(k % side), place(k / side)))
        .map(|(x, y)| DVec3::new(x, y, height(x, y)))
        .collect();
    let cells = (0..n).flat_map(|iy| (0..n).map(move |ix| iy * side + ix));
    let triangles = cells.flat_map(|k| [[k, k + 1, k + side + 1], [k, k + side + 1, k + side]]).collect();
    Geometry::TriangleMesh(Arc::new(Mesh { vertices, triangles }))
}

fn field(n: usize, height: impl Fn(f64, f64) -> f64) -> Geometry {
    let place = |i: usize| 2.0 * i as f64 / (n - 1) as f64 - 1.0;
    let heights = (0..n * n).map(|k| height(place(k % n), place(k / n))).collect();
    Geometry::HeightField(Arc::new(HeightField { size: [n, n], half_extents: [1.0, 1.0], heights }))
}

fn flat_grounds() -> [Geometry; 3] {
    [sheet(1, |_, _| 0.0), sheet(8, |_, _| 0.0), field(9, |_, _| 0.0)]
}

#[test]
fn a_box_on_flat_triangles_touches_at_its_four_corners() {
    for ground in flat_grounds() {
        for gap in [-1e-3, -1e-9, 0.0, 1e-9, 1e-3] {
            let p = contacts(&ground, Pose::IDENTITY, &cuboid(0.2, 0.3, 0.1), at(0.11, -0.07, 0.1 + gap), 2e-3);
            let corners = [[-0.09, -0.37], [0.31, -0.37], [-0.09, 0.23], [0.31, 0.23]];
            assert_positions(&p, &corners.map(|[x, y]| DVec3::new(x, y, 0.5 * gap)), 1e-8);
            assert!(p.iter().all(|c| (c.gap - gap).abs() < 1e-9 && (c.normal - DVec3::Z).length() < 1e-9), "{p:?}");
        }
    }
}

/// Points of one flat part are reduced together, however far each of them is from it.
#[test]
fn a_leaning_box_on_flat_triangles_touches_where_it_touches_a_plane() {
    let mut random = Random(24);
    for ground in flat_grounds() {
        for _ in 0..40 {
            let axis = DVec3::new(random.signed(), random.signed(), 0.0).normalize();
            let turn = DQuat::from_axis_angle(axis, 0.03 * random.unit()) * DQuat::from_rotation_z(6.0 * random.unit());
            let shape = cuboid(0.2, 0.3, 0.1);
            let mut pose = Pose::new(DVec3::new(0.2 * random.signed(), 0.2 * random.signed(), 0.0), turn);
            pose.position.z = extent(&shape, &pose, -DVec3::Z) + 1e-3 * random.signed();
            let over_plane = contacts(&Geometry::Plane, Pose::IDENTITY, &shape, pose, 0.05);
            let places: Vec<DVec3> = over_plane.iter().map(|p| p.position).collect();
            assert_eq!(places.len(), 4);
            assert_positions(&contacts(&ground, Pose::IDENTITY, &shape, pose, 0.05), &places, 1e-8);
        }
    }
}

/// A single triangle that stands on its corner carries a box on its upper edge.
#[test]
fn an_upright_triangle_carries_a_box_on_its_edge() {
    let [left, right] = [-0.3, 0.3].map(|x| DVec3::new(x, 0.0, 0.0));
    for corners in [[left, right, DVec3::Z * -0.5], [right, DVec3::Z * -0.5, left], [DVec3::Z * -0.5, right, left]] {
        let mesh = Mesh { vertices: corners.to_vec(), triangles: vec![[0, 1, 2]] };
        let triangle = Geometry::TriangleMesh(Arc::new(mesh));
        for (half, end) in [(0.2, 0.2), (0.5, 0.3)] {
            for gap in [-1e-6, 0.0, 1e-4] {
                let found =
                    contacts(&triangle, Pose::IDENTITY, &cuboid(half, 0.2, 0.1), at(0.0, 0.05, 0.1 + gap), 1e-3);
                let expected = [-end, end].map(|x| DVec3::new(x, 0.0, 0.5 * gap));
                assert_positions(&found, &expected, 1e-9);
                assert!(found.iter().all(|p| (p.normal - DVec3::Z).length() < 1e-9), "{found:?}");
            }
        }
    }
}

#[test]
fn convex_shapes_have_the_same_height_over_flat_triangles_as_over_a_plane() {
    let mut random = Random(21);
    for ground in flat_grounds() {
        for shape in convex_shapes() {
            let mut scene = Scene::new(&[ground.clone(), shape.clone()]);
            for _ in 0..40 {
                let mut pose = Pose::new(random.vector() * 0.2, random.rotation());
                let gap = 0.02 * random.signed();
                pose.position.z += gap + extent(&shape, &pose, -DVec3::Z);
                let p = scene.find(&[Pose::IDENTITY, pose], 0.05);
                let name = shape.kind_name();
                assert!((smallest_gap(&p) - gap).abs() < 1e-8, "{name}: {gap} {p:?}");
                assert!(p.iter().all(|c| (c.normal - DVec3::Z).length() < 1e-6), "{name}: {p:?}");
            }
        }
    }
}

/// Inner edges of a flat floor must not catch what slides over them, however it penetrates.
#[test]
fn inner_edges_of_a_flat_floor_give_no_sideways_normals() {
    let mut random = Random(22);
    for ground in flat_grounds() {
        for shape in [cuboid(0.1, 0.1, 0.1), Geometry::Sphere { radius: 0.1 }] {
            let mut scene = Scene::new(&[ground.clone(), shape]);
            for _ in 0..200 {
                let (x, y) = (0.5 * random.signed(), 0.5 * random.signed());
                let z = 0.1 - 1e-3 * random.unit();
                let pose = turned(x, y, z, DVec3::Z, random.signed());
                let p = scene.find(&[Pose::IDENTITY, pose], 1e-2);
                assert!(!p.is_empty() && p.iter().all(|c| (c.normal - DVec3::Z).length() < 1e-9), "{p:?}");
            }
        }
    }
}

#[test]
fn a_ridge_is_touched_with_normals_between_its_sides() {
    let roof = sheet(2, |x, _| 0.5 - x.abs());
    // A ball above the ridge x = 0.
    let p = contacts(&roof, Pose::IDENTITY, &Geometry::Sphere { radius: 0.2 }, at(0.0, 0.3, 0.75), 0.06);
    assert_close(smallest_gap(&p), 0.05, 1e-12);
    assert!(p.iter().any(|c| (c.normal - DVec3::Z).length() < 1e-9));
    // A ball on the slope, away from the ridge.
    let slope = DVec3::new(1.0, 0.0, 1.0).normalize();
    let c = DVec3::new(0.4, 0.1, 0.1) + slope * 0.21;
    let p = contacts(&roof, Pose::IDENTITY, &Geometry::Sphere { radius: 0.2 }, at(c.x, c.y, c.z), 0.02);
    assert_eq!(p.len(), 1, "{p:?}");
    assert_close(p[0].gap, 0.01, 1e-12);
    assert_near(p[0].normal, slope, 1e-9);
}

#[test]
fn a_ball_in_a_valley_touches_both_sides() {
    for ground in [sheet(2, |x, _| x.abs()), field(3, |x, _| x.abs())] {
        let height = 0.2 * 2.0_f64.sqrt();
        let p = contacts(&ground, Pose::IDENTITY, &Geometry::Sphere { radius: 0.2 }, at(0.0, 0.3, height), 1e-6);
        let sides = [DVec3::new(1.0, 0.0, 1.0).normalize(), DVec3::new(-1.0, 0.0, 1.0).normalize()];
        assert_eq!(p.len(), 2, "{p:?}");
        for side in sides {
            let on_side = p.iter().find(|c| (c.normal - side).length() < 1e-9).unwrap();
            assert_close(on_side.gap, 0.0, 1e-12);
        }
    }
}

#[test]
fn a_height_field_pushes_up_from_below_its_surface() {
    let ground = field(9, |_, _| 0.0);
    let p = contacts(&ground, Pose::IDENTITY, &Geometry::Sphere { radius: 0.2 }, at(0.05, 0.1, -0.1), 0.01);
    assert_eq!(p.len(), 1, "{p:?}");
    assert_close(p[0].gap, -0.3, 1e-12);
    assert_near(p[0].normal, DVec3::Z, 1e-12);
}

#[test]
fn height_field_places_its_rows_along_y() {
    let ground = field(5, |x, y| 0.1 * x + 0.3 * y);
    let normal = DVec3::new(-0.1, -0.3, 1.0).normalize();
    let on = DVec3::new(0.4, -0.6, 0.1 * 0.4 - 0.3 * 0.6);
    let c = on + normal * 0.11;
    let p = contacts(&ground, Pose::IDENTITY, &Geometry::Sphere { radius: 0.1 }, at(c.x, c.y, c.z), 0.02);
    assert_eq!(p.len(), 1, "{p:?}");
    assert_close(p[0].gap, 0.01, 1e-12);
    assert_near(p[0].normal, normal, 1e-9);
}

#[test]
fn a_box_mesh_and_a_box_agree_from_outside() {
    let Geometry::ConvexMesh(points) = cuboid_mesh(DVec3::new(0.5, 0.4, 0.3)) else { unreachable!() };
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect();
    let mesh = Geometry::TriangleMesh(Arc::new(Mesh { vertices: points.vertices.clone(), triangles }));
    let solid = cuboid(0.5, 0.4, 0.3);
    let mut random = Random(23);
    for shape in
        [cuboid(0.2, 0.1, 0.15), Geometry::Sphere { radius: 0.2 }, Geometry::Capsule { radius: 0.1, half_length: 0.2 }]
    {
        let (mut by_mesh, mut by_box) =
            (Scene::new(&[mesh.clone(), shape.clone()]), Scene::new(&[solid.clone(), shape]));
        for _ in 0..100 {
            let ray = random.vector().normalize();
            let pose = Pose::new(ray * (0.75 + 0.15 * random.unit()), random.rotation());
            let (p, q) = (by_mesh.find(&[Pose::IDENTITY, pose], 0.2), by_box.find(&[Pose::IDENTITY, pose], 0.2));
            let (gap, expected) = (smallest_gap(&p), smallest_gap(&q));
            if expected.is_finite() && expected > 1e-6 {
                assert!((gap - expected).abs() < 1e-7 + 1.1e-3 * expected, "{gap} {expected} {p:?} {q:?}");
            }
        }
    }
}

#[test]
fn degenerate_triangles_are_harmless() {
    let vertices = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::X * 2.0];
    let mesh = Mesh { vertices, triangles: vec![[0, 1, 3], [0, 0, 1], [2, 2, 2], [0, 1, 2]] };
    let ground = Geometry::TriangleMesh(Arc::new(mesh));
    let p = contacts(&ground, Pose::IDENTITY, &Geometry::Sphere { radius: 0.1 }, at(0.2, 0.2, 0.1), 1e-6);
    assert_eq!(p.len(), 1, "{p:?}");
    assert_near(p[0].normal, DVec3::Z, 1e-12);
    let empty = Geometry::TriangleMesh(Arc::new(Mesh { vertices: vec![DVec3::ZERO; 3], triangles: vec![[0, 1, 2]] }));
    assert!(contacts(&empty, Pose::IDENTITY, &cuboid(1.0, 1.0, 1.0), at(0.0, 0.0, 0.0), 0.1).is_empty());
}

#[test]
fn a_turned_box_on_triangles_is_like_on_a_plane() {
    let ground = sheet(8, |_, _| 0.0);
    let turn = DQuat::from_rotation_x(22.0_f64.to_radians());
    let shape = cuboid(0.3, 0.2, 0.001);
    let mut pose = Pose::new(DVec3::new(0.05, 0.02, 0.0), turn);
    pose.position.z = extent(&shape, &pose, -DVec3::Z);
    let p = contacts(&ground, Pose::IDENTITY, &shape, pose, 1e-6);
    assert_eq!(p.len(), 2, "{p:?}");
    assert_close((p[0].position - p[1].position).length(), 0.6, 1e-6);
}

/// Thin, slightly curved membranes (the wings of a fly) have a hull: every corner of it stands where brute force finds it.
#[test]
fn membranes_have_hulls() {
    for seed in 0..40 {
        let mut random = Random(seed);
        let thickness = 10.0_f64.powf(-2.0 - 4.0 * random.unit());
        let turn = random.rotation();
        let vertices = (0..600).map(|_| {
            let (x, y) = (1.3 * random.signed(), 0.55 * random.signed());
            let p = turn * DVec3::new(x, y, thickness * (x * x - y + 0.1 * random.signed()));
            // As files have them: single precision.
            p.as_vec3().as_dvec3()
        });
        let mesh = Mesh { vertices: vertices.collect(), triangles: vec![] };
        let (shape, pose) = (Geometry::ConvexMesh(Arc::new(mesh)), Pose::IDENTITY);
        let mut scene = Scene::new(&[Geometry::Plane, shape.clone()]);
        for d in directions(20) {
            let up = DQuat::from_rotation_arc(d, DVec3::Z);
            let stood = Pose::new(DVec3::Z * extent(&shape, &pose, -d), up);
            let found = scene.find(&[Pose::IDENTITY, stood], 1e-3);
            let lowest = found.iter().map(|c| c.gap).fold(f64::INFINITY, f64::min);
            assert!(lowest.abs() < 1e-5, "seed {seed}, thickness {thickness:e}: off by {lowest:e}");
        }
    }
}

/// A solid over the faces of a tetrahedron that was split again and again, its corners at random distances from the middle: ridges, valleys and
/// obtuse triangles.
pub fn crumpled(random: &mut Random) -> Mesh {
    let mut vertices =
        vec![DVec3::ONE, DVec3::new(1.0, -1.0, -1.0), DVec3::new(-1.0, 1.0, -1.0), DVec3::new(-1.0, -1.0, 1.0)];
    let mut triangles = vec![[0_u32, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]];
    for _ in 0..6 {
        let [a, b, c] = triangles.swap_remove((random.unit() * triangles.len() as f64) as usize);
        let new = vertices.len() as u32;
        vertices.push([a, b, c].iter().map(|i| vertices[*i as usize] * (0.2 + random.unit())).sum());
        triangles.extend([[a, b, new], [b, c, new], [c, a, new]]);
    }
    let vertices = vertices.iter().map(|v| v.normalize() * (0.3 + 0.7 * random.unit())).collect();
    Mesh { vertices, triangles }
}

/// Distance of a point from a triangle: from its plane where it is over the triangle, else from its sides.
fn from_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a).normalize();
    let sides = [(a, b), (b, c), (c, a)];
    if sides.iter().all(|(s, t)| (t - s).cross(p - s).dot(normal) >= 0.0) {
        return normal.dot(p - a).abs();
    }
    let from_side = |(s, t): (DVec3, DVec3)| {
        let along = ((p - s).dot(t - s) / (t - s).length_squared()).clamp(0.0, 1.0);
        (p - s.lerp(t, along)).length()
    };
    sides.map(from_side).into_iter().fold(f64::INFINITY, f64::min)
}

/// Whether a point is inside a solid that is seen whole from the origin: under the triangle that hides it.
fn is_under(p: DVec3, [a, b, c]: [DVec3; 3]) -> bool {
    let hidden = [(a, b), (b, c), (c, a)].iter().all(|(s, t)| s.cross(*t).dot(p) >= 0.0);
    hidden && (b - a).cross(c - a).dot(p - a) < 0.0
}

/// Outside a mesh the deepest contact of a ball is where the mesh is nearest, on ridges beside obtuse corners as well.
#[test]
fn a_ball_touches_a_mesh_where_it_is_nearest() {
    let mut random = Random(31);
    let radius = 0.01;
    let mut checked = 0;
    for _ in 0..300 {
        let mesh = crumpled(&mut random);
        let corners: Vec<_> = mesh.triangles.iter().map(|t| t.map(|i| mesh.vertices[i as usize])).collect();
        let ball = Geometry::Sphere { radius };
        let mut scene = Scene::new(&[Geometry::TriangleMesh(Arc::new(mesh)), ball]);
        for _ in 0..40 {
            let place = random.vector().normalize() * (0.3 + random.unit());
            if corners.iter().any(|t| is_under(place, *t)) {
                continue;
            }
            let nearest = corners.iter().map(|t| from_triangle(place, *t)).fold(f64::INFINITY, f64::min);
            let found = scene.find(&[Pose::IDENTITY, Pose::from_position(place)], 1.1 * nearest);
            assert_close(smallest_gap(&found), nearest - radius, 1e-12);
            checked += 1;
        }
    }
    assert!(checked > 4000, "{checked}");
}

/// All contacts of a ball outside a mesh, and not the deepest alone, are at corners or where no place of the mesh beside them is nearer, and there is one at every
/// such place.
#[test]
fn a_ball_touches_a_mesh_wherever_it_is_nearer_than_all_around() {
    let mut random = Random(32);
    let radius = 0.01;
    let (mut checked, mut several) = (0, 0);
    for _ in 0..200 {
        let mesh = crumpled(&mut random);
        let corners: Vec<_> = mesh.triangles.iter().map(|t| t.map(|i| mesh.vertices[i as usize])).collect();
        let mut scene = Scene::new(&[Geometry::TriangleMesh(Arc::new(mesh)), Geometry::Sphere { radius }]);
        // How much nearer the triangles that hold a place come than the place does.
        let lost = |place: DVec3, ball: DVec3| {
            let around = corners.iter().filter(|t| from_triangle(place, **t) < 1e-9);
            around.map(|t| (ball - place).length() - from_triangle(ball, *t)).fold(f64::NEG_INFINITY, f64::max)
        };
        for _ in 0..20 {
            let ball = random.vector().normalize() * (0.3 + random.unit());
            if corners.iter().any(|t| is_under(ball, *t)) {
                continue;
            }
            let margin = 0.5;
            let found = scene.find(&[Pose::IDENTITY, Pose::from_position(ball)], margin);
            for point in &found {
                let place = point.position - point.normal * (0.5 * point.gap);
                assert_close((ball - place).length(), point.gap + radius, 1e-9);
                let is_corner = corners.iter().flatten().any(|corner| (*corner - place).length() < 1e-9);
                assert!(is_corner || lost(place, ball).abs() < 1e-8, "{point:?}: {}", lost(place, ball));
            }
            for t in &corners {
                let distance = from_triangle(ball, *t);
                let place = nearest_of(ball, *t);
                // Through the solid a place is seen from behind.
                let before = place + (ball - place) * 1e-6;
                let is_seen = !corners.iter().any(|t| is_under(before, *t));
                if distance < margin && lost(place, ball) < 1e-12 && is_seen {
                    let is_there = |p: &ContactPoint| (p.position - p.normal * (0.5 * p.gap) - place).length() < 1e-8;
                    assert!(found.iter().any(is_there), "nothing at {place}: {found:?}");
                    checked += 1;
                }
            }
            several += usize::from(found.len() > 1);
        }
    }
    assert!(checked > 1000 && several > 300, "{checked} {several}");
}

/// The nearest point of a triangle: under the place, or else on a side.
fn nearest_of(p: DVec3, [a, b, c]: [DVec3; 3]) -> DVec3 {
    let normal = (b - a).cross(c - a).normalize();
    let below = p - normal * normal.dot(p - a);
    let sides = [(a, b), (b, c), (c, a)];
    if sides.iter().all(|(s, t)| (t - s).cross(p - s).dot(normal) >= 0.0) {
        return below;
    }
    let on_side = |(s, t): (DVec3, DVec3)| s.lerp(t, ((p - s).dot(t - s) / (t - s).length_squared()).clamp(0.0, 1.0));
    let nearest = sides.map(on_side).into_iter().min_by(|x, y| (*x - p).length().total_cmp(&(*y - p).length()));
    nearest.expect("three sides")
}
