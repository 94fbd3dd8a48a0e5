//! Sensors that need nothing but the state: positions and velocities.

use glamx::glam::{DQuat, DVec3};

use crate::actuator_length::actuator_length_into;
use crate::camera::project;
use crate::energy::{kinetic_energy, potential_energy};
use crate::frame::Frame;
use crate::kinematics::Kinematics;
use crate::length::LengthRow;
use crate::math::{Pose, read_quaternion, rotation_log};
use crate::model::{BodyId, FrameId, JointId, JointKind, Model, Sensor, SensorKind};
use crate::state::State;
use crate::tendon::tendon_length_into;

/// A frame in world and how it moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MovingFrame {
    /// The body it is fixed to.
    pub body: BodyId,
    /// Its pose in world, m.
    pub pose: Pose,
    /// Velocity of its origin, world axes, m/s.
    pub linear_velocity: DVec3,
    /// Angular velocity, world axes, rad/s.
    pub angular_velocity: DVec3,
}

/// A frame of a model at a state.
///
/// - `kinematics`: from [`forward_kinematics_into`](crate::forward_kinematics_into) at the state
pub fn moving_frame(model: &Model, kinematics: &Kinematics, frame: FrameId) -> MovingFrame {
    let Frame { body, placement } = Frame::of(model, frame);
    let pose = kinematics.pose[body.index()] * placement;
    MovingFrame {
        body,
        pose,
        linear_velocity: kinematics.point_velocity(body, pose.position),
        angular_velocity: kinematics.angular_velocity[body.index()],
    }
}

/// Numbers of all sensors that depend on the state alone, at their places in `out`; the places of the others
/// ([`SensorKind::needs_step`], [`SensorKind::needs_shapes`]) are left as they are.
///
/// - `kinematics`: from [`forward_kinematics_into`](crate::forward_kinematics_into) at the state
/// - `row`: storage
/// - `out`: `[sensor_size]`, units as [`SensorKind`] says
///
/// # Panics
/// If `out` has another length than the model's `sensor_size`.
///
/// # Source
/// MuJoCo's definitions of the sensors of the same names.
pub fn state_sensors_into(model: &Model, state: &State, kinematics: &Kinematics, row: &mut LengthRow, out: &mut [f64]) {
    assert_eq!(out.len(), model.sensor_size, "the array of all sensors has another length");
    for sensor in model.sensors.iter().filter(|sensor| !sensor.kind.needs_step() && !sensor.kind.needs_shapes()) {
        let values = &mut out[sensor.address..sensor.address + sensor.kind.size()];
        measure(model, state, kinematics, row, sensor.kind, values);
        sensor.cut_off(values);
    }
}

impl Sensor {
    /// Bounds the sensor's numbers by its cutoff.
    pub fn cut_off(&self, values: &mut [f64]) {
        if let Some(bound) = self.cutoff.filter(|_| !self.kind.is_direction()) {
            values.iter_mut().for_each(|x| *x = x.clamp(-bound, bound));
        }
    }
}

