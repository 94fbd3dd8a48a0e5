//! Building a model part by part, with every check in one place.

use glamx::glam::DVec3;

use super::assemble::{Parts, measure_tendons, normalise, place_cameras};
use super::check::{check_inertia, moving_no_mass, number, unique};
use super::check_sensing::{check_cameras, check_keyframes, check_relations, check_sensors};
use super::path::reference_pose;
use super::{
    Actuator, ActuatorId, Body, BodyId, Camera, Equality, EqualityKind, Geom, GeomId, GeomPair, Geometry, Inertia,
    Joint, JointId, JointKind, Keyframe, Light, Model, ModelError, Sensor, Site, SiteId, Tendon, TendonId,
};
use crate::math::Pose;

/// MuJoCo's default magnetic field.
pub(super) const MAGNETIC: DVec3 = DVec3::new(0.0, -0.5, 0.0);

/// Collects parts and checks them; [`build`](Self::build) gives the immutable [`Model`].
#[derive(Clone, Debug)]
pub struct ModelBuilder {
    parts: Parts,
}

impl ModelBuilder {
    /// An empty world with gravity (0, 0, −9.81) m/s² and a time step of 2 ms.
    pub fn new(name: impl Into<String>) -> Self {
        let world = Body {
            name: "world".into(),
            parent: BodyId::WORLD,
            placement: Pose::IDENTITY,
            inertia: Inertia::ZERO,
            gravity_compensation: 0.0,
            first_joint: 0,
            joint_count: 0,
            mocap: None,
            begins_asleep: false,
        };
        let parts = Parts {
            name: name.into(),
            gravity: DVec3::new(0.0, 0.0, -9.81),
            magnetic: MAGNETIC,
            timestep: 0.002,
            sleeping: false,
            bodies: vec![world],
            joints: vec![Vec::new()],
            joint_ids: Vec::new(),
            geoms: Vec::new(),
            pairs: Vec::new(),
            excluded: Vec::new(),
            equalities: Vec::new(),
            sites: Vec::new(),
            tendons: Vec::new(),
            actuators: Vec::new(),
            sensors: Vec::new(),
            keyframes: Vec::new(),
            mocap_bodies: Vec::new(),
            cameras: Vec::new(),
            lights: Vec::new(),
        };
        Self { parts }
    }

    /// Sets gravity, m/s².
    pub fn gravity(&mut self, gravity: DVec3) -> &mut Self {
        self.parts.gravity = gravity;
        self
    }

    /// Sets the magnetic field; without it, that of MuJoCo's default, (0, −0.5, 0).
    pub fn magnetic(&mut self, field: DVec3) -> &mut Self {
        self.parts.magnetic = field;
        self
    }

    /// Sets the suggested time step, s.
    pub fn timestep(&mut self, timestep: f64) -> &mut Self {
        self.parts.timestep = timestep;
        self
    }

    /// Sets whether simulations leave alone what rests; without it, they do not.
    pub fn sleeping(&mut self, sleeping: bool) -> &mut Self {
        self.parts.sleeping = sleeping;
        self
    }

    /// Adds a body at `placement` (`X_PB`) in its parent, welded to it until a joint is added.
    ///
    /// # Errors
    /// [`ModelError::UnknownPart`] if the parent is not there yet.
    pub fn add_body(
        &mut self,
        name: impl Into<String>,
        parent: BodyId,
        placement: Pose,
        inertia: Inertia,
    ) -> Result<BodyId, ModelError> {
        let name = name.into();
        self.known_body(parent, || format!("body '{name}'"))?;
        let id = BodyId(self.parts.bodies.len() as u32);
        let gravity_compensation = 0.0;
        self.parts.bodies.push(Body {
            name,
            parent,
            placement,
            inertia,
            gravity_compensation,
            first_joint: 0,
            joint_count: 0,
            mocap: None,
            begins_asleep: false,
        });
        self.parts.joints.push(Vec::new());
        Ok(id)
    }

    /// Replaces a body's inertia.
    ///
    /// # Errors
    /// [`ModelError::UnknownPart`] if the body is not there.
    pub fn set_inertia(&mut self, body: BodyId, inertia: Inertia) -> Result<(), ModelError> {
        self.known_body(body, || "an inertia".into())?;
        self.parts.bodies[body.index()].inertia = inertia;
        Ok(())
    }

    /// Sets the share of a body's weight that is taken away.
    ///
    /// # Errors
    /// [`ModelError::UnknownPart`] if the body is not there.
    pub fn set_gravity_compensation(&mut self, body: BodyId, share: f64) -> Result<(), ModelError> {
        self.known_body(body, || "a gravity compensation".into())?;
        self.parts.bodies[body.index()].gravity_compensation = share;
        Ok(())
    }

