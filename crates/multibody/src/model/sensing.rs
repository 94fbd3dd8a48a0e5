//! Sites and the sensors that measure at them.

use derive_setters::Setters;
use glamx::glam::DVec3;

use super::{ActuatorId, BodyId, CameraId, ContactSensor, GeomId, Geometry, JointId, SiteId, TendonId};
use crate::math::Pose;

/// A frame fixed to a body, without mass and touching nothing: where sensors measure and actuators pull.
#[derive(Clone, Debug, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct Site {
    /// Unique name.
    #[setters(into)]
    pub name: String,
    /// The body it is fixed to.
    #[setters(skip)]
    pub body: BodyId,
    /// `X_BS`, the site's frame in the body's.
    #[setters(into)]
    pub placement: Pose,
    /// The zone in which a touch sensor feels contacts.
    pub zone: Geometry,
}

impl Site {
    /// A site at its body's origin with a zone of the size of a fingertip, a ball of radius 5 mm.
    pub fn new(name: impl Into<String>) -> Self {
        let zone = Geometry::Sphere { radius: 0.005 };
        Self { name: name.into(), body: BodyId::WORLD, placement: Pose::IDENTITY, zone }
    }

    /// Whether a point in the site's frame lies in its zone.
    pub fn holds(&self, p: DVec3) -> bool {
        let beside = |radius: f64| p.x.hypot(p.y) <= radius;
        match self.zone {
            Geometry::Sphere { radius } => p.length() <= radius,
            Geometry::Ellipsoid { semi_axes } => (p / semi_axes).length() <= 1.0,
            Geometry::Box { half_extents } => p.abs().cmple(half_extents).all(),
            Geometry::Cylinder { radius, half_length } => beside(radius) && p.z.abs() <= half_length,
            Geometry::Capsule { radius, half_length } => {
                (p - DVec3::Z * p.z.clamp(-half_length, half_length)).length() <= radius
            }
            _ => false,
        }
    }
}

/// A sensor. Its numbers stand at `address` in the array of all sensors, as many as [`SensorKind::size`] says.
#[derive(Clone, Debug, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct Sensor {
    /// Unique name.
    #[setters(into)]
    pub name: String,
    /// What it measures.
    pub kind: SensorKind,
    /// Bound of the absolute value of every number, in its unit; orientations and directions have none.
    #[setters(into)]
    pub cutoff: Option<f64>,
    /// Where its numbers begin in the array of all sensors; set by the builder.
    #[setters(skip)]
    pub address: usize,
}

impl Sensor {
    /// A sensor without bound.
    pub fn new(name: impl Into<String>, kind: SensorKind) -> Self {
        Self { name: name.into(), kind, cutoff: None, address: 0 }
    }
}

/// A frame that sensors can look at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameId {
    /// The frame of a body.
    Body(BodyId),
    /// At the centre of mass of a body, with the body's axes.
    CenterOfMass(BodyId),
    /// The frame of a geom.
    Geom(GeomId),
    /// The frame of a site.
    Site(SiteId),
}

/// The shapes that a distance is measured to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shapes {
    /// One geom.
    Geom(GeomId),
    /// All geoms of a body.
    Body(BodyId),
}

