//! Small worlds for the tests.

use glamx::glam::{DMat3, DQuat, DVec3};
use signorini_collision::{Collider, Reach};
use signorini_multibody::{BodyId, ContactPoint, Geom, Geometry, Inertia, Joint, JointKind, Model, ModelBuilder, Pose};

/// Geoms, each on a body of its own; planes, meshes and height fields on the world.
pub struct Scene {
    pub model: Model,
    pub collider: Collider,
    pub bodies: Vec<usize>,
}

impl Scene {
    pub fn new(shapes: &[Geometry]) -> Self {
        let fixed =
            |shape: &Geometry| matches!(shape, Geometry::Plane | Geometry::TriangleMesh(_) | Geometry::HeightField(_));
        Self::with_fixed(shapes, fixed)
    }

    /// All geoms on bodies that move.
    pub fn of_moving(shapes: &[Geometry]) -> Self {
        Self::with_fixed(shapes, |_| false)
    }

    fn with_fixed(shapes: &[Geometry], fixed: impl Fn(&Geometry) -> bool) -> Self {
        let mut builder = ModelBuilder::new("scene");
        let mut bodies = Vec::new();
        for (i, shape) in shapes.iter().enumerate() {
            let body = if fixed(shape) {
                BodyId::WORLD
            } else {
                let inertia = Inertia { mass: 1.0, center_of_mass: DVec3::ZERO, rotational: DMat3::IDENTITY };
                let body = builder.add_body(format!("b{i}"), BodyId::WORLD, Pose::IDENTITY, inertia).unwrap();
                builder.add_joint(body, Joint::new(format!("j{i}"), JointKind::Free)).unwrap();
                body
            };
            builder.add_geom(body, Geom::new(format!("g{i}"), shape.clone())).unwrap();
            bodies.push(body.index());
        }
        let model = builder.build().unwrap();
        let collider = Collider::new(&model).unwrap();
        Self { model, collider, bodies }
    }

    /// Contacts within `margin` of geoms at `poses` (those of fixed geoms are ignored).
    pub fn find(&mut self, poses: &[Pose], margin: f64) -> Vec<ContactPoint> {
        let mut body_pose = vec![Pose::IDENTITY; self.model.bodies.len()];
        for (body, pose) in self.bodies.iter().zip(poses) {
            if *body != 0 {
                body_pose[*body] = *pose;
            }
        }
        let reach = vec![Reach { linear: 0.5 * margin, angular: 0.0 }; body_pose.len()];
        let mut out = Vec::new();
        self.collider.find(&self.model, &body_pose, &reach, &mut out);
        out
    }
}

/// Contacts of two shapes.
pub fn contacts(a: &Geometry, x_a: Pose, b: &Geometry, x_b: Pose, margin: f64) -> Vec<ContactPoint> {
    Scene::new(&[a.clone(), b.clone()]).find(&[x_a, x_b], margin)
}

pub fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::from_position(DVec3::new(x, y, z))
}

pub fn turned(x: f64, y: f64, z: f64, axis: DVec3, angle: f64) -> Pose {
    Pose::new(DVec3::new(x, y, z), DQuat::from_axis_angle(axis.normalize(), angle))
}

pub fn cuboid(x: f64, y: f64, z: f64) -> Geometry {
    Geometry::Box { half_extents: DVec3::new(x, y, z) }
}

pub fn smallest_gap(points: &[ContactPoint]) -> f64 {
    points.iter().map(|p| p.gap).fold(f64::INFINITY, f64::min)
}

#[track_caller]
pub fn assert_close(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "found {found:.17}, expected {expected:.17}");
}

#[track_caller]
pub fn assert_near(found: DVec3, expected: DVec3, tolerance: f64) {
    assert!((found - expected).length() <= tolerance, "found {found}, expected {expected}");
}

/// Whether the same positions are in both lists, in any order.
#[track_caller]
pub fn assert_positions(points: &[ContactPoint], expected: &[DVec3], tolerance: f64) {
    let found: Vec<DVec3> = points.iter().map(|p| p.position).collect();
    assert_eq!(found.len(), expected.len(), "found {found:?}");
    for e in expected {
        assert!(found.iter().any(|f| (*f - *e).length() <= tolerance), "no point at {e}: {found:?}");
    }
}
