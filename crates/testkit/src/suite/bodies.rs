//! Scenes of free bodies. What they are is told at their namesakes in [`families`](crate::families).

use signorini_contact::{ContactProblem, FrictionPolygon};
use signorini_multibody::glam::{DMat3, DVec3};

use super::draw::Draw;
use crate::families::{corners, push_apart};
use crate::{RigidBody, Scene};

impl Draw {
    fn problem(&self, scene: &Scene) -> ContactProblem {
        let polygon = FrictionPolygon::regular(self.common.directions, 0.0).expect("an even number of directions");
        scene.problem(|_| (self.common.friction, polygon.clone()))
    }
}

pub(super) fn box_on_plane(draw: &mut Draw, slope: f64) -> ContactProblem {
    let mut scene = Scene::default();
    let size = DVec3::from_array(draw.random.array(0.2, 1.0));
    let tilt = DMat3::from_rotation_y(slope);
    let (v, w) = draw.motion();
    let mass = 1000.0 * size.element_product();
    let cuboid = RigidBody::cuboid(size, mass, tilt * (DVec3::Z * 0.5 * size.z), tilt);
    let body = scene.body(cuboid.moving((tilt * v, tilt * w)));
    for corner in corners(size.x, size.y) {
        scene.contact(None, Some(body), tilt * corner, tilt * DVec3::Z, draw.gap());
    }
    draw.problem(&scene)
}

/// `ratio`: mass of the top box relative to the bottom one; every contact is given `copies` times, moved by up to `jitter` m.
pub(super) fn stack(draw: &mut Draw, boxes: usize, ratio: f64, copies: usize, jitter: f64) -> ContactProblem {
    let mut scene = Scene::default();
    let (mut z, mut below) = (0.0, None);
    for k in 0..boxes {
        let [x, y] = draw.random.array(0.4, 0.6);
        let size = DVec3::new(x, y, draw.random.between(0.2, 0.4));
        let [dx, dy] = if k > 0 { draw.random.array(-0.03, 0.03) } else { [0.0; 2] };
        let motion = draw.motion();
        let mass = 10.0 * ratio.powf(k as f64 / (boxes.max(2) - 1) as f64);
        let center = DVec3::new(dx, dy, z + 0.5 * size.z);
        let body = Some(scene.body(RigidBody::cuboid(size, mass, center, DMat3::IDENTITY).moving(motion)));
        for corner in corners(0.35, 0.35) {
            for _ in 0..copies {
                let [dx, dy] = if jitter > 0.0 { draw.random.array(-jitter, jitter) } else { [0.0; 2] };
                scene.contact(below, body, corner + DVec3::new(dx, dy, z), DVec3::Z, draw.gap());
            }
        }
        (z, below) = (z + size.z, body);
    }
    draw.problem(&scene)
}

pub(super) fn pyramid(draw: &mut Draw, rows: usize) -> ContactProblem {
    let mut scene = Scene::default();
    let size = DVec3::new(0.5, 0.3, 0.2);
    let mut below: Vec<usize> = Vec::new();
    for row in 0..rows {
        let count = rows - row;
        let mut bricks = Vec::new();
        for i in 0..count {
            let x = (i as f64 - 0.5 * (count - 1) as f64) * (size.x + 0.02);
            let motion = draw.motion();
            let mass = draw.random.between(5.0, 15.0);
            let center = DVec3::new(x, 0.0, (row as f64 + 0.5) * size.z);
            let brick = scene.body(RigidBody::cuboid(size, mass, center, DMat3::IDENTITY).moving(motion));
            let points = if row == 0 {
                corners(size.x, size.y).map(|corner| (None, corner))
            } else {
                // The two points on the left brick, then those on the right one.
                let [a, b, c, d] = corners(size.x, size.y);
                let (left, right) = (Some(below[i]), Some(below[i + 1]));
                [(left, a), (left, d), (right, b), (right, c)]
            };
            for (support, corner) in points {
                let point = corner + DVec3::new(x, 0.0, row as f64 * size.z);
                scene.contact(support, Some(brick), point, DVec3::Z, draw.gap());
            }
            bricks.push(brick);
        }
        below = bricks;
    }
    draw.problem(&scene)
}

/// `turned`: every contact has its own orientation of the friction directions.
pub(super) fn cluster(draw: &mut Draw, count: usize, ratio: f64, turned: bool) -> ContactProblem {
    let radii = draw.random.list(count, 0.5, 1.0);
    let centers = settle(draw, &radii);
    let mut scene = heap(draw, &centers, &radii, ratio);
    for j in 0..count {
        if centers[j].z - radii[j] < 0.06 {
            let [x, y] = std::array::from_fn(|_| 0.2 * radii[j] * draw.random.normal());
            let point = DVec3::new(centers[j].x + x, centers[j].y + y, 0.0);
            scene.contact(None, Some(j), point, DVec3::Z, draw.gap());
        }
        for i in 0..j {
            let apart = centers[j] - centers[i];
            if apart.length() < radii[i] + radii[j] + 0.05 {
                let line = apart.normalize();
                let beside = 0.15 * radii[i].min(radii[j]) * draw.random.normal_vector();
                let normal = tilted(draw, line);
                scene.contact(Some(i), Some(j), centers[i] + line * radii[i] + beside, normal, draw.gap());
            }
        }
    }
    if scene.contacts.is_empty() {
        scene.contact(None, Some(0), centers[0].with_z(0.0), DVec3::Z, draw.gap());
    }
    scene.problem(|_| {
        let angle = if turned { draw.random.between(0.0, std::f64::consts::TAU) } else { 0.0 };
        let polygon = FrictionPolygon::regular(draw.common.directions, angle).expect("an even number of directions");
        (draw.common.friction, polygon)
    })
}

