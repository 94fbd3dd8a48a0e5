//! Multibody dynamics on trees of rigid bodies, without contact.
//!
//! The first rooms of the house: an immutable [`Model`] (made by [`ModelBuilder`]), a [`State`] `(t, q, v)`, and the
//! nouns that the other crates share ([`Geometry`], [`Geom`], [`ContactPoint`]). Everything is `f64` and SI.
//!
//! Conventions (the whole law is in `NOTATION.md`):
//! - frames in monogram notation: `X_WB` is the pose of body frame B in world W, `p_WB` its origin;
//! - quaternions in `q` are (w, x, y, z);
//! - a free joint has `q = [p_WB, quat_WB]` and `v = [velocity of B's origin in world axes, angular velocity in body axes]`;
//!   a ball joint has the angular velocity in body axes; hinges and slides are scalars.

mod math;
pub mod model;
mod state;

pub use math::Pose;
pub use model::{
    Actuator, ActuatorKind, Body, BodyId, ContactFilter, Geom, GeomId, GeomPair, Geometry, Inertia, Joint, JointId,
    JointKind, Keyframe, Model, ModelBuilder, ModelError,
};
pub use state::{ContactPoint, Input, State};

/// The vector library of the public interface, re-exported so that users have the same types.
pub use glamx::glam;