    /// Makes a body one whose pose is given from outside, behind those there are; it must be a child of the world without joints.
    ///
    /// # Errors
    /// [`ModelError::UnknownPart`] if the body is not there.
    pub fn set_mocap(&mut self, body: BodyId) -> Result<(), ModelError> {
        self.known_body(body, || "a mocap body".into())?;
        let own = &mut self.parts.bodies[body.index()].mocap;
        if own.is_none() {
            *own = Some(self.parts.mocap_bodies.len());
            self.parts.mocap_bodies.push(body);
        }
        Ok(())
    }

    /// Whether a body that is there has joints, and none that it hangs on has any.
    pub fn begins_tree(&self, body: BodyId) -> bool {
        let moves = |body: BodyId| self.parts.joints.get(body.index()).is_some_and(|joints| !joints.is_empty());
        let parent = |body: BodyId| self.parts.bodies.get(body.index()).map(|own| own.parent);
        let above = |body: BodyId| (body != BodyId::WORLD).then(|| parent(body)).flatten();
        moves(body) && !std::iter::successors(above(body), |&body| above(body)).any(moves)
    }

    /// Lets the tree that begins with a body begin asleep, or awake as without it ([`Body::begins_asleep`]).
    ///
    /// # Errors
    /// [`ModelError::UnknownPart`] if the body is not there.
    pub fn set_begins_asleep(&mut self, body: BodyId, begins_asleep: bool) -> Result<(), ModelError> {
        self.known_body(body, || "sleep".into())?;
        self.parts.bodies[body.index()].begins_asleep = begins_asleep;
        Ok(())
    }

    /// Adds a joint to a body, after the joints it already has. The identifier counts joints in the order they are
    /// added; [`Model::joints`] orders them by body, which is the same order when bodies are finished one by one.
    ///
    /// # Errors
    /// [`ModelError::UnknownPart`] if the body is not there.
    pub fn add_joint(&mut self, body: BodyId, mut joint: Joint) -> Result<JointId, ModelError> {
        self.known_body(body, || format!("joint '{}'", joint.name))?;
        joint.body = body;
        let id = JointId(self.parts.joint_ids.len() as u32);
        self.parts.joint_ids.push((body.index(), self.parts.joints[body.index()].len()));
        self.parts.joints[body.index()].push(joint);
        Ok(id)
    }

    /// Adds a shape to a body.
    ///
    /// # Errors
    /// [`ModelError::UnknownPart`] if the body is not there.
    pub fn add_geom(&mut self, body: BodyId, mut geom: Geom) -> Result<GeomId, ModelError> {
        self.known_body(body, || format!("geom '{}'", geom.name))?;
        geom.body = body;
        let id = GeomId(self.parts.geoms.len() as u32);
        self.parts.geoms.push(geom);
        Ok(id)
    }

    /// Gives the world a floor: the plane z = 0, a geom called "floor". Its own friction is 0, so that the friction of what stands
    /// on it counts.
    pub fn floor(&mut self) -> &mut Self {
        self.parts.geoms.push(Geom::new("floor", Geometry::Plane).with_friction(0.0));
        self
    }

    /// Makes two geoms meet with a friction of their own.
    pub fn add_pair(&mut self, pair: GeomPair) -> &mut Self {
        self.parts.pairs.push(pair);
        self
    }

    /// Keeps two bodies from touching.
    pub fn exclude(&mut self, a: BodyId, b: BodyId) -> &mut Self {
        self.parts.excluded.push((a, b));
        self
    }

    /// Adds an equality constraint. Its joints are those that [`add_joint`](Self::add_joint) gave.
    pub fn add_equality(&mut self, name: impl Into<String>, kind: EqualityKind) -> &mut Self {
        self.parts.equalities.push(Equality { name: name.into(), kind });
        self
    }

    /// `X_WB` of a body at the reference configuration; that of the world for a body that is not there.
    pub fn reference_pose(&self, body: BodyId) -> Pose {
        if body.index() < self.parts.bodies.len() { reference_pose(&self.parts.bodies, body) } else { Pose::IDENTITY }
    }

    /// Adds a site to a body.
    ///
    /// # Errors
    /// [`ModelError::UnknownPart`] if the body is not there.
    pub fn add_site(&mut self, body: BodyId, mut site: Site) -> Result<SiteId, ModelError> {
        self.known_body(body, || format!("site '{}'", site.name))?;
        site.body = body;
        let id = SiteId(self.parts.sites.len() as u32);
        self.parts.sites.push(site);
        Ok(id)
    }

    /// Adds a camera to a body.
    ///
    /// # Errors
    /// [`ModelError::UnknownPart`] if the body is not there.
    pub fn add_camera(&mut self, body: BodyId, mut camera: Camera) -> Result<&mut Self, ModelError> {
        self.known_body(body, || format!("camera '{}'", camera.name))?;
        camera.body = body;
        self.parts.cameras.push(camera);
        Ok(self)
    }

