//! Multibody dynamics on trees of rigid bodies, without contact.
//!
//! The first rooms of the house: an immutable [`Model`] (made by [`ModelBuilder`]), a [`State`] `(t, q, v)` with the activations of actuators, and the
//! nouns that the other crates share ([`Geometry`], [`Geom`], [`ContactPoint`]). Everything is `f64` and SI.
//!
//! Algorithms are free functions on `(&Model, …, &mut out)` that allocate nothing: [`forward_kinematics_into`] first, then
//! what is computed from its [`Kinematics`]: Jacobians, [`mass_matrix_into`] (CRBA), [`inverse_dynamics_into`] (RNEA),
//! [`forward_dynamics_into`] (ABA), [`free_motion_into`] (all that a step needs before contact), energies and momenta,
//! [`centroidal_momentum_matrix_into`], Jacobians of [`Frame`]s and their rates, the inverse operational-space inertia of many
//! points ([`delassus_into`]); [`integrate_into`] ends the step.
//!
//! ```
//! use signorini_multibody::glam::DVec3;
//! use signorini_multibody::{Geom, Geometry, Joint, Kinematics, ModelBuilder, NewtonEuler, State};
//! use signorini_multibody::{bias_force_into, forward_kinematics_into};
//!
//! // A rod of 2 kg on a hinge at its end, level: gravity turns it with m g l.
//! let mut b = ModelBuilder::new("pendulum");
//! let rod = b.body("rod").joint(Joint::hinge("pivot", DVec3::Y));
//! let shape = Geom::from(Geometry::Box { half_extents: DVec3::new(0.5, 0.02, 0.02) });
//! rod.solid(shape.with_placement([0.5, 0.0, 0.0]), 2.0).add()?;
//! let model = b.build()?;
//!
//! let state = State::new(&model);
//! let mut kinematics = Kinematics::new(&model);
//! forward_kinematics_into(&model, &state.q, &state.v, &mut kinematics);
//! let (mut work, mut bias) = (NewtonEuler::new(&model), [0.0]);
//! bias_force_into(&model, &kinematics, &mut work, &mut bias);
//! assert!((bias[0] + 2.0 * 9.81 * 0.5).abs() < 1e-12);
//! # Ok::<(), signorini_multibody::ModelError>(())
//! ```
//!
//! Conventions (the whole law is in `NOTATION.md`):
//! - frames in monogram notation: `X_WB` is the pose of body frame B in world W, `p_WB` its origin;
//! - quaternions in `q` are (w, x, y, z);
//! - a free joint has `q = [p_WB, quat_WB]` and `v = [velocity of B's origin in world axes, angular velocity in body axes]`;
//!   a ball joint has the angular velocity in body axes; hinges and slides are scalars.

mod activation;
mod actuator_length;
mod applied;
mod camera;
mod centroidal;
mod cholesky;
mod composite;
mod configuration;
mod coriolis;
mod delassus;
pub mod derivatives;
mod dot;
mod energy;
mod equality;
mod forward_dynamics;
mod frame;
mod free_motion;
mod free_rotation;
mod implicit;
mod inverse_dynamics;
mod inverse_kinematics;
mod jacobian;
mod kinematics;
mod layout;
mod length;
mod links;
mod mass;
mod math;
pub mod model;
mod motion;
mod moving;
mod operational;
mod outline;
mod sensors;
mod small_dense;
mod spatial;
mod standing;
mod state;
mod subtree;
mod tendon;
mod tension;

pub use activation::advance_activations_into;
pub use actuator_length::actuator_length_into;
pub use applied::applied_force_into;
pub use camera::{camera_axes, camera_pose};
pub use centroidal::{Centroidal, center_of_mass_jacobian_into, centroidal_momentum_matrix_into};
pub use cholesky::{BlockCholesky, FEW_ROWS, LANES};
pub use composite::{MassMatrix, mass_matrix_into};
pub use configuration::{difference_into, integrate_beside, integrate_into};
pub use delassus::{HalfSolvedRows, delassus_into};
pub use energy::{angular_momentum, center_of_mass, kinetic_energy, linear_momentum, potential_energy, total_mass};
pub use equality::{EqualityBlock, equality_block_into, equality_violations, polynomial_at};
pub use forward_dynamics::{ArticulatedBodies, forward_dynamics_into};
pub use frame::{
    AxisRates, Frame, ReferenceFrame, axis_rates_into, frame_bias_acceleration, frame_jacobian_into,
    frame_jacobian_rate_into, frame_velocity,
};
pub use free_motion::{FreeMotion, FreeMotionError, Saturation, free_motion_beside, free_motion_into};
pub use inverse_dynamics::{NewtonEuler, bias_force_into, inverse_dynamics_into};
pub use inverse_kinematics::{
    FrameTarget, InverseKinematicsReport, InverseKinematicsSettings, inverse_kinematics_into,
};
pub use jacobian::{
    JacobianRows, add_wrench, angular_jacobian_into, angular_rows_into, contact_rows_into, point_column,
    point_jacobian_into, point_rows_into, spin_rows_into,
};
pub use kinematics::{Kinematics, body_velocities_into, forward_kinematics_beside, forward_kinematics_into};
pub use layout::Block;
pub use length::LengthRow;
pub use mass::{BlockDiagonal, MassError};
pub use math::{Pose, right_jacobian, rotation_exp, rotation_log, unit_rotation, unit_vector};
pub use model::{
    Activation, ActivationKind, Actuator, ActuatorId, ActuatorKind, Body, BodyId, Camera, CameraId, CameraMode,
    ChangedRow, Checker, ContactFilter, ContactReduction, ContactSensor, ContactSide, Effect, Equality, EqualityKind,
    FrameId, Geom, GeomId, GeomPair, Geometry, Image, Inertia, Joint, JointId, JointKind, Keyframe, Light, Look, Model,
    ModelBuilder, ModelError, Muscle, NewBody, Parameter, ParameterChange, PathPart, Sensor, SensorKind, Shapes, Site,
    SiteId, SpinResistance, Spread, Tendon, TendonId, Texture, Transmission,
};
pub use moving::MovingBodies;
pub use operational::operational_space_inertia;
pub use outline::convex_outline;
pub use sensors::{MovingFrame, moving_frame, state_sensors_into};
pub use spatial::SpatialVector;
pub use standing::StandingTrees;
pub use state::{ContactPoint, Input, State, StateError};
pub use subtree::{subtree_center_of_mass, subtree_jacobian_into, subtree_jacobian_rate_into};
pub use tendon::tendon_length_into;

/// The vector library of the public interface, re-exported so that users have the same types.
pub use glamx::glam;
