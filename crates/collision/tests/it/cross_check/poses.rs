//! Pairs of shapes in random and in degenerate poses.

use std::f64::consts::FRAC_PI_4;
use std::sync::Arc;

use glamx::glam::{DQuat, DVec3};
use signorini_multibody::model::Mesh;
use signorini_multibody::{Geometry, Pose};

use crate::random::{Random, cuboid_mesh};
use crate::support::{extent, separation};

/// Sorts of shapes; the plane stands for A only.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Plane,
    Sphere,
    Capsule,
    Box,
    Cylinder,
    Ellipsoid,
    Cone,
    Rock,
    CuboidMesh,
}

const KINDS: [Kind; 9] = [
    Kind::Plane,
    Kind::Sphere,
    Kind::Capsule,
    Kind::Box,
    Kind::Cylinder,
    Kind::Ellipsoid,
    Kind::Cone,
    Kind::Rock,
    Kind::CuboidMesh,
];

impl Kind {
    pub fn all() -> impl Iterator<Item = Self> {
        KINDS.into_iter()
    }

    /// A shape with lengths between 5 cm and a metre.
    fn shape(self, random: &mut Random) -> Geometry {
        let mut length = || 0.05 * 20.0_f64.powf(random.unit());
        let (x, y, z) = (length(), length(), length());
        match self {
            Self::Plane => Geometry::Plane,
            Self::Sphere => Geometry::Sphere { radius: 0.5 * x },
            Self::Capsule => Geometry::Capsule { radius: 0.3 * x, half_length: 0.4 * y },
            Self::Box => Geometry::Box { half_extents: DVec3::new(x, y, z) * 0.5 },
            Self::Cylinder => Geometry::Cylinder { radius: 0.5 * x, half_length: 0.5 * y },
            Self::Ellipsoid => Geometry::Ellipsoid { semi_axes: DVec3::new(x, y, z) * 0.5 },
            Self::Cone => Geometry::Cone { radius: 0.5 * x, half_length: 0.5 * y },
            Self::Rock => {
                let axes = DVec3::new(x, y, z) * 0.5;
                let vertices = (0..12).map(|_| random.vector().normalize() * axes).collect();
                Geometry::ConvexMesh(Arc::new(Mesh { vertices, triangles: Vec::new() }))
            }
            Self::CuboidMesh => cuboid_mesh(DVec3::new(x, y, z) * 0.5),
        }
    }
}

/// How B stands to A.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Anyhow.
    Random,
    /// Faces parallel: turned by quarters, anywhere on the face.
    Flat,
    /// On one axis, turned about it.
    Coaxial,
    /// Edges towards each other: turned by eighths about two axes.
    Edges,
    /// Nearly parallel: tilted by 1e-12 to 1e-3.
    Tilted,
    /// Parallel, and side by side or end to end to the last digit.
    Aligned,
}

pub const MODES: [Mode; 6] = [Mode::Random, Mode::Flat, Mode::Coaxial, Mode::Edges, Mode::Tilted, Mode::Aligned];

/// Two shapes and their poses.
#[derive(Clone, Debug)]
pub struct Pair {
    pub a: Geometry,
    pub b: Geometry,
    pub x_a: Pose,
    pub x_b: Pose,
    pub seed: u64,
}

/// The pair of a seed.
pub fn pair(a: Kind, b: Kind, mode: Mode, seed: u64) -> Pair {
    let mut random =
        Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ ((a as u64) << 8 | (b as u64) << 4 | mode as u64));
    let (shape_a, shape_b) = (a.shape(&mut random), b.shape(&mut random));
    let (direction, mut x_b) = relative(mode, &mut random);
    let direction = if a == Kind::Plane { DVec3::Z } else { direction };
    if mode == Mode::Aligned && a != Kind::Plane {
        // Beside A to the last digit in one direction, before it is moved along the other.
        let side = if direction.x.abs() > 0.5 { DVec3::Y } else { DVec3::X };
        let sum = extent(&shape_a, &Pose::IDENTITY, side) + extent(&shape_b, &x_b, -side);
        x_b.position += side * (sum * (random.unit() * 3.0).floor() * 0.5);
    }
    let gap = [0.1, 1e-2, 1e-3, 1e-9, 0.0, -1e-9, -1e-3, -0.02][(random.unit() * 8.0) as usize];
    let now = match a {
        Kind::Plane => -extent(&shape_b, &x_b, -DVec3::Z),
        _ => separation((&shape_a, &Pose::IDENTITY), (&shape_b, &x_b), direction),
    };
    x_b.position += direction * (gap - now);
    let anywhere = a != Kind::Plane && random.unit() < 0.5;
    let x_a = if anywhere { Pose::new(random.vector(), random.rotation()) } else { Pose::IDENTITY };
    Pair { a: shape_a, b: shape_b, x_a, x_b: x_a * x_b, seed }
}

/// The direction from A to B, and B's pose up to a motion along it.
fn relative(mode: Mode, random: &mut Random) -> (DVec3, Pose) {
    let axis = |random: &mut Random| {
        let axis = [DVec3::X, DVec3::Y, DVec3::Z][(random.unit() * 3.0) as usize];
        if random.unit() < 0.5 { axis } else { -axis }
    };
    let turn = |random: &mut Random, step: f64| {
        let times = (random.unit() * 8.0).floor();
        DQuat::from_axis_angle(axis(random), times * step)
    };
    let direction = axis(random);
    let across = |v: DVec3| v - direction * v.dot(direction);
    match mode {
        Mode::Random => (random.vector().normalize(), Pose::new(random.vector() * 0.3, random.rotation())),
        Mode::Flat => {
            let rotation = turn(random, 2.0 * FRAC_PI_4) * turn(random, 2.0 * FRAC_PI_4);
            (direction, Pose::new(across(random.vector()) * 0.3, rotation))
        }
        Mode::Coaxial => {
            let about = DQuat::from_axis_angle(direction, random.signed() * 3.0);
            (direction, Pose::new(DVec3::ZERO, about * turn(random, 2.0 * FRAC_PI_4)))
        }
        Mode::Edges => {
            let rotation = turn(random, FRAC_PI_4) * turn(random, FRAC_PI_4);
            (direction, Pose::new(across(random.vector()) * 0.2, rotation))
        }
        Mode::Tilted => {
            let tilt = 10.0_f64.powf(-12.0 + 9.0 * random.unit());
            let rotation = DQuat::from_axis_angle(random.vector().normalize(), tilt) * turn(random, 2.0 * FRAC_PI_4);
            (direction, Pose::new(across(random.vector()) * 0.3, rotation))
        }
        Mode::Aligned => (direction, Pose::new(DVec3::ZERO, turn(random, 2.0 * FRAC_PI_4))),
    }
}
