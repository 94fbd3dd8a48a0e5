//! From a spec to a model.

use signorini_multibody::{
    ActuatorId, BodyId, CameraId, GeomId, JointId, Keyframe, Model, ModelBuilder, SiteId, TendonId,
};

use crate::SpecError;
use crate::keyframe::KeyframeSpec;
use crate::references::{Places, Refers};
use crate::spec::Spec;

/// A model, and where the parts of its spec are in it, by their identifiers there.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Compiled {
    /// The model.
    pub model: Model,
    /// Body of the model for every body of the spec; nothing for one that was removed.
    pub bodies: Vec<Option<BodyId>>,
    /// The same for joints.
    pub joints: Vec<Option<JointId>>,
    /// The same for geoms.
    pub geoms: Vec<Option<GeomId>>,
    /// The same for sites.
    pub sites: Vec<Option<SiteId>>,
    /// The same for tendons.
    pub tendons: Vec<Option<TendonId>>,
    /// The same for actuators.
    pub actuators: Vec<Option<ActuatorId>>,
}

impl Spec {
    /// The model. Bodies stand depth first, children in the order in which they were added; joints, geoms and sites by their bodies; the
    /// rest in the order of the spec, which stays what it was.
    ///
    /// # Errors
    /// [`SpecError::Circle`], [`SpecError::DanglingReference`], and [`SpecError::Model`] with whatever is wrong with the mechanism, naming
    /// the part.
    pub fn compile(&self) -> Result<Compiled, SpecError> {
        let mut builder = ModelBuilder::new(self.name.clone());
        builder.gravity(self.gravity).magnetic(self.magnetic).timestep(self.timestep).sleeping(self.sleeping);
        let cameras = (0..self.cameras.len()).map(|i| Some(CameraId(i as u32))).collect();
        let mut places = Places { cameras, ..Places::default() };
        self.build_bodies(&mut builder, &mut places)?;
        self.build_relations(&mut builder, &mut places)?;
        self.build_looks(&mut builder, &places)?;
        if self.keyframes.places() > 0 {
            // Where the numbers of joints stand is known once the rest is a model.
            let model = builder.clone().build()?;
            for (_, keyframe) in self.keyframes.iter() {
                builder.add_keyframe(keyframe.moved(&places)?.of_model(&model)?);
            }
        }
        let model = builder.build()?;
        let Places { bodies, joints, geoms, sites, tendons, actuators, .. } = places;
        Ok(Compiled { model, bodies, joints, geoms, sites, tendons, actuators })
    }

    /// Bodies that can be reached from the world, depth first.
    pub(crate) fn depth_first(&self) -> Vec<usize> {
        let mut children: Vec<Vec<usize>> = vec![Vec::new(); self.bodies.places()];
        for (i, body) in self.bodies.iter().skip(1) {
            if let Some(list) = children.get_mut(body.parent.index()) {
                list.push(i);
            }
        }
        let (mut order, mut open) = (Vec::new(), vec![0]);
        while let Some(i) = open.pop() {
            order.push(i);
            open.extend(children[i].iter().rev());
        }
        order
    }

    fn build_bodies(&self, builder: &mut ModelBuilder, places: &mut Places) -> Result<(), SpecError> {
        let order = self.depth_first();
        places.bodies = vec![None; self.bodies.places()];
        places.joints = vec![None; self.joints.places()];
        places.geoms = vec![None; self.geoms.places()];
        places.sites = vec![None; self.sites.places()];
        for &i in &order {
            let Some(body) = self.bodies.get(i) else { continue };
            let id = match i {
                0 => BodyId::WORLD,
                _ => {
                    let parent = places.bodies[body.parent.index()].unwrap_or(BodyId::WORLD);
                    let id = builder.add_body(body.name.clone(), parent, body.placement, body.inertia)?;
                    builder.set_gravity_compensation(id, body.gravity_compensation)?;
                    if body.mocap.is_some() {
                        builder.set_mocap(id)?;
                    }
                    builder.set_begins_asleep(id, body.begins_asleep)?;
                    id
                }
            };
            places.bodies[i] = Some(id);
            for (k, joint) in self.joints.iter().filter(|(_, joint)| joint.body.index() == i) {
                places.joints[k] = Some(builder.add_joint(id, joint.clone())?);
            }
            for (k, geom) in self.geoms.iter().filter(|(_, geom)| geom.body.index() == i) {
                places.geoms[k] = Some(builder.add_geom(id, geom.clone())?);
            }
            for (k, site) in self.sites.iter().filter(|(_, site)| site.body.index() == i) {
                places.sites[k] = Some(builder.add_site(id, site.clone())?);
            }
        }
        match self.bodies.iter().find(|(i, _)| places.bodies[*i].is_none()) {
            None => Ok(()),
            Some((_, body)) if self.bodies.get(body.parent.index()).is_none() => {
                Err(SpecError::DanglingReference { part: format!("body '{}'", body.name), sort: "body" })
            }
            Some((_, body)) => Err(SpecError::Circle { body: body.name.clone() }),
        }
    }

