//! Distances and rays on random shapes. A distance is proved by its own answer: both points are in their shapes (it is no smaller), and the
//! normal separates the shapes by it (it is no larger), by support functions written for the tests. A ray is marched.

use signorini_collision::{Nearest, Queries, Ray};
use signorini_multibody::glam::{DMat3, DQuat, DVec3};
use signorini_multibody::model::{HeightField, Mesh};
use signorini_multibody::{Geom, GeomId, Geometry, Model, ModelBuilder, Pose};

use crate::random::{Random, cuboid_mesh};
use crate::scene::contacts;
use crate::support::{directions, extent, separation};

/// Geoms on bodies that are welded to the world: the queries place them.
fn world(shapes: &[Geometry]) -> Model {
    let mut builder = ModelBuilder::new("shapes");
    for (k, geometry) in shapes.iter().enumerate() {
        builder.body(format!("{k}")).shape(Geom::new(format!("{k}"), geometry.clone())).add().expect("a body");
    }
    builder.build().expect("a model")
}

fn queries(shapes: &[Geometry], poses: &[Pose]) -> Queries {
    let mut queries = Queries::new(&world(shapes));
    queries.place(&[&[Pose::IDENTITY], poses].concat());
    queries
}

fn cloud(random: &mut Random, points: usize) -> Mesh {
    let vertices: Vec<DVec3> = (0..points).map(|_| random.rotation() * DVec3::X * between(random, 0.2, 0.5)).collect();
    Mesh { vertices, triangles: (0..points as u32 - 2).map(|i| [i, i + 1, i + 2]).collect() }
}

const CONVEX: usize = 7;

fn shape(random: &mut Random, kind: usize) -> Geometry {
    let [radius, half_length, third] = [(); 3].map(|()| between(random, 0.1, 0.5));
    match kind {
        0 => Geometry::Sphere { radius },
        1 => Geometry::Box { half_extents: DVec3::new(radius, half_length, third) },
        2 => Geometry::Capsule { radius, half_length },
        3 => Geometry::Cylinder { radius, half_length },
        4 => Geometry::Cone { radius, half_length },
        5 => Geometry::Ellipsoid { semi_axes: DVec3::new(radius, half_length, third) },
        6 => Geometry::ConvexMesh(cloud(random, 12).into()),
        7 => Geometry::TriangleMesh(cloud(random, 9).into()),
        8 => {
            let heights = (0..20).map(|_| between(random, -0.1, 0.1)).collect();
            Geometry::HeightField(HeightField { size: [5, 4], half_extents: [0.6, 0.5], heights }.into())
        }
        _ => Geometry::Plane,
    }
}

fn between(random: &mut Random, low: f64, high: f64) -> f64 {
    low + (high - low) * random.unit()
}

fn pose(random: &mut Random, spread: f64) -> Pose {
    let position = DVec3::new(
        between(random, -spread, spread),
        between(random, -spread, spread),
        between(random, -spread, spread),
    );
    Pose::new(position, random.rotation())
}

/// How far a point sticks out of a convex shape, m, as far as some thousand directions know.
fn sticks_out(point: DVec3, shape: &Geometry, pose: &Pose) -> f64 {
    directions(2000).map(|d| d.dot(point) - extent(shape, pose, d)).fold(f64::NEG_INFINITY, f64::max)
}

