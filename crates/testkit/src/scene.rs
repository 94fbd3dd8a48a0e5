//! Free rigid bodies with point contacts.

use signorini_contact::{ContactProblem, FrictionPolygon};
use signorini_multibody::BlockDiagonal;
use signorini_multibody::glam::{DMat3, DVec3};

/// Gravity, m/s², along −z.
pub const GRAVITY: f64 = 9.81;

/// A free rigid body; everything in world axes.
#[derive(Clone, Copy, Debug)]
pub struct RigidBody {
    /// Mass, kg.
    pub mass: f64,
    /// Inertia about the centre of mass, kg·m².
    pub inertia: DMat3,
    /// Centre of mass, m.
    pub center: DVec3,
    /// Velocity of the centre of mass, m/s.
    pub velocity: DVec3,
    /// Angular velocity, rad/s.
    pub angular_velocity: DVec3,
}

impl RigidBody {
    /// A homogeneous box at rest with its axes turned by `rotation`. `size`: full edge lengths, m.
    pub fn cuboid(size: DVec3, mass: f64, center: DVec3, rotation: DMat3) -> Self {
        let s = size * size;
        let principal = DVec3::new(s.y + s.z, s.x + s.z, s.x + s.y) * (mass / 12.0);
        let inertia = rotation * DMat3::from_diagonal(principal) * rotation.transpose();
        Self { mass, inertia, center, velocity: DVec3::ZERO, angular_velocity: DVec3::ZERO }
    }

    /// The same body with these velocities.
    pub fn moving(self, (velocity, angular_velocity): (DVec3, DVec3)) -> Self {
        Self { velocity, angular_velocity, ..self }
    }

    /// The acceleration of free motion under gravity: linear, angular.
    fn acceleration(&self) -> (DVec3, DVec3) {
        let momentum = self.inertia * self.angular_velocity;
        (DVec3::NEG_Z * GRAVITY, -(self.inertia.inverse() * self.angular_velocity.cross(momentum)))
    }
}

/// A contact at a point between two bodies of a scene, or a body and the fixed world (`None`).
#[derive(Clone, Copy, Debug)]
pub struct PointContact {
    /// The body that the normal points away from.
    pub a: Option<usize>,
    /// The body that the normal points to.
    pub b: Option<usize>,
    /// Point, m, in world.
    pub point: DVec3,
    /// Unit normal from `a` to `b`, in world.
    pub normal: DVec3,
    /// Signed distance φ, m.
    pub gap: f64,
}

/// Bodies and contacts. The velocities of body `k` are degrees of freedom `6k..6k+6`: linear at the centre of mass, then
/// angular, both in world axes.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Time step, s.
    pub timestep: f64,
    /// The bodies.
    pub bodies: Vec<RigidBody>,
    /// The contacts.
    pub contacts: Vec<PointContact>,
}

impl Default for Scene {
    fn default() -> Self {
        Self { timestep: 0.01, bodies: Vec::new(), contacts: Vec::new() }
    }
}

impl Scene {
    /// Adds a body and returns its index.
    pub fn body(&mut self, body: RigidBody) -> usize {
        self.bodies.push(body);
        self.bodies.len() - 1
    }

    /// Adds a contact.
    pub fn contact(&mut self, a: Option<usize>, b: Option<usize>, point: DVec3, normal: DVec3, gap: f64) {
        self.contacts.push(PointContact { a, b, point, normal: normal.normalize(), gap });
    }

    /// The contact problem of one step. `friction_of`: μ and directions of each contact.
    pub fn problem(&self, mut friction_of: impl FnMut(usize) -> (f64, FrictionPolygon)) -> ContactProblem {
        let nv = 6 * self.bodies.len();
        let mut mass = vec![0.0; nv * nv];
        let mut free_velocity = Vec::with_capacity(nv);
        for (k, body) in self.bodies.iter().enumerate() {
            for i in 0..3 {
                mass[(6 * k + i) * (nv + 1)] = body.mass;
                for j in 0..3 {
                    mass[(6 * k + 3 + i) * nv + 6 * k + 3 + j] = body.inertia.row(i.min(j))[i.max(j)];
                }
            }
            let (linear, angular) = body.acceleration();
            free_velocity.extend((body.velocity + self.timestep * linear).to_array());
            free_velocity.extend((body.angular_velocity + self.timestep * angular).to_array());
        }
        let mass = BlockDiagonal::from_dense(nv, &mass).expect("a symmetric mass matrix");
        let mut problem = ContactProblem::new(mass, free_velocity, self.timestep).expect("a valid scene");
        for (i, contact) in self.contacts.iter().enumerate() {
            let (friction, polygon) = friction_of(i);
            problem.push_contact(self.columns(contact), contact.gap, friction, &polygon);
        }
        problem.check().expect("a valid scene");
        problem
    }

    /// Jacobian of a contact: for each degree of freedom (normal, tangent 1, tangent 2).
    pub fn columns(&self, contact: &PointContact) -> Vec<(u32, [f64; 3])> {
        let [t_1, t_2] = tangents(contact.normal);
        let axes = [contact.normal, t_1, t_2];
        let mut sides: Vec<(usize, f64)> = contact.a.map(|a| (a, -1.0)).into_iter().collect();
        sides.extend(contact.b.map(|b| (b, 1.0)));
        sides.sort_by_key(|side| side.0);
        let mut columns = Vec::new();
        for (body, sign) in sides {
            let arm = contact.point - self.bodies[body].center;
            let moments = axes.map(|d| arm.cross(d));
            for i in 0..3 {
                columns.push(((6 * body + i) as u32, axes.map(|d| sign * d[i])));
            }
            for i in 0..3 {
                columns.push(((6 * body + 3 + i) as u32, moments.map(|d| sign * d[i])));
            }
        }
        columns
    }
}

/// Two tangents that make a right-handed orthonormal frame with a unit normal, `t1 × t2 = n`.
pub fn tangents(normal: DVec3) -> [DVec3; 2] {
    let size = normal.abs();
    let axis = if size.x <= size.y && size.x <= size.z {
        DVec3::X
    } else if size.y <= size.z {
        DVec3::Y
    } else {
        DVec3::Z
    };
    let t_1 = normal.cross(axis).normalize();
    [t_1, normal.cross(t_1)]
}