/// What a sensor measures, with MuJoCo's names and meanings. Site sensors measure in the axes of their site; frame
/// sensors in world or, where given, relative to a moving reference frame and in its axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SensorKind {
    /// `q` of a hinge or slide, rad or m (`jointpos`).
    JointPosition(JointId),
    /// `v` of a hinge or slide, rad/s or m/s (`jointvel`).
    JointVelocity(JointId),
    /// Force of all actuators in the coordinate of a hinge or slide, N·m or N (`jointactuatorfrc`).
    JointActuatorForce(JointId),
    /// Force of all actuators that drive a tendon, before their gears, N or N·m (`tendonactuatorfrc`).
    TendonActuatorForce(TendonId),
    /// Distance to the nearest limit of a joint where it is passed, else 0, rad or m (`jointlimitpos`).
    JointLimitPosition(JointId),
    /// Rate of that distance where the limit is passed, else 0, rad/s or m/s (`jointlimitvel`).
    JointLimitVelocity(JointId),
    /// Force of the limits of a joint, N·m or N (`jointlimitfrc`).
    JointLimitForce(JointId),
    /// Distance to the nearest limit of a tendon where it is passed, else 0, m or rad (`tendonlimitpos`).
    TendonLimitPosition(TendonId),
    /// Rate of that distance where the limit is passed, else 0 (`tendonlimitvel`).
    TendonLimitVelocity(TendonId),
    /// Force of the limits of a tendon, N or N·m (`tendonlimitfrc`).
    TendonLimitForce(TendonId),
    /// Quaternion of a ball joint (`ballquat`).
    BallQuaternion(JointId),
    /// Angular velocity of a ball joint in the axes after it, rad/s (`ballangvel`).
    BallAngularVelocity(JointId),
    /// Length of a tendon, m or rad (`tendonpos`).
    TendonPosition(TendonId),
    /// Rate of the length of a tendon (`tendonvel`).
    TendonVelocity(TendonId),
    /// Length of an actuator, gear included (`actuatorpos`).
    ActuatorPosition(ActuatorId),
    /// Rate of the length of an actuator (`actuatorvel`).
    ActuatorVelocity(ActuatorId),
    /// Force of an actuator before the gear, N or N·m (`actuatorfrc`).
    ActuatorForce(ActuatorId),
    /// Velocity of the site, m/s (`velocimeter`).
    Velocimeter(SiteId),
    /// Angular velocity of the site, rad/s (`gyro`).
    Gyro(SiteId),
    /// Acceleration of the site less gravity, m/s² (`accelerometer`).
    Accelerometer(SiteId),
    /// Force with which the body of the site is held by its parent, N (`force`).
    Force(SiteId),
    /// Moment about the site with which its body is held by its parent, N·m (`torque`).
    Torque(SiteId),
    /// Sum of the normal forces on the site's body whose line meets the site's zone, N (`touch`).
    Touch(SiteId),
    /// Origin of a frame, m (`framepos`).
    FramePosition(FrameId, Option<FrameId>),
    /// Orientation of a frame, quaternion w x y z (`framequat`).
    FrameQuaternion(FrameId, Option<FrameId>),
    /// Axis 0, 1 or 2 of a frame (`framexaxis`, `frameyaxis`, `framezaxis`).
    FrameAxis(FrameId, Option<FrameId>, u8),
    /// Velocity of a frame's origin, m/s (`framelinvel`).
    FrameLinearVelocity(FrameId, Option<FrameId>),
    /// Angular velocity of a frame, rad/s (`frameangvel`).
    FrameAngularVelocity(FrameId, Option<FrameId>),
    /// Acceleration of a frame's origin less gravity, world axes, m/s² (`framelinacc`).
    FrameLinearAcceleration(FrameId),
    /// Angular acceleration of a frame, world axes, rad/s² (`frameangacc`).
    FrameAngularAcceleration(FrameId),
    /// Centre of mass of a body with all that hangs on it, m (`subtreecom`).
    SubtreeCenterOfMass(BodyId),
    /// Velocity of that centre of mass, m/s (`subtreelinvel`).
    SubtreeLinearVelocity(BodyId),
    /// Angular momentum about that centre of mass, kg·m²/s (`subtreeangmom`).
    SubtreeAngularMomentum(BodyId),
    /// Magnetic field in the axes of the site, in the unit of the model's field (`magnetometer`).
    Magnetometer(SiteId),
    /// Distance along the site's z axis to the first geom that is not of its body and not invisible, m; −1, or the negative of a smaller
    /// cutoff, where there is none (`rangefinder`).
    Rangefinder(SiteId),
    /// Signed distance of two shapes, m, at most the cutoff (`distance`).
    ShapeDistance(Shapes, Shapes),
    /// Unit vector from the first to the second of the nearest points, world axes: of overlapping shapes against the way they part; zero beyond
    /// the cutoff (`normal`).
    ShapeNormal(Shapes, Shapes),
    /// The nearest points of the first and of the second shape, world, m; zero beyond the cutoff (`fromto`).
    ShapePoints(Shapes, Shapes),
    /// Where a camera sees the site: pixels from the left and from the upper edge of its picture, also outside of it and behind the camera
    /// (`camprojection`).
    CameraProjection(SiteId, CameraId),
    /// Contacts between two sides (`contact`).
    Contacts(ContactSensor),
    /// 1 where the origin of a frame lies in the zone of the site, else 0 (`insidesite`).
    InsideSite(FrameId, SiteId),
    /// Potential energy of gravity and springs, J (`e_potential`): [`potential_energy`](crate::potential_energy).
    PotentialEnergy,
    /// Kinetic energy, J (`e_kinetic`): [`kinetic_energy`](crate::kinetic_energy).
    KineticEnergy,
    /// Time, s (`clock`).
    Clock,
}

