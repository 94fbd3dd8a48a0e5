//! What parts refer to.

use signorini_multibody::{
    Actuator, ActuatorId, BodyId, Camera, CameraId, CameraMode, ContactSide, Equality, EqualityKind, FrameId, GeomId,
    JointId, Light, PathPart, Sensor, SensorKind, Shapes, SiteId, Tendon, TendonId, Transmission,
};

use crate::SpecError;
use crate::keyframe::KeyframeSpec;

/// New identifiers of parts by their old ones; nothing for those that are not there.
#[derive(Clone, Debug, Default)]
pub(crate) struct Places {
    pub bodies: Vec<Option<BodyId>>,
    pub joints: Vec<Option<JointId>>,
    pub geoms: Vec<Option<GeomId>>,
    pub sites: Vec<Option<SiteId>>,
    pub tendons: Vec<Option<TendonId>>,
    pub actuators: Vec<Option<ActuatorId>>,
    pub cameras: Vec<Option<CameraId>>,
}

macro_rules! place_of {
    ($($name:ident, $list:ident, $id:ty, $sort:literal;)*) => {
        impl Places {
            $(pub fn $name(&self, id: &mut $id) -> Result<(), &'static str> {
                *id = self.$list.get(id.index()).copied().flatten().ok_or($sort)?;
                Ok(())
            })*
        }
    };
}
place_of! {
    body, bodies, BodyId, "body";
    joint, joints, JointId, "joint";
    geom, geoms, GeomId, "geom";
    site, sites, SiteId, "site";
    tendon, tendons, TendonId, "tendon";
    actuator, actuators, ActuatorId, "actuator";
    camera, cameras, CameraId, "camera";
}

/// A part that refers to others.
pub(crate) trait Refers: Clone + crate::parts::Named {
    /// Replaces all identifiers; the sort of the first part that is missing.
    fn renumber(&mut self, places: &Places) -> Result<(), &'static str>;

    /// The part with new identifiers.
    fn moved(&self, places: &Places) -> Result<Self, SpecError> {
        let mut part = self.clone();
        let dangling = |sort| SpecError::DanglingReference { part: format!("{} '{}'", Self::SORT, self.name()), sort };
        part.renumber(places).map_err(dangling)?;
        Ok(part)
    }
}

impl Refers for Tendon {
    fn renumber(&mut self, places: &Places) -> Result<(), &'static str> {
        self.terms.iter_mut().try_for_each(|(joint, _)| places.joint(joint))?;
        self.path.iter_mut().try_for_each(|part| match part {
            PathPart::Site(site) => places.site(site),
            PathPart::Wrap { geom, side } => {
                places.geom(geom)?;
                side.as_mut().map_or(Ok(()), |side| places.site(side))
            }
            PathPart::Pulley { .. } => Ok(()),
        })
    }
}

impl Refers for Actuator {
    fn renumber(&mut self, places: &Places) -> Result<(), &'static str> {
        match &mut self.transmission {
            Transmission::Joint(joint) | Transmission::JointAxes { joint, .. } => places.joint(joint),
            Transmission::Tendon(tendon) => places.tendon(tendon),
            Transmission::Site { site, reference, .. } => {
                places.site(site)?;
                reference.as_mut().map_or(Ok(()), |reference| places.site(reference))
            }
            Transmission::Body { body, .. } => places.body(body),
        }
    }
}

impl Refers for Equality {
    fn renumber(&mut self, places: &Places) -> Result<(), &'static str> {
        match &mut self.kind {
            EqualityKind::Connect { body_a, body_b, .. } | EqualityKind::Weld { body_a, body_b, .. } => {
                places.body(body_a)?;
                places.body(body_b)
            }
            EqualityKind::Joint { joint, driver, .. } => {
                places.joint(joint)?;
                driver.as_mut().map_or(Ok(()), |driver| places.joint(driver))
            }
            EqualityKind::Tendon { tendon, driver, .. } => {
                places.tendon(tendon)?;
                driver.as_mut().map_or(Ok(()), |driver| places.tendon(driver))
            }
        }
    }
}