fn settle(draw: &mut Draw, radii: &[f64]) -> Vec<DVec3> {
    let side = 0.9 * (radii.len() as f64).powf(1.0 / 3.0) + 0.6;
    let plan: Vec<[f64; 2]> = radii.iter().map(|_| draw.random.array(-side, side)).collect();
    let mut centers: Vec<DVec3> =
        plan.iter().map(|[x, y]| DVec3::new(*x, *y, draw.random.between(0.5, 1.6 * side))).collect();
    push_apart(&mut centers, radii);
    centers
}

/// The bodies of a cluster, without contacts.
fn heap(draw: &mut Draw, centers: &[DVec3], radii: &[f64], ratio: f64) -> Scene {
    let mut scene = Scene::default();
    let exponents = draw.random.list(radii.len(), 0.0, 1.0);
    for (k, &center) in centers.iter().enumerate() {
        let mass = 10.0 * radii[k].powi(3) * ratio.powf(exponents[k]);
        let (velocity, angular_velocity) = draw.motion();
        let e = DVec3::from_array(draw.random.array(0.7, 1.3));
        let principal = DVec3::new(e.y + e.z, e.x + e.z, e.x + e.y) * (0.2 * mass * radii[k] * radii[k]);
        let turn = draw.random.rotation();
        let inertia = turn * DMat3::from_diagonal(principal) * turn.transpose();
        scene.body(RigidBody { mass, inertia, center, velocity, angular_velocity });
    }
    scene
}

/// A unit vector within 20° of another.
fn tilted(draw: &mut Draw, normal: DVec3) -> DVec3 {
    let side = draw.random.normal_vector().reject_from_normalized(normal).normalize();
    let (sin, cos) = draw.random.between(0.0, 20.0).to_radians().sin_cos();
    normal * cos + side * sin
}

/// `angle`: rad above the plane; `speed`: of the tip, m/s; `spin`: rad/s.
pub(super) fn painleve(draw: &mut Draw, angle: f64, speed: f64, spin: f64, timestep: f64) -> ContactProblem {
    let mut scene = Scene { timestep, ..Scene::default() };
    let axis = DVec3::new(angle.cos(), 0.0, angle.sin());
    let along = DMat3::from_cols(axis * axis.x, axis * axis.y, axis * axis.z);
    let inertia = (DMat3::IDENTITY - along) * (1.0 / 3.0) + along * 5e-5;
    let angular_velocity = DVec3::Y * spin;
    let velocity = DVec3::NEG_X * speed + angular_velocity.cross(axis);
    let body = scene.body(RigidBody { mass: 1.0, inertia, center: axis, velocity, angular_velocity });
    scene.contact(None, Some(body), DVec3::ZERO, DVec3::Z, draw.gap());
    draw.problem(&scene)
}

pub(super) fn wedge(draw: &mut Draw, half_angle: f64, points: usize) -> ContactProblem {
    let mut scene = Scene::default();
    let radius = 0.3;
    let (velocity, angular_velocity) = draw.motion();
    let inertia = DMat3::IDENTITY * (2.0 * radius * radius);
    let body = scene.body(RigidBody { mass: 5.0, inertia, center: DVec3::ZERO, velocity, angular_velocity });
    for side in [-1.0, 1.0] {
        let normal = DVec3::new(-side * half_angle.cos(), 0.0, half_angle.sin());
        for k in 0..points {
            let y = if points == 1 { 0.0 } else { -0.2 + 0.4 * k as f64 / (points - 1) as f64 };
            scene.contact(None, Some(body), DVec3::Y * y - normal * radius, normal, draw.gap());
        }
    }
    draw.problem(&scene)
}

/// `depth`: how far the boxes reach into their neighbours and the walls, m.
pub(super) fn squeeze(draw: &mut Draw, boxes: usize, depth: f64) -> ContactProblem {
    let mut scene = Scene::default();
    let width = 0.4;
    for k in 0..boxes {
        let center = DVec3::new(k as f64 * width, 0.0, 0.2);
        let mass = draw.random.between(1.0, 10.0);
        scene.body(RigidBody::cuboid(DVec3::splat(width), mass, center, DMat3::IDENTITY));
    }
    for (y, z) in [(-0.15, 0.05), (-0.15, 0.35), (0.15, 0.05), (0.15, 0.35)] {
        for k in 0..=boxes {
            let point = DVec3::new((k as f64 - 0.5) * width, y, z);
            scene.contact(k.checked_sub(1), (k < boxes).then_some(k), point, DVec3::X, -depth);
        }
    }
    draw.problem(&scene)
}
