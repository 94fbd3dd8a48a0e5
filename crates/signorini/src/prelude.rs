//! What most programs name: `use signorini::prelude::*;`.

pub use signorini_multibody::glam::{DQuat, DVec3};
pub use signorini_multibody::{
    Actuator, ActuatorKind, BodyId, Geom, Geometry, Inertia, Input, Joint, JointKind, Model, ModelBuilder, Pose, State,
};
pub use signorini_simulation::{
    Batch, ContactMethod, FrictionLaw, ImpulseChoice, InfeasiblePolicy, OverlapPolicy, RestitutionLaw, RunEnd,
    Settings, SettleSettings, Simulation, SimulationError, Snapshot, StepReport, Variation,
};

#[cfg(feature = "formats")]
pub use signorini_formats::{LoadOptions, load};
#[cfg(feature = "viewer")]
pub use signorini_viewer::{Viewer, ViewerSettings};
