//! Families of contact problems from geometry, each a different difficulty.

use signorini_contact::ContactProblem;
use signorini_multibody::glam::{DMat3, DVec3};

use crate::{Parameters, Random, RigidBody, Scene};

/// The families, for tests that run them all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// [`box_on_plane`]
    Box,
    /// [`stack`]
    Stack,
    /// [`pyramid`]
    Pyramid,
    /// [`cluster`]
    Cluster,
    /// [`articulated`](crate::articulated)
    Articulated,
    /// [`painleve`]
    Painleve,
    /// [`wedge`]
    Wedge,
    /// [`squeeze`]
    Squeeze,
}

impl Family {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Box,
        Self::Stack,
        Self::Pyramid,
        Self::Cluster,
        Self::Articulated,
        Self::Painleve,
        Self::Wedge,
        Self::Squeeze,
    ];

    /// A small problem (`nv < 60`) of the family.
    pub fn small(self, random: &mut Random, p: &Parameters) -> ContactProblem {
        match self {
            Self::Box => {
                let slope = random.choice(&[0.0, 0.2, 0.8]);
                box_on_plane(random, p, slope)
            }
            Self::Stack => {
                let height = 2 + random.below(4);
                stack(random, p, height)
            }
            Self::Pyramid => pyramid(random, p, 2),
            Self::Cluster => {
                let bodies = 2 + random.below(7);
                cluster(random, p, bodies)
            }
            Self::Articulated => {
                let (nv, nc) = (8 + random.below(30), 2 + random.below(8));
                crate::articulated(random, p, nv, nc)
            }
            Self::Painleve => {
                let (angle, speed) = (random.between(0.3, 1.3), random.between(0.0, 5.0));
                painleve(random, p, angle, speed)
            }
            Self::Wedge => {
                let (half_angle, points) = (random.between(0.15, 1.0), 1 + random.below(3));
                wedge(random, p, half_angle, points)
            }
            Self::Squeeze => {
                let boxes = 1 + random.below(3);
                squeeze(random, p, boxes)
            }
        }
    }
}

pub(crate) fn corners(x: f64, y: f64) -> [DVec3; 4] {
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(a, b)| DVec3::new(0.5 * a * x, 0.5 * b * y, 0.0))
}

/// One box on a plane inclined by `slope` rad, with four (redundant) corner contacts.
pub fn box_on_plane(random: &mut Random, p: &Parameters, slope: f64) -> ContactProblem {
    let mut scene = Scene::default();
    let size = DVec3::new(random.between(0.2, 1.0), random.between(0.2, 1.0), random.between(0.2, 1.0));
    let tilt = DMat3::from_rotation_y(slope);
    let (v, w) = p.draw_motion(random);
    let mass = 1000.0 * size.element_product();
    let body = RigidBody::cuboid(size, mass, tilt * (DVec3::Z * 0.5 * size.z), tilt).moving((tilt * v, tilt * w));
    let body = scene.body(body);
    for corner in corners(size.x, size.y) {
        scene.contact(None, Some(body), tilt * corner, tilt * DVec3::Z, p.draw_gap(random));
    }
    p.problem(&scene, random)
}

/// Boxes one upon another, four contacts at each interface; the top one is `mass_ratio` times as heavy as the bottom one.
pub fn stack(random: &mut Random, p: &Parameters, height: usize) -> ContactProblem {
    let mut scene = Scene::default();
    let (mut z, mut below) = (0.0, None);
    for k in 0..height {
        let size = DVec3::new(random.between(0.4, 0.6), random.between(0.4, 0.6), random.between(0.2, 0.4));
        let shift = if k == 0 { 0.0 } else { 0.03 };
        let center = DVec3::new(random.between(-shift, shift), random.between(-shift, shift), z + 0.5 * size.z);
        let mass = 10.0 * p.mass_ratio.powf(k as f64 / (height.max(2) - 1) as f64);
        let body = RigidBody::cuboid(size, mass, center, DMat3::IDENTITY).moving(p.draw_motion(random));
        let body = Some(scene.body(body));
        for corner in corners(0.35, 0.35) {
            scene.contact(below, body, corner + DVec3::Z * z, DVec3::Z, p.draw_gap(random));
        }
        (z, below) = (z + size.z, body);
    }
    p.problem(&scene, random)
}

