//! The model under construction.

use signorini_multibody::glam::DVec3;
use signorini_multibody::{
    Actuator, ActuatorId, Body, BodyId, Camera, Equality, Geom, GeomId, GeomPair, Inertia, Joint, JointId, Light,
    Model, ModelBuilder, Pose, Sensor, Site, SiteId, Tendon, TendonId,
};

use crate::SpecError;
use crate::keyframe::KeyframeSpec;
use crate::parts::Parts;

/// A model that can be edited.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Spec {
    /// Name of the model.
    pub name: String,
    /// Gravity in world, m/s².
    pub gravity: DVec3,
    /// Magnetic field in world, which magnetometers measure.
    pub magnetic: DVec3,
    /// Suggested time step, s.
    pub timestep: f64,
    /// Whether simulations leave alone what rests, where they are not told otherwise.
    pub sleeping: bool,
    /// Pairs of geoms with a friction of their own.
    pub pairs: Vec<GeomPair>,
    /// Pairs of bodies that are kept from touching.
    pub excluded: Vec<(BodyId, BodyId)>,
    pub(crate) bodies: Parts<Body>,
    pub(crate) joints: Parts<Joint>,
    pub(crate) geoms: Parts<Geom>,
    pub(crate) sites: Parts<Site>,
    pub(crate) tendons: Parts<Tendon>,
    pub(crate) actuators: Parts<Actuator>,
    pub(crate) sensors: Parts<Sensor>,
    pub(crate) equalities: Parts<Equality>,
    pub(crate) keyframes: Parts<KeyframeSpec>,
    /// Cameras for pictures.
    pub cameras: Vec<Camera>,
    /// Lights for pictures.
    pub lights: Vec<Light>,
}

impl Spec {
    /// An empty world with gravity (0, 0, −9.81) m/s² and a time step of 2 ms.
    pub fn new(name: impl Into<String>) -> Self {
        let empty = ModelBuilder::new(name).build();
        // An empty world has nothing that could be wrong.
        empty.map(|model| Self::from_model(&model)).unwrap_or_else(|_| unreachable!("an empty world is a model"))
    }

    /// A copy of a model; its parts have the identifiers that they have there.
    pub fn from_model(model: &Model) -> Self {
        Self {
            name: model.name.clone(),
            gravity: model.gravity,
            magnetic: model.magnetic,
            timestep: model.timestep,
            sleeping: model.sleeping,
            pairs: model.pairs.clone(),
            excluded: model.contact_filter.excluded_bodies().copied().collect(),
            bodies: Parts::of(model.bodies.iter().cloned()),
            joints: Parts::of(model.joints.iter().cloned()),
            geoms: Parts::of(model.geoms.iter().cloned()),
            sites: Parts::of(model.sites.iter().cloned()),
            tendons: Parts::of(model.tendons.iter().cloned()),
            actuators: Parts::of(model.actuators.iter().cloned()),
            sensors: Parts::of(model.sensors.iter().cloned()),
            equalities: Parts::of(model.equalities.iter().cloned()),
            cameras: model.cameras.clone(),
            lights: model.lights.clone(),
            keyframes: Parts::of(model.keyframes.iter().map(|keyframe| KeyframeSpec::of(model, keyframe))),
        }
    }

    /// Adds a body at `placement` (`X_PB`) in its parent ("world" is the world), welded to it until a joint is added.
    ///
    /// # Errors
    /// [`SpecError::UnknownName`] of the parent, [`SpecError::DuplicateName`].
    pub fn add_body(
        &mut self,
        name: impl Into<String>,
        parent: &str,
        placement: Pose,
        inertia: Inertia,
    ) -> Result<BodyId, SpecError> {
        let (parent, name) = (self.body(parent)?, name.into());
        // A builder makes bodies; their other fields are the compiled model's.
        let mut maker = ModelBuilder::new("");
        maker.add_body(name, BodyId::WORLD, placement, inertia)?;
        let made = maker.build()?.bodies.pop();
        let Some(mut body) = made else { return Err(SpecError::World { what: "added" }) };
        body.parent = parent;
        self.bodies.add(body).map(|i| BodyId(i as u32))
    }

    /// Adds a joint to a body, after those it has.
    ///
    /// # Errors
    /// [`SpecError::UnknownName`] of the body, [`SpecError::DuplicateName`].
    pub fn add_joint(&mut self, body: &str, mut joint: Joint) -> Result<JointId, SpecError> {
        joint.body = self.body(body)?;
        self.joints.add(joint).map(|i| JointId(i as u32))
    }

    /// Adds a shape without mass to a body.
    ///
    /// # Errors
    /// As [`add_joint`](Self::add_joint).
    pub fn add_geom(&mut self, body: &str, mut geom: Geom) -> Result<GeomId, SpecError> {
        geom.body = self.body(body)?;
        self.geoms.add(geom).map(|i| GeomId(i as u32))
    }

    /// Adds a shape to a body, and to the body's inertia that of a uniform solid of the shape, of `mass` (kg). What is changed in the geom
    /// later does not change the inertia.
    ///
    /// # Errors
    /// As [`add_joint`](Self::add_joint), and [`SpecError::NoVolume`].
    pub fn add_solid(&mut self, body: &str, geom: Geom, mass: f64) -> Result<GeomId, SpecError> {
        let Some(inertia) = Inertia::of_solid(&geom.geometry, mass) else {
            return Err(SpecError::NoVolume { geom: geom.name, kind: geom.geometry.kind_name() });
        };
        let placed = inertia.placed(&geom.placement);
        let id = self.add_geom(body, geom)?;
        let body = self.body_mut(body)?;
        body.inertia = Inertia::sum(&[body.inertia, placed]);
        Ok(id)
    }