    /// Adds a light to a body.
    ///
    /// # Errors
    /// [`ModelError::UnknownPart`] if the body is not there.
    pub fn add_light(&mut self, body: BodyId, mut light: Light) -> Result<&mut Self, ModelError> {
        self.known_body(body, || "a light".into())?;
        light.body = body;
        self.parts.lights.push(light);
        Ok(self)
    }

    /// A site that was added, if there is one of this index.
    pub fn site(&self, site: SiteId) -> Option<&Site> {
        self.parts.sites.get(site.index())
    }

    /// Adds a tendon; its joints are named by what [`add_joint`](Self::add_joint) gave back.
    pub fn add_tendon(&mut self, tendon: Tendon) -> TendonId {
        self.parts.tendons.push(tendon);
        TendonId(self.parts.tendons.len() as u32 - 1)
    }

    /// Adds an actuator.
    pub fn add_actuator(&mut self, actuator: Actuator) -> ActuatorId {
        self.parts.actuators.push(actuator);
        ActuatorId(self.parts.actuators.len() as u32 - 1)
    }

    /// Gives every slide, hinge and ball joint that moves no mass, or no rotational inertia, and has no armature, this one, and returns the
    /// names of these joints.
    ///
    /// - `mass`: of a slide, kg
    /// - `inertia`: of a hinge or ball, kg·m²
    pub fn arm_massless_joints(&mut self, mass: f64, inertia: f64) -> Vec<String> {
        let joints =
            self.parts.joints.iter().enumerate().flat_map(|(body, joints)| joints.iter().map(move |j| (body, j)));
        let weightless =
            moving_no_mass(&self.parts.bodies, joints).filter(|(_, joint, _)| joint.kind != JointKind::Free);
        let names: Vec<String> = weightless.map(|(_, joint, _)| joint.name.clone()).collect();
        for joint in self.parts.joints.iter_mut().flatten().filter(|joint| names.contains(&joint.name)) {
            joint.armature = if matches!(joint.kind, JointKind::Slide { .. }) { mass } else { inertia };
        }
        names
    }

    /// Adds a sensor behind those there are.
    pub fn add_sensor(&mut self, sensor: Sensor) -> &mut Self {
        self.parts.sensors.push(sensor);
        self
    }

    /// Adds a named state.
    pub fn add_keyframe(&mut self, keyframe: Keyframe) -> &mut Self {
        self.parts.keyframes.push(keyframe);
        self
    }

    /// Checks everything, orders the joints, and makes rotations and axes unit to the last digit.
    ///
    /// # Errors
    /// The first [`ModelError`] met, in the order names, bodies, joints, geoms, equality constraints, sites, tendons, actuators,
    /// sensors, keyframes.
    pub fn build(self) -> Result<Model, ModelError> {
        self.check_names()?;
        self.check_options()?;
        for body in &self.parts.bodies {
            check_inertia(body)?;
        }
        let mut model = self.parts.assemble();
        check_relations(&model)?;
        check_sensors(&model)?;
        check_keyframes(&mut model)?;
        let bodies = model.bodies.len();
        check_cameras(&mut model.cameras, bodies)?;
        normalise(&mut model);
        measure_tendons(&mut model);
        place_cameras(&mut model);
        Ok(model)
    }

    fn known_body(&self, body: BodyId, part: impl FnOnce() -> String) -> Result<(), ModelError> {
        if body.index() < self.parts.bodies.len() {
            return Ok(());
        }
        Err(ModelError::UnknownPart { part: part(), sort: "body", index: body.index(), count: self.parts.bodies.len() })
    }

    fn check_names(&self) -> Result<(), ModelError> {
        unique("body", self.parts.bodies.iter().map(|b| &b.name))?;
        unique("joint", self.parts.joints.iter().flatten().map(|j| &j.name))?;
        unique("geom", self.parts.geoms.iter().map(|g| &g.name))?;
        unique("equality constraint", self.parts.equalities.iter().map(|e| &e.name))?;
        unique("site", self.parts.sites.iter().map(|s| &s.name))?;
        unique("tendon", self.parts.tendons.iter().map(|t| &t.name))?;
        unique("sensor", self.parts.sensors.iter().map(|s| &s.name))?;
        unique("actuator", self.parts.actuators.iter().map(|a| &a.name))?;
        unique("keyframe", self.parts.keyframes.iter().map(|k| &k.name))?;
        unique("camera", self.parts.cameras.iter().map(|c| &c.name))
    }

    fn check_options(&self) -> Result<(), ModelError> {
        let part = || format!("model '{}'", self.parts.name);
        number(part, "time step", "positive and finite", self.parts.timestep, |x| x > 0.0)?;
        self.parts.gravity.to_array().iter().try_for_each(|&g| number(part, "gravity", "finite", g, |_| true))?;
        self.parts.magnetic.to_array().iter().try_for_each(|&x| number(part, "magnetic field", "finite", x, |_| true))
    }
}