/// A wall of bricks that narrows by one in each row; a brick rests on two through four points.
pub fn pyramid(random: &mut Random, p: &Parameters, rows: usize) -> ContactProblem {
    let mut scene = Scene::default();
    let size = DVec3::new(0.5, 0.3, 0.2);
    let mut below: Vec<usize> = Vec::new();
    for row in 0..rows {
        let count = rows - row;
        let mut bricks = Vec::new();
        for i in 0..count {
            let x = (i as f64 - 0.5 * (count - 1) as f64) * (size.x + 0.02);
            let mass = random.between(5.0, 15.0) * p.mass_ratio.powf(row as f64 / rows as f64);
            let center = DVec3::new(x, 0.0, (row as f64 + 0.5) * size.z);
            let body = RigidBody::cuboid(size, mass, center, DMat3::IDENTITY).moving(p.draw_motion(random));
            let brick = scene.body(body);
            for (k, corner) in corners(size.x, size.y).into_iter().enumerate() {
                let support = if row == 0 { None } else { Some(below[i + usize::from(k == 1 || k == 2)]) };
                let point = corner + DVec3::new(x, 0.0, row as f64 * size.z);
                scene.contact(support, Some(brick), point, DVec3::Z, p.draw_gap(random));
            }
            bricks.push(brick);
        }
        below = bricks;
    }
    p.problem(&scene, random)
}

/// Rough bodies in a heap on a plane: normals up to 20° off the line of centres, contact points beside it.
pub fn cluster(random: &mut Random, p: &Parameters, count: usize) -> ContactProblem {
    let mut scene = Scene::default();
    let radii: Vec<f64> = (0..count).map(|_| random.between(0.5, 1.0)).collect();
    for center in settle(random, &radii) {
        let radius = radii[scene.bodies.len()];
        let mass = 10.0 * radius.powi(3) * p.mass_ratio.powf(random.between(0.0, 1.0));
        let e = DVec3::new(random.between(0.7, 1.3), random.between(0.7, 1.3), random.between(0.7, 1.3));
        let principal = DVec3::new(e.y + e.z, e.x + e.z, e.x + e.y) * (0.2 * mass * radius * radius);
        let turn = random.rotation();
        let inertia = turn * DMat3::from_diagonal(principal) * turn.transpose();
        let (velocity, angular_velocity) = p.draw_motion(random);
        scene.body(RigidBody { mass, inertia, center, velocity, angular_velocity });
    }
    for j in 0..count {
        let (center, radius) = (scene.bodies[j].center, radii[j]);
        if center.z - radius < 0.06 || j == 0 {
            let beside = DVec3::new(random.normal(), random.normal(), 0.0) * (0.2 * radius);
            let foot = DVec3::new(center.x, center.y, 0.0);
            scene.contact(None, Some(j), foot + beside, DVec3::Z, p.draw_gap(random));
        }
        for i in 0..j {
            let apart = center - scene.bodies[i].center;
            if apart.length() < radii[i] + radius + 0.05 {
                let line = apart.normalize();
                let beside = random.normal_vector() * (0.15 * radius.min(radii[i]));
                let point = scene.bodies[i].center + line * radii[i] + beside;
                let normal = tilted(random, line, 20_f64.to_radians());
                scene.contact(Some(i), Some(j), point, normal, p.draw_gap(random));
            }
        }
    }
    p.problem(&scene, random)
}

/// Centres of balls pushed apart and down onto the plane.
fn settle(random: &mut Random, radii: &[f64]) -> Vec<DVec3> {
    let side = 0.9 * (radii.len() as f64).cbrt() + 0.6;
    let mut centers: Vec<DVec3> = radii
        .iter()
        .map(|_| DVec3::new(random.between(-side, side), random.between(-side, side), random.between(0.5, 1.6 * side)))
        .collect();
    push_apart(&mut centers, radii);
    centers
}