#[test]
fn a_distance_is_that_of_its_points_and_of_its_normal() {
    let mut random = Random(5);
    for case in 0..600 {
        let (kind_a, kind_b) = (case % CONVEX, case / CONVEX % CONVEX);
        let shapes = [shape(&mut random, kind_a), shape(&mut random, kind_b)];
        let poses = [pose(&mut random, 1.2), pose(&mut random, 1.2)];
        let found = queries(&shapes, &poses).distance(GeomId(0), GeomId(1)).expect("solids have a distance");
        let Nearest { distance, normal, point_a, point_b, .. } = found;
        let name = format!("case {case}: {} and {}: {found:?}", shapes[0].kind_name(), shapes[1].kind_name());
        let curved = [kind_a, kind_b].iter().any(|kind| [3, 4, 5].contains(kind));
        let small = if curved { 2e-8 } else { 1e-11 };
        let apart = separation((&shapes[0], &poses[0]), (&shapes[1], &poses[1]), normal);
        assert!((normal.length() - 1.0).abs() < 1e-12 && (apart - distance).abs() < small, "{name}: {apart}");
        assert!((point_b - point_a - normal * distance).length() < if curved { 1e-4 } else { 1e-9 }, "{name}");
        if distance > 0.0 {
            let out = sticks_out(point_a, &shapes[0], &poses[0]).max(sticks_out(point_b, &shapes[1], &poses[1]));
            assert!(out < if curved { 1e-5 } else { 1e-9 }, "{name}: {out}");
        }
        let back = queries(&shapes, &poses).distance(GeomId(1), GeomId(0)).expect("as before");
        assert!((back.distance - distance).abs() < small, "{name}: {back:?}");
    }
}

/// Shapes turned by quarters and eighths, far inside each other: several directions separate them nearly as well. The points of an overlap
/// are where the shapes reach farthest along its normal.
#[test]
fn the_points_of_an_overlap_are_the_deepest() {
    let mut random = Random(11);
    let eighth = std::f64::consts::FRAC_PI_4;
    let mut overlaps = 0;
    for case in 0..3000 {
        let shapes = [case % CONVEX, case / CONVEX % CONVEX].map(|kind| shape(&mut random, kind));
        let turned = |random: &mut Random| {
            let turn = |axis, random: &mut Random| DQuat::from_axis_angle(axis, eighth * (random.unit() * 8.0).floor());
            turn(DVec3::X, random) * turn(DVec3::Z, random) * turn(DVec3::Y, random)
        };
        let aside = DVec3::AXES[(random.unit() * 3.0) as usize] * between(&mut random, 0.0, 0.5);
        let poses = [Pose::new(DVec3::ZERO, turned(&mut random)), Pose::new(aside, turned(&mut random))];
        let found = queries(&shapes, &poses).distance(GeomId(0), GeomId(1)).expect("solids have a distance");
        if found.distance > -1e-3 {
            continue;
        }
        overlaps += 1;
        let missed = |k: usize, n: DVec3, point: DVec3| {
            (extent(&shapes[k], &poses[k], n) - n.dot(point)).abs().max(sticks_out(point, &shapes[k], &poses[k]))
        };
        let [a, b] = [missed(0, found.normal, found.point_a), missed(1, -found.normal, found.point_b)];
        let kinds = shapes.each_ref().map(|shape| shape.kind_name());
        // Where two shapes of revolution share an axis no direction about it is the deepest, and the search ends with one of them to 1e-8.
        assert!(a.max(b) < 1e-3, "case {case}: {kinds:?} by {a} and {b}: {found:?}");
    }
    assert!(overlaps > 1000, "{overlaps}");
}

/// Thin boxes and hulls that touch at edges and corners, where many directions separate them equally well, have a contact, and the points of their distance are
/// on both.
#[test]
fn thin_shapes_that_touch_have_a_contact_there() {
    let mut random = Random(14);
    for case in 0..6000 {
        let mut thin = |kind: usize| {
            let [x, y, z] = [(); 3].map(|()| 10.0_f64.powf(between(&mut random, -4.0, 0.0)));
            let half = DVec3::new(x, y, z);
            let mut rock = || (0..12).map(|_| random.vector().normalize() * half).collect();
            match kind {
                0 => Geometry::Box { half_extents: half },
                1 => cuboid_mesh(half),
                _ => Geometry::ConvexMesh(Mesh { vertices: rock(), triangles: Vec::new() }.into()),
            }
        };
        let shapes = [thin(case % 3), thin(case / 3 % 3)];
        let mut poses = [pose(&mut random, 1.0), pose(&mut random, 1.0)];
        let apart = queries(&shapes, &poses).distance(GeomId(0), GeomId(1)).expect("solids have a distance");
        poses[1].position -= apart.normal * apart.distance;
        let found = queries(&shapes, &poses).distance(GeomId(0), GeomId(1)).expect("solids have a distance");
        let name = format!("case {case}: {found:?}");
        let out =
            sticks_out(found.point_a, &shapes[0], &poses[0]).max(sticks_out(found.point_b, &shapes[1], &poses[1]));
        assert!(found.distance.abs() < 1e-8 && out < 1e-7, "{name}: {out}");
        let points = contacts(&shapes[0], poses[0], &shapes[1], poses[1], 1e-7);
        assert!(points.iter().any(|p| (p.gap - found.distance).abs() < 1e-8), "{name}: {points:?}");
    }
}