fn measure(
    model: &Model,
    state: &State,
    kinematics: &Kinematics,
    row: &mut LengthRow,
    kind: SensorKind,
    out: &mut [f64],
) {
    let vector = |x: DVec3, out: &mut [f64]| out.copy_from_slice(&x.to_array());
    let frame = |id: FrameId| moving_frame(model, kinematics, id);
    let site = |id| frame(FrameId::Site(id));
    match kind {
        SensorKind::JointPosition(joint) => out[0] = state.q[model.joints[joint.index()].q_index],
        SensorKind::JointVelocity(joint) => out[0] = state.v[model.joints[joint.index()].v_index],
        SensorKind::BallQuaternion(joint) => {
            quaternion(read_quaternion(&state.q[model.joints[joint.index()].q_index..]), out);
        }
        SensorKind::BallAngularVelocity(joint) => {
            let k = model.joints[joint.index()].v_index;
            out.copy_from_slice(&state.v[k..k + 3]);
        }
        SensorKind::TendonPosition(tendon) | SensorKind::TendonVelocity(tendon) => {
            tendon_length_into(model, kinematics, &state.q, &model.tendons[tendon.index()], row);
            let rate = matches!(kind, SensorKind::TendonVelocity(_));
            out[0] = if rate { row.rate(&state.v) } else { row.length };
        }
        SensorKind::ActuatorPosition(actuator) | SensorKind::ActuatorVelocity(actuator) => {
            actuator_length_into(model, kinematics, &state.q, &model.actuators[actuator.index()], row);
            let rate = matches!(kind, SensorKind::ActuatorVelocity(_));
            out[0] = if rate { row.rate(&state.v) } else { row.length };
        }
        SensorKind::Velocimeter(id) => {
            let frame = site(id);
            vector(frame.pose.rotation.conjugate() * frame.linear_velocity, out);
        }
        SensorKind::Gyro(id) => {
            let frame = site(id);
            vector(frame.pose.rotation.conjugate() * frame.angular_velocity, out);
        }
        SensorKind::FramePosition(id, reference) => {
            let (x, reference) = (frame(id).pose.position, reference.map(frame));
            vector(reference.map_or(x, |r| r.pose.inverse().transform_point(x)), out);
        }
        SensorKind::FrameQuaternion(id, reference) => {
            let (r, reference) = (frame(id).pose.rotation, reference.map(frame));
            quaternion(reference.map_or(r, |other| other.pose.rotation.conjugate() * r), out);
        }
        SensorKind::FrameAxis(id, reference, axis) => {
            let direction = frame(id).pose.rotation * DVec3::AXES[usize::from(axis).min(2)];
            vector(in_axes_of(reference.map(frame), direction), out);
        }
        SensorKind::FrameLinearVelocity(id, reference) => {
            let (frame, reference) = (frame(id), reference.map(frame));
            let carried = reference.map_or(DVec3::ZERO, |r| {
                r.linear_velocity + r.angular_velocity.cross(frame.pose.position - r.pose.position)
            });
            vector(in_axes_of(reference, frame.linear_velocity - carried), out);
        }
        SensorKind::FrameAngularVelocity(id, reference) => {
            let (own, reference) = (frame(id).angular_velocity, reference.map(frame));
            let carried = reference.map_or(DVec3::ZERO, |r| r.angular_velocity);
            vector(in_axes_of(reference, own - carried), out);
        }
        SensorKind::SubtreeCenterOfMass(body) => vector(Subtree::of(model, kinematics, body).center, out),
        SensorKind::SubtreeLinearVelocity(body) => vector(Subtree::of(model, kinematics, body).velocity, out),
        SensorKind::SubtreeAngularMomentum(body) => vector(angular_momentum(model, kinematics, body), out),
        SensorKind::Magnetometer(id) => vector(site(id).pose.rotation.conjugate() * model.magnetic, out),
        SensorKind::CameraProjection(id, camera) => {
            let camera = &model.cameras[camera.index()];
            out.copy_from_slice(&project(model, kinematics, camera, site(id).pose.position));
        }
        SensorKind::JointLimitPosition(joint) => out[0] = passed(joint_limit(model, state, joint))[0],
        SensorKind::JointLimitVelocity(joint) => out[0] = passed(joint_limit(model, state, joint))[1],
        SensorKind::TendonLimitPosition(tendon) | SensorKind::TendonLimitVelocity(tendon) => {
            let tendon = &model.tendons[tendon.index()];
            tendon_length_into(model, kinematics, &state.q, tendon, row);
            let limit = tendon.limits.map(|limits| between(limits, row.length, row.rate(&state.v)));
            out[0] = passed(limit)[usize::from(matches!(kind, SensorKind::TendonLimitVelocity(_)))];
        }
        SensorKind::InsideSite(own, id) => {
            let place = site(id).pose.inverse().transform_point(frame(own).pose.position);
            out[0] = f64::from(u8::from(model.sites[id.index()].holds(place)));
        }
        SensorKind::PotentialEnergy => out[0] = potential_energy(model, kinematics, &state.q),
        SensorKind::KineticEnergy => out[0] = kinetic_energy(model, kinematics, &state.v),
        SensorKind::Clock => out[0] = state.time,
        SensorKind::JointActuatorForce(_)
        | SensorKind::TendonActuatorForce(_)
        | SensorKind::JointLimitForce(_)
        | SensorKind::TendonLimitForce(_)
        | SensorKind::ActuatorForce(_)
        | SensorKind::Accelerometer(_)
        | SensorKind::Force(_)
        | SensorKind::Torque(_)
        | SensorKind::Touch(_)
        | SensorKind::Rangefinder(_)
        | SensorKind::ShapeDistance(..)
        | SensorKind::ShapeNormal(..)
        | SensorKind::ShapePoints(..)
        | SensorKind::Contacts(_)
        | SensorKind::FrameLinearAcceleration(_)
        | SensorKind::FrameAngularAcceleration(_) => {}
    }
}

