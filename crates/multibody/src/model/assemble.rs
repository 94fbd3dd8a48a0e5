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

impl Parts {
    /// The model of these parts, not yet checked.
    pub(super) fn assemble(self) -> Model {
        let mut bodies = self.bodies;
        let mut joints = Vec::new();
        let mut body_weld = vec![BodyId::WORLD; bodies.len()];
        let mut body_last_dof = vec![None; bodies.len()];
        let (mut dof_parent, mut dof_joint) = (Vec::new(), Vec::new());
        let (mut nq, mut nv) = (0, 0);
        let mut first = vec![0; bodies.len()];
        for (i, own) in self.joints.into_iter().enumerate() {
            let parent = bodies[i].parent.index();
            let mut last_dof: Option<usize> = if i == 0 { None } else { body_last_dof[parent] };
            body_weld[i] = if own.is_empty() && i > 0 { body_weld[parent] } else { BodyId(i as u32) };
            bodies[i].first_joint = joints.len();
            bodies[i].joint_count = own.len();
            first[i] = joints.len();
            for mut joint in own {
                (joint.q_index, joint.v_index) = (nq, nv);
                let id = JointId(joints.len() as u32);
                for _ in 0..joint.kind.nv() {
                    dof_parent.push(last_dof);
                    dof_joint.push(id);
                    last_dof = Some(nv);
                    nv += 1;
                }
                nq += joint.kind.nq();
                joints.push(joint);
            }
            body_last_dof[i] = last_dof;
        }
        // Parts that name joints by the order in which these were added name them by their order in the model.
        let renumber = |joint: &mut JointId| {
            if let Some(&(body, k)) = self.joint_ids.get(joint.index()) {
                *joint = JointId((first[body] + k) as u32);
            }
        };
        let mut equalities = self.equalities;
        equalities.iter_mut().flat_map(|e| e.kind.joints_mut()).for_each(renumber);
        let (mut tendons, mut actuators, mut sensors) = (self.tendons, self.actuators, self.sensors);
        tendons.iter_mut().flat_map(|t| &mut t.terms).for_each(|(joint, _)| renumber(joint));
        for actuator in &mut actuators {
            match &mut actuator.transmission {
                Transmission::Joint(joint) | Transmission::JointAxes { joint, .. } => renumber(joint),
                Transmission::Tendon(_) | Transmission::Site { .. } | Transmission::Body { .. } => {}
            }
        }
        let mut na = 0;
        for activation in actuators.iter_mut().filter_map(|actuator| actuator.activation.as_mut()) {
            activation.index = na;
            na += 1;
        }
        let mut sensor_size = 0;
        for sensor in &mut sensors {
            sensor.address = sensor_size;
            sensor_size += sensor.kind.size();
            match &mut sensor.kind {
                SensorKind::JointPosition(joint)
                | SensorKind::JointVelocity(joint)
                | SensorKind::JointActuatorForce(joint)
                | SensorKind::BallQuaternion(joint)
                | SensorKind::BallAngularVelocity(joint) => renumber(joint),
                _ => {}
            }
        }
        let weld_parent = body_weld.iter().map(|w| body_weld[bodies[w.index()].parent.index()]).collect();
        let contact_filter = ContactFilter::new(&self.pairs, &self.excluded, body_weld.clone(), weld_parent);
        let path = PathStep::all(&bodies, &joints);
        Model {
            name: self.name,
            gravity: self.gravity,
            magnetic: self.magnetic,
            timestep: self.timestep,
            bodies,
            joints,
            geoms: self.geoms,
            pairs: self.pairs,
            contact_filter,
            equalities,
            sites: self.sites,
            tendons,
            actuators,
            sensors,
            keyframes: self.keyframes,
            mocap_bodies: self.mocap_bodies,
            cameras: self.cameras,
            lights: self.lights,
            nq,
            nv,
            na,
            sensor_size,
            dof_parent,
            dof_joint,
            body_last_dof,
            body_weld,
            path,
        }
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