/// Of cylinders and capsules on one axis the overlap along it or across it is the least, and across it all directions are alike.
#[test]
fn shapes_on_one_axis_overlap_as_far_as_their_radii() {
    let mut random = Random(13);
    for case in 0..200 {
        let [r, h, s, g] = [(); 4].map(|()| between(&mut random, 0.1, 0.5));
        let turned = random.rotation();
        let shift = h * random.signed();
        let other = if case % 2 == 0 {
            Geometry::Cylinder { radius: s, half_length: g }
        } else {
            Geometry::Capsule { radius: s, half_length: g }
        };
        let end = if case % 2 == 0 { g } else { g + s };
        let poses = [Pose::new(DVec3::ZERO, turned), Pose::new(turned * DVec3::Z * shift, turned)];
        let shapes = [Geometry::Cylinder { radius: r, half_length: h }, other];
        let found = queries(&shapes, &poses).distance(GeomId(0), GeomId(1)).expect("solids have a distance");
        let expected = (r + s).min(h + end - shift.abs());
        assert!((found.distance + expected).abs() < 1e-11, "case {case}: {expected}, not {found:?}");
    }
}

/// A point inside an ellipsoid is as far from its surface beside a plane of symmetry as in it.
#[test]
fn the_depth_in_an_ellipsoid_is_continuous_at_its_planes() {
    let mut random = Random(12);
    for case in 0..200 {
        let [long, middle] = [(); 2].map(|()| between(&mut random, 0.2, 1.0));
        let shape = Geometry::Ellipsoid { semi_axes: DVec3::new(long, middle, 0.1) };
        let mut world = queries(&[shape, Geometry::Sphere { radius: 1e-12 }], &[Pose::IDENTITY, Pose::IDENTITY]);
        let inside = DVec3::new(long * random.signed(), middle * random.signed(), 0.0) * 0.5;
        let within = depth(&mut world, inside, &Pose::IDENTITY);
        for k in 0..20 {
            let aside = 10.0_f64.powi(-k);
            let beside = depth(&mut world, inside + DVec3::Z * (0.05 * aside), &Pose::IDENTITY);
            assert!((beside - within).abs() < 0.05 * aside + 1e-12, "case {case}: {within} and {beside} by {aside}");
        }
    }
}

/// The distance of a set of triangles is that of the nearest of them, each a shape of its own.
#[test]
fn a_mesh_is_as_far_as_its_nearest_triangle() {
    let mut random = Random(6);
    for case in 0..120 {
        let mesh = cloud(&mut random, 9);
        let other = match case % 3 {
            0 => Geometry::TriangleMesh(cloud(&mut random, 6).into()),
            1 => Geometry::Sphere { radius: 0.2 },
            _ => Geometry::Box { half_extents: DVec3::new(0.1, 0.2, 0.3) },
        };
        let poses = [pose(&mut random, 1.0), pose(&mut random, 1.0)];
        let parts = mesh.triangles.iter().map(|t| {
            let one = Mesh { vertices: t.map(|i| mesh.vertices[i as usize]).to_vec(), triangles: vec![[0, 1, 2]] };
            queries(&[Geometry::TriangleMesh(one.into()), other.clone()], &poses).distance(GeomId(0), GeomId(1))
        });
        let nearest = parts.map(|part| part.expect("triangles").distance).fold(f64::INFINITY, f64::min);
        let whole = queries(&[Geometry::TriangleMesh(mesh.clone().into()), other.clone()], &poses);
        let found = whole.clone().distance(GeomId(0), GeomId(1)).expect("a mesh has a distance");
        let back = whole.clone().distance(GeomId(1), GeomId(0)).expect("a mesh has a distance");
        assert!((found.distance - nearest).abs() < 1e-11, "case {case}: {found:?}, not {nearest}");
        assert!((back.distance - nearest).abs() < 1e-11 && (back.normal + found.normal).length() < 1e-6, "case {case}");
    }
}

