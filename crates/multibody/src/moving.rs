//! The bodies that generalized forces and energy ask for: those that are welded together count as one.

use glamx::glam::DVec3;

use crate::kinematics::Kinematics;
use crate::math::Pose;
use crate::model::{Body, BodyId, Inertia, Model};

/// Bodies that can move, parents first: each that has joints, with the inertia of all that is welded to it, and those without inertia of their own
/// that others with joints hang on.
///
/// Two thirds of an arm's links may be flanges, tools, cameras and frames; none of them is visited for itself.
#[derive(Clone, Debug)]
pub struct MovingBodies(pub(crate) Vec<MovingBody>);

/// One of them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MovingBody {
    pub body: usize,
    /// What it hangs on; the world if that cannot move.
    pub carrier: usize,
    /// In the body's frame.
    pub inertia: Inertia,
}

impl MovingBodies {
    /// Those of a model, as it is now.
    ///
    /// # Cost
    /// O(bodies · depth).
    pub fn of(model: &Model) -> Self {
        let parts = parts_of(model);
        let carries = carries_joints(model);
        let moving = (1..model.bodies.len()).filter(|&i| model.body_weld[i] != BodyId::WORLD && carries[i]);
        let as_one = |i: usize| {
            let carrier = if model.path[i].above == 0 { 0 } else { model.path[i].parent };
            MovingBody { body: i, carrier, inertia: Inertia::sum(&parts[i]) }
        };
        Self(moving.map(as_one).collect())
    }

    /// All bodies by themselves.
    pub(crate) fn apart(model: &Model) -> impl DoubleEndedIterator<Item = MovingBody> + '_ {
        let alone =
            |(i, body): (usize, &Body)| MovingBody { body: i, carrier: body.parent.index(), inertia: body.inertia };
        model.bodies.iter().enumerate().skip(1).map(alone)
    }

    /// Kinetic energy `½ vᵀ M v`, armature included, J, as [`kinetic_energy`](crate::kinetic_energy) has it.
    ///
    /// - `velocities`: angular ones of all bodies and those of their origins, rad/s and m/s, world axes, from
    ///   [`body_velocities_into`](crate::body_velocities_into) at `v`
    ///
    /// # Panics
    /// If a length does not fit the model.
    pub fn kinetic_energy(
        &self,
        model: &Model,
        kinematics: &Kinematics,
        v: &[f64],
        velocities: (&[DVec3], &[DVec3]),
    ) -> f64 {
        let of_one = |one: &MovingBody| {
            kinetic_energy_of(&one.inertia, kinematics, one.body, (velocities.0[one.body], velocities.1[one.body]))
        };
        self.0.iter().map(of_one).sum::<f64>() + kinetic_energy_of_rotors(model, v)
    }
}

/// Kinetic energy of a body, J.
///
/// - `velocities`: its angular velocity and that of its origin, world axes
pub(crate) fn kinetic_energy_of(
    inertia: &Inertia,
    kinematics: &Kinematics,
    i: usize,
    (angular, linear): (DVec3, DVec3),
) -> f64 {
    let rotation = kinematics.rotation[i];
    let turning = rotation.mul_transpose_vec3(angular);
    let speed2 = (linear + angular.cross(rotation * inertia.center_of_mass)).length_squared();
    0.5 * (turning.dot(inertia.rotational * turning) + inertia.mass * speed2)
}

/// Kinetic energy of all rotors (armature), J.
pub(crate) fn kinetic_energy_of_rotors(model: &Model, v: &[f64]) -> f64 {
    let rotors = model.joints.iter().filter(|joint| joint.armature != 0.0).map(|joint| {
        let speeds = &v[joint.v_index..joint.v_index + joint.kind.nv()];
        0.5 * joint.armature * speeds.iter().map(|v| v * v).sum::<f64>()
    });
    rotors.sum()
}

/// The inertia of every body with joints and those of what is welded to it, in its frame; nothing of other bodies.
fn parts_of(model: &Model) -> Vec<Vec<Inertia>> {
    let mut parts = vec![Vec::new(); model.bodies.len()];
    let mut in_weld = vec![Pose::IDENTITY; model.bodies.len()];
    for (i, body) in model.bodies.iter().enumerate().skip(1) {
        let weld = model.body_weld[i].index();
        if weld == i {
            parts[i].push(body.inertia);
            continue;
        }
        in_weld[i] = in_weld[body.parent.index()] * body.placement;
        if body.inertia != Inertia::ZERO {
            parts[weld].push(body.inertia.placed(&in_weld[i]));
        }
    }
    parts
}

/// Whether a body has joints, or one that hangs on it.
fn carries_joints(model: &Model) -> Vec<bool> {
    let mut carries: Vec<bool> = model.bodies.iter().map(|body| body.joint_count > 0).collect();
    for (i, body) in model.bodies.iter().enumerate().skip(1).rev() {
        carries[body.parent.index()] |= carries[i];
    }
    carries
}