/// Distance to a limit and its rate, of a limit that is passed; else zeros.
fn passed(limit: Option<[f64; 2]>) -> [f64; 2] {
    limit.filter(|[distance, _]| *distance < 0.0).unwrap_or_default()
}

/// Distance to the nearest limit of a joint and its rate: of a ball joint to the cone that its rotation may not leave.
fn joint_limit(model: &Model, state: &State, joint: JointId) -> Option<[f64; 2]> {
    let joint = &model.joints[joint.index()];
    let limits = joint.limits?;
    let (q, v) = (&state.q[joint.q_index..], &state.v[joint.v_index..]);
    if joint.kind != JointKind::Ball {
        return Some(between(limits, q[0], v[0]));
    }
    let turn = rotation_log(read_quaternion(q));
    let outward = turn.normalize_or_zero().dot(DVec3::from_slice(v));
    Some([limits[1] - turn.length(), -outward])
}

/// Distance of a number to the nearer end of its range, and its rate.
fn between([lower, upper]: [f64; 2], x: f64, rate: f64) -> [f64; 2] {
    if x - lower <= upper - x { [x - lower, rate] } else { [upper - x, -rate] }
}

fn in_axes_of(reference: Option<MovingFrame>, x: DVec3) -> DVec3 {
    reference.map_or(x, |r| r.pose.rotation.conjugate() * x)
}

fn quaternion(r: DQuat, out: &mut [f64]) {
    out.copy_from_slice(&[r.w, r.x, r.y, r.z]);
}

/// Centre of mass of a body with all that hangs on it, and its velocity; of the body's origin if there is no mass.
struct Subtree {
    center: DVec3,
    velocity: DVec3,
}

impl Subtree {
    fn of(model: &Model, kinematics: &Kinematics, root: BodyId) -> Self {
        let (mut mass, mut center, mut velocity) = (0.0, DVec3::ZERO, DVec3::ZERO);
        for body in model.subtree(root) {
            let (m, c) = (model.bodies[body.index()].inertia.mass, kinematics.center_of_mass[body.index()]);
            mass += m;
            center += c * m;
            velocity += kinematics.point_velocity(body, c) * m;
        }
        if mass > 0.0 {
            return Self { center: center / mass, velocity: velocity / mass };
        }
        Self { center: kinematics.pose[root.index()].position, velocity: kinematics.linear_velocity[root.index()] }
    }
}

/// Angular momentum of a body with all that hangs on it about their centre of mass, world axes.
fn angular_momentum(model: &Model, kinematics: &Kinematics, root: BodyId) -> DVec3 {
    let whole = Subtree::of(model, kinematics, root);
    let of = |body: BodyId| {
        let (i, inertia) = (body.index(), &model.bodies[body.index()].inertia);
        let (rotation, c) = (kinematics.rotation[i], kinematics.center_of_mass[i]);
        let spin = rotation * (inertia.rotational * rotation.mul_transpose_vec3(kinematics.angular_velocity[i]));
        let velocity = kinematics.point_velocity(body, c) - whole.velocity;
        spin + (c - whole.center).cross(velocity * inertia.mass)
    };
    model.subtree(root).map(of).sum()
}
