//! What changes: the state, what is applied, and the contact points found at a state.

use glamx::glam::DVec3;

use crate::model::{BodyId, GeomId, Model};

/// The state of a model: time, configuration, generalized velocity, and nothing else.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Time, s.
    pub time: f64,
    /// Configuration `q`, `[nq]` (m, rad, unit quaternions w x y z), in joint order.
    pub q: Vec<f64>,
    /// Generalized velocity `v`, `[nv]` (m/s, rad/s), in joint order.
    pub v: Vec<f64>,
}

impl State {
    /// The model's reference configuration at rest at time 0.
    pub fn new(model: &Model) -> Self {
        Self { time: 0.0, q: model.reference_configuration(), v: vec![0.0; model.nv] }
    }
}

/// What acts on a model during a step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Input {
    /// One value per actuator, `[actuators]`: N or N·m for motors, m or rad for position servos, m/s or rad/s for
    /// velocity servos. Empty means all zero.
    pub control: Vec<f64>,
    /// Applied generalized force `τ`, `[nv]` (N, N·m). Empty means zero.
    pub generalized_force: Vec<f64>,
}

/// A place where two geoms touch or could touch within the step (formulation §1).
///
/// The normal points from body A to body B; a positive normal impulse pushes the bodies apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPoint {
    /// Geom on the A side.
    pub geom_a: GeomId,
    /// Geom on the B side.
    pub geom_b: GeomId,
    /// Body that carries `geom_a`.
    pub body_a: BodyId,
    /// Body that carries `geom_b`.
    pub body_b: BodyId,
    /// Contact point in world, midway between the two surfaces, m.
    pub position: DVec3,
    /// Unit normal from A to B in world.
    pub normal: DVec3,
    /// Gap φ: signed distance of the surfaces along the normal, m; negative when penetrating.
    pub gap: f64,
    /// Coefficient of friction μ of this pair; 0 is frictionless.
    pub friction: f64,
    /// Which features of the two geoms touch: stable from step to step while the same vertices, edges or faces meet,
    /// unique within the pair of geoms. Warm starts are carried by (geom_a, geom_b, feature).
    pub feature: u32,
}