#[test]
fn a_plane_sees_the_lowest_point() {
    let mut random = Random(7);
    for case in 0..200 {
        let geometry = shape(&mut random, case % (CONVEX + 2));
        let poses = [pose(&mut random, 3.0), pose(&mut random, 3.0)];
        let mut world = queries(&[Geometry::Plane, geometry.clone()], &poses);
        let found = world.distance(GeomId(0), GeomId(1)).expect("a height");
        let up = poses[0].rotation * DVec3::Z;
        let reach = match case % (CONVEX + 2) {
            ..CONVEX => extent(&geometry, &poses[1], -up),
            _ => {
                let corners = triangles(&geometry).into_iter().flatten();
                corners.map(|p| -up.dot(poses[1].transform_point(p))).fold(f64::NEG_INFINITY, f64::max)
            }
        };
        let height = -reach - up.dot(poses[0].position);
        assert!((found.distance - height).abs() < 1e-12 && (found.normal - up).length() < 1e-12, "case {case}");
        assert!((found.point_b - found.point_a - up * height).length() < 1e-12);
        assert!((up.dot(found.point_a - poses[0].position)).abs() < 1e-12);
        let back = world.distance(GeomId(1), GeomId(0)).expect("a height");
        assert!((back.distance - height).abs() < 1e-12 && (back.point_a - found.point_b).length() < 1e-12);
    }
}

/// A ball no larger than rounding at a point, and how far it is from the shape.
fn depth(queries: &mut Queries, point: DVec3, pose: &Pose) -> f64 {
    queries.place(&[Pose::IDENTITY, *pose, Pose::from_position(point)]);
    queries.distance(GeomId(0), GeomId(1)).expect("a ball has a distance").distance
}

#[test]
fn a_ray_ends_where_it_crosses_a_surface() {
    let mut random = Random(8);
    let mut hits = [0; CONVEX + 1];
    for case in 0..1200 {
        let kind = case % (CONVEX + 1);
        let solid = if kind < CONVEX { kind } else { 9 };
        let (geometry, placed) = (shape(&mut random, solid), pose(&mut random, 0.3));
        let mut world = queries(&[geometry.clone(), Geometry::Sphere { radius: 1e-12 }], &[placed, Pose::IDENTITY]);
        let origin = random.vector() * if case % 3 == 0 { 0.1 } else { 2.0 };
        let ray = Ray::new(origin, random.vector() * 0.5 - origin);
        let hit = world.ray(&ray, |geom| geom == GeomId(0));
        let inside = depth(&mut world, origin, &placed) < 0.0;
        let name = format!("case {case}: a {}, {hit:?}", geometry.kind_name());
        if solid == 9 && inside {
            assert!(hit.is_none(), "a plane is met from its front alone");
            continue;
        }
        if let Some(hit) = hit {
            let there = depth(&mut world, hit.point, &placed);
            assert!(there.abs() < 1e-9 && (hit.normal.length() - 1.0).abs() < 1e-12, "{name}: missed by {there}");
            assert_eq!(inside, hit.normal.dot(ray.direction) > 0.0, "{name}");
        }
        let end = hit.map_or(6.0, |hit| hit.distance);
        for k in 1..100 {
            let signed = depth(&mut world, origin + ray.direction * (end * f64::from(k) / 100.0), &placed);
            assert!((signed < 0.0) == inside || signed.abs() < 1e-9, "{name}: crossed before");
        }
        hits[kind] += usize::from(hit.is_some());
    }
    assert!(hits.iter().all(|&count| count > 40), "{hits:?}");
}