impl SensorKind {
    /// How many numbers the sensor gives.
    pub fn size(self) -> usize {
        match self {
            Self::JointPosition(_)
            | Self::JointVelocity(_)
            | Self::JointActuatorForce(_)
            | Self::TendonActuatorForce(_)
            | Self::TendonPosition(_)
            | Self::TendonVelocity(_)
            | Self::ActuatorPosition(_)
            | Self::ActuatorVelocity(_)
            | Self::ActuatorForce(_)
            | Self::Touch(_)
            | Self::Rangefinder(_)
            | Self::ShapeDistance(..)
            | Self::JointLimitPosition(_)
            | Self::JointLimitVelocity(_)
            | Self::JointLimitForce(_)
            | Self::TendonLimitPosition(_)
            | Self::TendonLimitVelocity(_)
            | Self::TendonLimitForce(_)
            | Self::InsideSite(..)
            | Self::PotentialEnergy
            | Self::KineticEnergy
            | Self::Clock => 1,
            Self::CameraProjection(..) => 2,
            Self::BallQuaternion(_) | Self::FrameQuaternion(..) => 4,
            Self::ShapePoints(..) => 6,
            Self::Contacts(sensor) => usize::from(sensor.slots) * sensor.slot_size(),
            _ => 3,
        }
    }

    /// Whether the value depends on what happens in the step (forces, accelerations), not on the state alone.
    pub fn needs_step(self) -> bool {
        matches!(
            self,
            Self::JointActuatorForce(_)
                | Self::TendonActuatorForce(_)
                | Self::JointLimitForce(_)
                | Self::TendonLimitForce(_)
                | Self::ActuatorForce(_)
                | Self::Accelerometer(_)
                | Self::Force(_)
                | Self::Torque(_)
                | Self::Touch(_)
                | Self::Contacts(_)
                | Self::FrameLinearAcceleration(_)
                | Self::FrameAngularAcceleration(_)
        )
    }

    /// Whether the value depends on the shapes of geoms.
    pub fn needs_shapes(self) -> bool {
        use SensorKind::{Rangefinder, ShapeDistance, ShapeNormal, ShapePoints};
        matches!(self, Rangefinder(_) | ShapeDistance(..) | ShapeNormal(..) | ShapePoints(..))
    }

    /// Whether the numbers are an orientation, a direction, points or contacts, which no cutoff bounds.
    pub fn is_direction(self) -> bool {
        use SensorKind::{BallQuaternion, Contacts, FrameAxis, FrameQuaternion, ShapeNormal, ShapePoints};
        let turns = matches!(self, BallQuaternion(_) | FrameQuaternion(..) | FrameAxis(..));
        turns || matches!(self, ShapeNormal(..) | ShapePoints(..) | Contacts(_))
    }
}
