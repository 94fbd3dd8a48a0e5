//! The parts of a model put together: joints in order, indices, lengths at the reference configuration.

use super::path::PathStep;
use super::{
    Actuator, Body, BodyId, Camera, CameraMode, ContactFilter, Equality, EqualityKind, Geom, GeomPair, Joint, JointId,
    JointKind, Keyframe, Light, Model, Sensor, SensorKind, Site, Tendon, Transmission, tendon_path::walk,
};
use crate::math::{Pose, unit_rotation, unit_vector};
use glamx::glam::DVec3;

/// What a builder has collected.
#[derive(Clone, Debug)]
pub(super) struct Parts {
    pub(super) name: String,
    pub(super) gravity: DVec3,
    pub(super) magnetic: DVec3,
    pub(super) timestep: f64,
    pub(super) sleeping: bool,
    pub(super) bodies: Vec<Body>,
    pub(super) joints: Vec<Vec<Joint>>,
    pub(super) joint_ids: Vec<(usize, usize)>,
    pub(super) geoms: Vec<Geom>,
    pub(super) pairs: Vec<GeomPair>,
    pub(super) excluded: Vec<(BodyId, BodyId)>,
    pub(super) equalities: Vec<Equality>,
    pub(super) sites: Vec<Site>,
    pub(super) tendons: Vec<Tendon>,
    pub(super) actuators: Vec<Actuator>,
    pub(super) sensors: Vec<Sensor>,
    pub(super) keyframes: Vec<Keyframe>,
    pub(super) mocap_bodies: Vec<BodyId>,
    pub(super) cameras: Vec<Camera>,
    pub(super) lights: Vec<Light>,
}

/// Joints in the model's order, and what this order decides.
struct Order {
    joints: Vec<Joint>,
    /// Per body, the index of its first joint.
    first: Vec<usize>,
    body_weld: Vec<BodyId>,
    body_last_dof: Vec<Option<usize>>,
    dof_parent: Vec<Option<usize>>,
    dof_joint: Vec<JointId>,
    nq: usize,
    nv: usize,
}

impl Order {
    /// Takes the joints of each body after those of its parent, and tells the bodies which are theirs.
    fn of(bodies: &mut [Body], joints: Vec<Vec<Joint>>) -> Self {
        let mut order = Self {
            joints: Vec::new(),
            first: vec![0; bodies.len()],
            body_weld: vec![BodyId::WORLD; bodies.len()],
            body_last_dof: vec![None; bodies.len()],
            dof_parent: Vec::new(),
            dof_joint: Vec::new(),
            nq: 0,
            nv: 0,
        };
        for (i, own) in joints.into_iter().enumerate() {
            let parent = bodies[i].parent.index();
            order.body_weld[i] = if own.is_empty() && i > 0 { order.body_weld[parent] } else { BodyId(i as u32) };
            bodies[i].first_joint = order.joints.len();
            bodies[i].joint_count = own.len();
            order.first[i] = order.joints.len();
            order.body_last_dof[i] = if i == 0 { None } else { order.body_last_dof[parent] };
            own.into_iter().for_each(|joint| order.push(i, joint));
        }
        order
    }

    /// Adds the next joint of a body.
    fn push(&mut self, body: usize, mut joint: Joint) {
        (joint.q_index, joint.v_index) = (self.nq, self.nv);
        let id = JointId(self.joints.len() as u32);
        for _ in 0..joint.kind.nv() {
            self.dof_parent.push(self.body_last_dof[body]);
            self.dof_joint.push(id);
            self.body_last_dof[body] = Some(self.nv);
            self.nv += 1;
        }
        self.nq += joint.kind.nq();
        self.joints.push(joint);
    }
}

impl Parts {
    /// The model of these parts, not yet checked.
    pub(super) fn assemble(mut self) -> Model {
        let order = Order::of(&mut self.bodies, std::mem::take(&mut self.joints));
        self.renumber_joints(&order.first);
        self.mark_angles(&order.joints);
        let na = self.place_activations();
        let sensor_size = self.place_sensors();
        let weld = &order.body_weld;
        let contact_filter = ContactFilter::new(&self.pairs, &self.excluded, &self.bodies, weld.clone());
        let path = PathStep::all(&self.bodies, &order.joints);
        Model {
            name: self.name,
            gravity: self.gravity,
            magnetic: self.magnetic,
            timestep: self.timestep,
            sleeping: self.sleeping,
            bodies: self.bodies,
            joints: order.joints,
            geoms: self.geoms,
            pairs: self.pairs,
            contact_filter,
            equalities: self.equalities,
            sites: self.sites,
            tendons: self.tendons,
            actuators: self.actuators,
            sensors: self.sensors,
            keyframes: self.keyframes,
            mocap_bodies: self.mocap_bodies,
            cameras: self.cameras,
            lights: self.lights,
            nq: order.nq,
            nv: order.nv,
            na,
            sensor_size,
            dof_parent: order.dof_parent,
            dof_joint: order.dof_joint,
            body_last_dof: order.body_last_dof,
            body_weld: order.body_weld,
            path,
        }
    }