/// Triangles one by one, each as a system of three equations.
#[test]
fn a_ray_meets_the_nearest_triangle() {
    let mut random = Random(10);
    let mut hits = 0;
    for case in 0..400 {
        let (geometry, placed) = (shape(&mut random, 7 + case % 2), pose(&mut random, 0.3));
        let origin = random.vector() * 1.5;
        let ray = Ray::new(origin, random.vector() * 0.5 - origin);
        let hit = queries(std::slice::from_ref(&geometry), &[placed]).ray(&ray, |_| true);
        let distances = triangles(&geometry).into_iter().filter_map(|corners| {
            let [a, b, c] = corners.map(|p| placed.transform_point(p));
            let x = DMat3::from_cols(b - a, c - a, -ray.direction).inverse() * (origin - a);
            (x.x >= 0.0 && x.y >= 0.0 && x.x + x.y <= 1.0 && x.z >= 0.0).then_some(x.z)
        });
        let nearest = distances.fold(f64::INFINITY, f64::min);
        let found = hit.map_or(f64::INFINITY, |hit| hit.distance);
        assert!(found == nearest || (found - nearest).abs() < 1e-10, "case {case}: {hit:?}, not {nearest}");
        hits += usize::from(hit.is_some());
    }
    assert!(hits > 100, "{hits}");
}

fn triangles(geometry: &Geometry) -> Vec<[DVec3; 3]> {
    match geometry {
        Geometry::TriangleMesh(mesh) => mesh.triangles.iter().map(|t| t.map(|i| mesh.vertices[i as usize])).collect(),
        Geometry::HeightField(field) => {
            let ([nx, ny], [x, y]) = (field.size, field.half_extents);
            let at = |i: usize, j: usize| {
                let share = |k: usize, n: usize| 2.0 * k as f64 / (n - 1) as f64 - 1.0;
                DVec3::new(x * share(i, nx), y * share(j, ny), field.heights[j * nx + i])
            };
            let cells = (0..ny - 1).flat_map(|j| (0..nx - 1).map(move |i| (i, j)));
            cells
                .flat_map(|(i, j)| {
                    let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                    [[a, b, c], [a, c, d]]
                })
                .collect()
        }
        _ => Vec::new(),
    }
}

#[test]
fn many_rays_on_many_threads_are_the_same_rays() {
    let mut random = Random(9);
    let shapes: Vec<Geometry> = (0..40).map(|k| shape(&mut random, k % 10)).collect();
    let poses: Vec<Pose> = shapes.iter().map(|_| pose(&mut random, 3.0)).collect();
    let world = queries(&shapes, &poses);
    let mut vector = || random.vector() * 4.0;
    let rays: Vec<Ray> = (0..5000).map(|_| Ray::new(vector(), vector())).collect();
    let mut found = [1, 3].map(|threads| {
        let mut out = vec![None; rays.len()];
        world.rays_into(&rays, threads, |_| true, &mut out);
        out
    });
    assert!(found[0] == found[1]);
    // Each geom alone gives the nearest of all.
    for (ray, hit) in rays.iter().zip(&mut found[0]).take(800) {
        let alone = (0..shapes.len() as u32).filter_map(|i| world.ray(ray, |geom| geom == GeomId(i)));
        let nearest = alone.map(|hit| hit.distance).fold(f64::INFINITY, f64::min);
        assert_eq!(hit.map_or(f64::INFINITY, |hit| hit.distance), nearest);
    }
    assert!(world.ray(&Ray::new([0.0; 3], [0.0; 3]), |_| true).is_none(), "a ray without direction");
    assert!(world.ray(&Ray::new([f64::NAN; 3], [0.0, 0.0, 1.0]), |_| true).is_none());
}