/// Pushes balls apart, together and down, 80 times a little.
pub(crate) fn push_apart(centers: &mut [DVec3], radii: &[f64]) {
    for _ in 0..80 {
        let old = centers.to_vec();
        for (i, center) in centers.iter_mut().enumerate() {
            for j in (0..radii.len()).filter(|&j| j != i) {
                let apart = old[i] - old[j];
                let overlap = (radii[i] + radii[j] - apart.length()).max(0.0);
                *center += apart.normalize_or_zero() * (0.25 * overlap);
            }
            *center -= DVec3::new(0.01 * center.x, 0.01 * center.y, 0.03);
            center.z = center.z.max(radii[i]);
        }
    }
}

/// A unit vector within an angle of another.
fn tilted(random: &mut Random, normal: DVec3, most: f64) -> DVec3 {
    let side = random.normal_vector().reject_from_normalized(normal).normalize();
    let (sin, cos) = random.between(0.0, most).sin_cos();
    normal * cos + side * sin
}

/// A thin rod of length 2 m and mass 1 kg whose tip slides on the plane, `angle` rad above it: with friction above a critical
/// value the contact may have no or several rate solutions (Painlevé 1895).
pub fn painleve(random: &mut Random, p: &Parameters, angle: f64, speed: f64) -> ContactProblem {
    let mut scene = Scene { timestep: random.choice(&[1e-2, 1e-4]), ..Scene::default() };
    let axis = DVec3::new(angle.cos(), 0.0, angle.sin());
    let along = DMat3::from_cols(axis * axis.x, axis * axis.y, axis * axis.z);
    let inertia = (DMat3::IDENTITY - along) * (1.0 / 3.0) + along * 5e-5;
    let angular_velocity = DVec3::Y * random.choice(&[0.0, -3.0]);
    let velocity = DVec3::NEG_X * speed + angular_velocity.cross(axis);
    let body = scene.body(RigidBody { mass: 1.0, inertia, center: axis, velocity, angular_velocity });
    scene.contact(None, Some(body), DVec3::ZERO, DVec3::Z, p.draw_gap(random));
    p.problem(&scene, random)
}

/// A ball in a V groove with this half angle (rad), `points` contacts on each wall. It jams where `tan(half_angle) ≤ μ` and
/// the gaps are negative.
pub fn wedge(random: &mut Random, p: &Parameters, half_angle: f64, points: usize) -> ContactProblem {
    let mut scene = Scene::default();
    let radius = 0.3;
    let (velocity, angular_velocity) = p.draw_motion(random);
    let inertia = DMat3::IDENTITY * (2.0 * radius * radius);
    let body = scene.body(RigidBody { mass: 5.0, inertia, center: DVec3::ZERO, velocity, angular_velocity });
    for side in [-1.0, 1.0] {
        let normal = DVec3::new(-side * half_angle.cos(), 0.0, half_angle.sin());
        for k in 0..points {
            let y = if points == 1 { 0.0 } else { -0.2 + 0.4 * k as f64 / (points - 1) as f64 };
            scene.contact(None, Some(body), DVec3::Y * y - normal * radius, normal, p.draw_gap(random));
        }
    }
    p.problem(&scene, random)
}

/// A row of boxes between two fixed walls. With negative gaps the walls are closer than the boxes are wide and the rows
/// contradict each other; with zero gaps all wall forces are indeterminate.
pub fn squeeze(random: &mut Random, p: &Parameters, count: usize) -> ContactProblem {
    let mut scene = Scene::default();
    let width = 0.4;
    for k in 0..count {
        let center = DVec3::new(k as f64 * width, 0.0, 0.2);
        scene.body(RigidBody::cuboid(DVec3::splat(width), random.between(1.0, 10.0), center, DMat3::IDENTITY));
    }
    for (y, z) in [(-0.15, 0.05), (-0.15, 0.35), (0.15, 0.05), (0.15, 0.35)] {
        for k in 0..=count {
            let point = DVec3::new((k as f64 - 0.5) * width, y, z);
            let (a, b) = (k.checked_sub(1), (k < count).then_some(k));
            scene.contact(a, b, point, DVec3::X, p.draw_gap(random));
        }
    }
    p.problem(&scene, random)
}