    /// Cameras and lights.
    fn build_looks(&self, builder: &mut ModelBuilder, places: &Places) -> Result<(), SpecError> {
        for camera in &self.cameras {
            let camera = camera.moved(places)?;
            builder.add_camera(camera.body, camera)?;
        }
        for light in &self.lights {
            let light = light.moved(places)?;
            builder.add_light(light.body, light)?;
        }
        Ok(())
    }

    fn build_relations(&self, builder: &mut ModelBuilder, places: &mut Places) -> Result<(), SpecError> {
        let dangling = |part: &str| {
            let part = part.to_owned();
            move |sort| SpecError::DanglingReference { part, sort }
        };
        for pair in &self.pairs {
            let mut pair = *pair;
            places.geom(&mut pair.geom_a).map_err(dangling("a contact pair"))?;
            places.geom(&mut pair.geom_b).map_err(dangling("a contact pair"))?;
            builder.add_pair(pair);
        }
        for &(mut a, mut b) in &self.excluded {
            places.body(&mut a).map_err(dangling("an exclusion"))?;
            places.body(&mut b).map_err(dangling("an exclusion"))?;
            builder.exclude(a, b);
        }
        places.tendons = vec![None; self.tendons.places()];
        for (k, tendon) in self.tendons.iter() {
            places.tendons[k] = Some(builder.add_tendon(tendon.moved(places)?));
        }
        for (_, equality) in self.equalities.iter() {
            let equality = equality.moved(places)?;
            builder.add_equality(equality.name, equality.kind);
        }
        places.actuators = vec![None; self.actuators.places()];
        for (k, actuator) in self.actuators.iter() {
            places.actuators[k] = Some(builder.add_actuator(actuator.moved(places)?));
        }
        self.sensors.iter().try_for_each(|(_, sensor)| {
            builder.add_sensor(sensor.moved(places)?);
            Ok(())
        })
    }
}

impl KeyframeSpec {
    /// The state of a model whose identifiers this one has.
    fn of_model(&self, model: &Model) -> Result<Keyframe, SpecError> {
        let wrong = |list, expected, found| {
            let part = format!("keyframe '{}'", self.name);
            SpecError::Model(signorini_multibody::ModelError::WrongLength { part, list, expected, found })
        };
        let mut keyframe = Keyframe::new(self.name.clone(), model.reference_configuration())
            .with_time(self.time)
            .with_v(vec![0.0; model.nv])
            .with_activation(vec![0.0; model.na])
            .with_control(vec![0.0; model.actuators.len()]);
        for (id, values) in &self.q {
            let joint = &model.joints[id.index()];
            let (at, count) = (joint.q_index, joint.kind.nq());
            if values.len() != count {
                return Err(wrong("q of a joint", count, values.len()));
            }
            keyframe.q[at..at + count].copy_from_slice(values);
        }
        for (id, values) in &self.v {
            let joint = &model.joints[id.index()];
            let (at, count) = (joint.v_index, joint.kind.nv());
            if values.len() != count {
                return Err(wrong("v of a joint", count, values.len()));
            }
            keyframe.v[at..at + count].copy_from_slice(values);
        }
        for (id, value) in &self.activation {
            if let Some(activation) = model.actuators[id.index()].activation {
                keyframe.activation[activation.index] = *value;
            }
        }
        self.control.iter().for_each(|(id, value)| keyframe.control[id.index()] = *value);
        if !self.mocap.is_empty() {
            let placed = model.mocap_bodies.iter().map(|body| {
                let own = self.mocap.iter().find(|(id, _)| id == body);
                own.map_or(model.bodies[body.index()].placement, |(_, pose)| *pose)
            });
            keyframe.mocap = placed.collect();
        }
        Ok(keyframe)
    }
}