    /// Adds a site to a body.
    ///
    /// # Errors
    /// As [`add_joint`](Self::add_joint).
    pub fn add_site(&mut self, body: &str, mut site: Site) -> Result<SiteId, SpecError> {
        site.body = self.body(body)?;
        self.sites.add(site).map(|i| SiteId(i as u32))
    }

    /// Adds a tendon.
    ///
    /// # Errors
    /// [`SpecError::DuplicateName`].
    pub fn add_tendon(&mut self, tendon: Tendon) -> Result<TendonId, SpecError> {
        self.tendons.add(tendon).map(|i| TendonId(i as u32))
    }

    /// Adds an actuator.
    ///
    /// # Errors
    /// [`SpecError::DuplicateName`].
    pub fn add_actuator(&mut self, actuator: Actuator) -> Result<ActuatorId, SpecError> {
        self.actuators.add(actuator).map(|i| ActuatorId(i as u32))
    }

    /// Adds a sensor behind those there are.
    ///
    /// # Errors
    /// [`SpecError::DuplicateName`].
    pub fn add_sensor(&mut self, sensor: Sensor) -> Result<(), SpecError> {
        self.sensors.add(sensor).map(|_| ())
    }

    /// Adds an equality constraint.
    ///
    /// # Errors
    /// [`SpecError::DuplicateName`].
    pub fn add_equality(&mut self, equality: Equality) -> Result<(), SpecError> {
        self.equalities.add(equality).map(|_| ())
    }

    /// Adds a named state.
    ///
    /// # Errors
    /// [`SpecError::DuplicateName`].
    pub fn add_keyframe(&mut self, keyframe: KeyframeSpec) -> Result<(), SpecError> {
        self.keyframes.add(keyframe).map(|_| ())
    }

    /// Keeps two bodies from touching.
    ///
    /// # Errors
    /// [`SpecError::UnknownName`].
    pub fn exclude(&mut self, a: &str, b: &str) -> Result<(), SpecError> {
        let pair = (self.body(a)?, self.body(b)?);
        self.excluded.push(pair);
        Ok(())
    }
}

macro_rules! lookups {
    ($($find:ident, $change:ident, $list:ident, $part:ty, $id:ident, $names:ident, $word:literal;)*) => {
        impl Spec {
            $(#[doc = concat!("The ", $word, " of this name.")]
            ///
            /// # Errors
            /// [`SpecError::UnknownName`], with the name that is most like it.
            pub fn $find(&self, name: &str) -> Result<$id, SpecError> {
                self.$list.find(name).map(|i| $id(i as u32))
            }

            #[doc = concat!("The ", $word, " of this name, to be changed. What it refers to is named by the identifiers of this spec.")]
            ///
            /// # Errors
            /// [`SpecError::UnknownName`], with the name that is most like it.
            pub fn $change(&mut self, name: &str) -> Result<&mut $part, SpecError> {
                self.$list.named_mut(name)
            }

            #[doc = concat!("Names of all parts of the sort ", $word, ", in their order.")]
            pub fn $names(&self) -> impl Iterator<Item = &str> {
                self.$list.iter().map(|(_, part)| part.name.as_str())
            })*
        }
    };
}
lookups! {
    body, body_mut, bodies, Body, BodyId, body_names, "body";
    joint, joint_mut, joints, Joint, JointId, joint_names, "joint";
    geom, geom_mut, geoms, Geom, GeomId, geom_names, "geom";
    site, site_mut, sites, Site, SiteId, site_names, "site";
    tendon, tendon_mut, tendons, Tendon, TendonId, tendon_names, "tendon";
    actuator, actuator_mut, actuators, Actuator, ActuatorId, actuator_names, "actuator";
}

impl Spec {
    /// Names of all sensors, in their order.
    pub fn sensor_names(&self) -> impl Iterator<Item = &str> {
        self.sensors.iter().map(|(_, part)| part.name.as_str())
    }

    /// Names of all equality constraints, in their order.
    pub fn equality_names(&self) -> impl Iterator<Item = &str> {
        self.equalities.iter().map(|(_, part)| part.name.as_str())
    }

    /// Names of the bodies that are kept from touching, pair by pair, in the order of [`Spec::excluded`].
    pub fn excluded_names(&self) -> impl Iterator<Item = (&str, &str)> {
        let name = |id: BodyId| self.bodies.get(id.index()).map(|body| body.name.as_str());
        self.excluded.iter().filter_map(move |&(a, b)| Some((name(a)?, name(b)?)))
    }

    /// Names of all keyframes, in their order.
    pub fn keyframe_names(&self) -> impl Iterator<Item = &str> {
        self.keyframes.iter().map(|(_, part)| part.name.as_str())
    }

    /// The sensor of this name, to be changed.
    ///
    /// # Errors
    /// [`SpecError::UnknownName`].
    pub fn sensor_mut(&mut self, name: &str) -> Result<&mut Sensor, SpecError> {
        self.sensors.named_mut(name)
    }

    /// The equality constraint of this name, to be changed.
    ///
    /// # Errors
    /// [`SpecError::UnknownName`].
    pub fn equality_mut(&mut self, name: &str) -> Result<&mut Equality, SpecError> {
        self.equalities.named_mut(name)
    }

    /// The keyframe of this name, to be changed.
    ///
    /// # Errors
    /// [`SpecError::UnknownName`].
    pub fn keyframe_mut(&mut self, name: &str) -> Result<&mut KeyframeSpec, SpecError> {
        self.keyframes.named_mut(name)
    }
}