impl Refers for Sensor {
    fn renumber(&mut self, places: &Places) -> Result<(), &'static str> {
        use SensorKind as K;
        let frame = |frame: &mut FrameId| match frame {
            FrameId::Body(id) | FrameId::CenterOfMass(id) => places.body(id),
            FrameId::Geom(id) => places.geom(id),
            FrameId::Site(id) => places.site(id),
        };
        match &mut self.kind {
            K::JointPosition(id)
            | K::JointVelocity(id)
            | K::JointActuatorForce(id)
            | K::JointLimitPosition(id)
            | K::JointLimitVelocity(id)
            | K::JointLimitForce(id)
            | K::BallQuaternion(id)
            | K::BallAngularVelocity(id) => places.joint(id),
            K::TendonPosition(id)
            | K::TendonVelocity(id)
            | K::TendonActuatorForce(id)
            | K::TendonLimitPosition(id)
            | K::TendonLimitVelocity(id)
            | K::TendonLimitForce(id) => places.tendon(id),
            K::ActuatorPosition(id) | K::ActuatorVelocity(id) | K::ActuatorForce(id) => places.actuator(id),
            K::Magnetometer(id) | K::Rangefinder(id) => places.site(id),
            K::InsideSite(own, id) => {
                frame(own)?;
                places.site(id)
            }
            K::CameraProjection(id, camera) => {
                places.site(id)?;
                places.camera(camera)
            }
            K::Contacts(contacts) => contacts.sides.iter_mut().try_for_each(|side| match side {
                ContactSide::Any => Ok(()),
                ContactSide::Geom(id) => places.geom(id),
                ContactSide::Body(id) | ContactSide::Subtree(id) => places.body(id),
                ContactSide::Zone(id) => places.site(id),
            }),
            K::ShapeDistance(a, b) | K::ShapeNormal(a, b) | K::ShapePoints(a, b) => {
                [a, b].into_iter().try_for_each(|shapes| match shapes {
                    Shapes::Geom(id) => places.geom(id),
                    Shapes::Body(id) => places.body(id),
                })
            }
            K::Velocimeter(id) | K::Gyro(id) | K::Accelerometer(id) | K::Force(id) | K::Torque(id) | K::Touch(id) => {
                places.site(id)
            }
            K::FramePosition(own, reference)
            | K::FrameQuaternion(own, reference)
            | K::FrameAxis(own, reference, _)
            | K::FrameLinearVelocity(own, reference)
            | K::FrameAngularVelocity(own, reference) => {
                frame(own)?;
                reference.as_mut().map_or(Ok(()), frame)
            }
            K::FrameLinearAcceleration(own) | K::FrameAngularAcceleration(own) => frame(own),
            K::SubtreeCenterOfMass(id) | K::SubtreeLinearVelocity(id) | K::SubtreeAngularMomentum(id) => {
                places.body(id)
            }
            K::PotentialEnergy | K::KineticEnergy | K::Clock => Ok(()),
        }
    }
}

impl Refers for KeyframeSpec {
    /// What it says of parts that are gone is forgotten.
    fn renumber(&mut self, places: &Places) -> Result<(), &'static str> {
        self.q.retain_mut(|(joint, _)| places.joint(joint).is_ok());
        self.v.retain_mut(|(joint, _)| places.joint(joint).is_ok());
        self.activation.retain_mut(|(actuator, _)| places.actuator(actuator).is_ok());
        self.control.retain_mut(|(actuator, _)| places.actuator(actuator).is_ok());
        self.mocap.retain_mut(|(body, _)| places.body(body).is_ok());
        Ok(())
    }
}

impl Refers for Camera {
    fn renumber(&mut self, places: &Places) -> Result<(), &'static str> {
        places.body(&mut self.body)?;
        match &mut self.mode {
            CameraMode::Target(body) | CameraMode::TargetCenterOfMass(body) => places.body(body),
            CameraMode::Fixed | CameraMode::Track | CameraMode::TrackCenterOfMass => Ok(()),
        }
    }
}

impl Refers for Light {
    fn renumber(&mut self, places: &Places) -> Result<(), &'static str> {
        places.body(&mut self.body)
    }
}
