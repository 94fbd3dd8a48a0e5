//! The immutable description of a mechanism.

mod actuator;
mod builder;
mod check;
mod check_sensing;
mod equality;
mod error;
mod filter;
mod geometry;
mod hash;
mod ids;
mod inertia;
mod look;
mod mechanism;
mod new_body;
mod parameter;
mod parts;
mod path;
mod sensing;
mod transmission;

pub use actuator::{Activation, ActivationKind, Actuator, ActuatorKind};
pub use builder::ModelBuilder;
pub use equality::{Equality, EqualityKind};
pub use error::ModelError;
pub use filter::ContactFilter;
pub use geometry::{Geometry, HeightField, Mesh};
pub use ids::{ActuatorId, BodyId, GeomId, JointId, SiteId, TendonId};
pub use inertia::Inertia;
pub use look::{Camera, CameraMode, Checker, Light, Look};
pub use mechanism::Model;
pub use new_body::NewBody;
pub use parameter::{ChangedRow, Effect, Parameter, ParameterChange};
pub use parts::{Body, Geom, GeomPair, Joint, JointKind, Keyframe, SpinResistance};
pub(crate) use path::PathStep;
pub use sensing::{FrameId, Sensor, SensorKind, Shapes, Site};
pub use transmission::{Tendon, Transmission};