    /// Parts that name joints by the order in which these were added name them by their order in the model, in which the joints of each body
    /// begin at `first`.
    fn renumber_joints(&mut self, first: &[usize]) {
        let ids = &self.joint_ids;
        let renumber = |joint: &mut JointId| {
            if let Some(&(body, k)) = ids.get(joint.index()) {
                *joint = JointId((first[body] + k) as u32);
            }
        };
        self.equalities.iter_mut().flat_map(|e| e.kind.joints_mut()).for_each(renumber);
        self.tendons.iter_mut().flat_map(|t| &mut t.terms).for_each(|(joint, _)| renumber(joint));
        for actuator in &mut self.actuators {
            match &mut actuator.transmission {
                Transmission::Joint(joint) | Transmission::JointAxes { joint, .. } => renumber(joint),
                Transmission::Tendon(_) | Transmission::Site { .. } | Transmission::Body { .. } => {}
            }
        }
        for sensor in &mut self.sensors {
            match &mut sensor.kind {
                SensorKind::JointPosition(joint)
                | SensorKind::JointVelocity(joint)
                | SensorKind::JointActuatorForce(joint)
                | SensorKind::JointLimitPosition(joint)
                | SensorKind::JointLimitVelocity(joint)
                | SensorKind::JointLimitForce(joint)
                | SensorKind::BallQuaternion(joint)
                | SensorKind::BallAngularVelocity(joint) => renumber(joint),
                _ => {}
            }
        }
    }

    /// Tells the actuators whose length is an angle without an end.
    fn mark_angles(&mut self, joints: &[Joint]) {
        for actuator in &mut self.actuators {
            actuator.turns = match &actuator.transmission {
                Transmission::JointAxes { joint, .. } => {
                    joints.get(joint.index()).is_some_and(|joint| joint.kind == JointKind::Ball)
                }
                Transmission::Site { reference, wrench, .. } => reference.is_some() && wrench[..3] == [0.0; 3],
                _ => false,
            };
        }
    }

    /// Gives the activations their places in the state; their number.
    fn place_activations(&mut self) -> usize {
        let mut na = 0;
        for activation in self.actuators.iter_mut().filter_map(|actuator| actuator.activation.as_mut()) {
            activation.index = na;
            na += 1;
        }
        na
    }

    /// Gives the sensors their places among the readings; the number of these.
    fn place_sensors(&mut self) -> usize {
        let mut size = 0;
        for sensor in &mut self.sensors {
            sensor.address = size;
            size += sensor.kind.size();
        }
        size
    }
}

/// Removes what the checks tolerate: norms of rotations and axes that are off 1.
pub(super) fn normalise(model: &mut Model) {
    for equality in &mut model.equalities {
        if let EqualityKind::Weld { frame_a, frame_b, .. } = &mut equality.kind {
            frame_a.rotation = unit_rotation(frame_a.rotation);
            frame_b.rotation = unit_rotation(frame_b.rotation);
        }
    }
    let bodies = model.bodies.iter_mut().map(|body| &mut body.placement);
    let geoms = model.geoms.iter_mut().map(|geom| &mut geom.placement);
    let sites = model.sites.iter_mut().map(|site| &mut site.placement);
    for placement in bodies.chain(geoms).chain(sites) {
        placement.rotation = unit_rotation(placement.rotation);
    }
    for joint in &mut model.joints {
        if let JointKind::Hinge { axis } | JointKind::Slide { axis } = &mut joint.kind {
            *axis = unit_vector(*axis);
        }
    }
}

/// Notes how long the tendons are at the reference configuration.
pub(super) fn measure_tendons(model: &mut Model) {
    let q = model.reference_configuration();
    let length = |tendon: &Tendon| {
        let joints = tendon.terms.iter().map(|&(joint, c)| c * q[model.joints[joint.index()].q_index]).sum::<f64>();
        joints + walk(model, |body| model.reference_pose(body), &tendon.path, |_| {})
    };
    let lengths: Vec<f64> = model.tendons.iter().map(length).collect();
    model.tendons.iter_mut().zip(lengths).for_each(|(tendon, length)| tendon.reference_length = length);
}

/// Notes where cameras that follow something are from it at the reference configuration.
pub(super) fn place_cameras(model: &mut Model) {
    let start = |camera: &Camera| {
        let carried = model.reference_pose(camera.body) * camera.placement;
        let origin = match camera.mode {
            CameraMode::TrackCenterOfMass => reference_center(model, camera.body),
            _ => model.reference_pose(camera.body).position,
        };
        Pose::new(carried.position - origin, carried.rotation)
    };
    let starts: Vec<Pose> = model.cameras.iter().map(start).collect();
    model.cameras.iter_mut().zip(starts).for_each(|(camera, start)| camera.start = start);
}

/// Centre of mass of a body's subtree at the reference configuration, as `subtree_center_of_mass` has it.
fn reference_center(model: &Model, body: BodyId) -> DVec3 {
    let (mut mass, mut moment) = (0.0, DVec3::ZERO);
    for id in model.subtree(body).filter(|id| *id != BodyId::WORLD) {
        let inertia = &model.bodies[id.index()].inertia;
        mass += inertia.mass;
        moment += model.reference_pose(id).transform_point(inertia.center_of_mass) * inertia.mass;
    }
    if mass > 0.0 { moment / mass } else { model.reference_pose(body).position }
}
