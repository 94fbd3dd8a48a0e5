//! What changes: the state, what is applied, and the contact points found at a state.

use derive_setters::Setters;
use glamx::glam::DVec3;

use crate::math::Pose;
use crate::model::{Actuator, BodyId, GeomId, Joint, JointKind, Model};
use crate::spatial::SpatialVector;

/// A state or input that does not fit its model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StateError {
    /// A list with the wrong number of entries.
    #[error("{quantity} has {found} entries, the model needs {expected}")]
    WrongLength {
        /// Which list.
        quantity: &'static str,
        /// How many the model needs.
        expected: usize,
        /// How many there are.
        found: usize,
    },
    /// A number that is not finite.
    #[error("{quantity}[{index}] ({part}) is {found}: it must be finite")]
    NotFinite {
        /// Which list.
        quantity: &'static str,
        /// Where in the list.
        index: usize,
        /// The joint or actuator it belongs to.
        part: String,
        /// What it is.
        found: f64,
    },
    /// An orientation that is not a unit quaternion.
    #[error("the quaternion of joint '{joint}' has norm {norm}: it must be 1 within 1e-6; normalise it")]
    NotUnitQuaternion {
        /// The joint.
        joint: String,
        /// Its norm.
        norm: f64,
    },
    /// A time step that is not positive and finite.
    #[error("the time step is {found} s: it must be positive and finite")]
    InvalidTimeStep {
        /// What it is.
        found: f64,
    },
}

/// The state of a model: time, configuration, generalized velocity, activations of actuators, and nothing else.
#[derive(Clone, Debug, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct State {
    /// Time, s.
    pub time: f64,
    /// Configuration `q`, `[nq]` (m, rad, unit quaternions w x y z), in joint order.
    pub q: Vec<f64>,
    /// Generalized velocity `v`, `[nv]` (m/s, rad/s), in joint order.
    pub v: Vec<f64>,
    /// Activations, `[na]`, of the actuators that have one, in their order.
    pub activation: Vec<f64>,
}

impl State {
    /// The model's reference configuration at rest at time 0, activations at zero.
    pub fn new(model: &Model) -> Self {
        let (q, v) = (model.reference_configuration(), vec![0.0; model.nv]);
        Self { time: 0.0, q, v, activation: vec![0.0; model.na] }
    }

    /// A configuration and a velocity at time 0, without activations.
    pub fn at(q: Vec<f64>, v: Vec<f64>) -> Self {
        Self { time: 0.0, q, v, activation: Vec::new() }
    }

    /// Whether configuration and velocity are finite numbers.
    pub fn is_finite(&self) -> bool {
        all_finite(&self.q) && all_finite(&self.v)
    }

    /// Whether the state fits the model: lengths, finite numbers, unit quaternions (within 1e-6).
    ///
    /// # Errors
    /// The first [`StateError`], naming the joint.
    pub fn check(&self, model: &Model) -> Result<(), StateError> {
        check_length("q", &self.q, model.nq)?;
        check_length("v", &self.v, model.nv)?;
        check_length("activation", &self.activation, model.na)?;
        if !self.time.is_finite() {
            return Err(StateError::NotFinite { quantity: "time", index: 0, part: "state".into(), found: self.time });
        }
        if !all_finite(&self.activation) {
            let with_memory = model.actuators.iter().filter(|actuator| actuator.activation.is_some());
            for (index, (&found, actuator)) in self.activation.iter().zip(with_memory).enumerate() {
                if !found.is_finite() {
                    let part = format!("actuator '{}'", actuator.name);
                    return Err(StateError::NotFinite { quantity: "activation", index, part, found });
                }
            }
        }
        let finite = self.is_finite();
        for joint in &model.joints {
            if !finite {
                check_entries("q", &self.q, joint.q_index, joint.kind.nq(), joint)?;
                check_entries("v", &self.v, joint.v_index, joint.kind.nv(), joint)?;
            }
            let start = match joint.kind {
                JointKind::Free => joint.q_index + 3,
                JointKind::Ball => joint.q_index,
                JointKind::Hinge { .. } | JointKind::Slide { .. } => continue,
            };
            let norm = self.q[start..start + 4].iter().map(|x| x * x).sum::<f64>().sqrt();
            if (norm - 1.0).abs() > 1e-6 {
                return Err(StateError::NotUnitQuaternion { joint: joint.name.clone(), norm });
            }
        }
        Ok(())
    }
}

fn check_length(quantity: &'static str, values: &[f64], expected: usize) -> Result<(), StateError> {
    if values.len() == expected {
        return Ok(());
    }
    Err(StateError::WrongLength { quantity, expected, found: values.len() })
}

/// Whether every number is finite: zero times any other is not zero.
fn all_finite(values: &[f64]) -> bool {
    let (pairs, rest) = values.as_chunks::<2>();
    let mut sums = [0.0; 2];
    for pair in pairs {
        (0..2).for_each(|l| sums[l] += 0.0 * pair[l]);
    }
    sums[0] + sums[1] + rest.iter().map(|x| 0.0 * x).sum::<f64>() == 0.0
}

fn check_entries(
    quantity: &'static str,
    values: &[f64],
    start: usize,
    count: usize,
    joint: &Joint,
) -> Result<(), StateError> {
    match (start..start + count).find(|&i| !values[i].is_finite()) {
        None => Ok(()),
        Some(index) => {
            let part = format!("joint '{}'", joint.name);
            Err(StateError::NotFinite { quantity, index, part, found: values[index] })
        }
    }
}

/// What acts on a model during a step.
#[derive(Clone, Debug, Default, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct Input {
    /// One value per actuator, `[actuators]`: N or N·m for motors, m or rad for position servos, m/s or rad/s for
    /// velocity servos and servos of speed. Empty means all zero.
    pub control: Vec<f64>,
    /// Applied generalized force `τ`, `[nv]` (N, N·m). Empty means zero.
    pub generalized_force: Vec<f64>,
    /// Wrenches applied to the bodies at their centres of mass, `[bodies]`, world axes: moment (N·m) and force (N), constant during the
    /// step. Empty means none. That of the world does nothing.
    pub wrench: Vec<SpatialVector>,
    /// Poses `X_WB` of the bodies that are moved from outside, `[mocap_bodies]` (m, unit quaternions). They stand there during the step.
    /// Empty means each where the model places it.
    pub mocap: Vec<Pose>,
}

impl Input {
    /// Nothing but these control values.
    pub fn of_control(control: Vec<f64>) -> Self {
        Self { control, ..Self::default() }
    }

    /// Nothing but this generalized force.
    pub fn of_force(generalized_force: Vec<f64>) -> Self {
        Self { generalized_force, ..Self::default() }
    }

    /// Whether the input fits the model: lengths (or empty) and finite numbers.
    ///
    /// # Errors
    /// The first [`StateError`], naming the actuator or joint.
    pub fn check(&self, model: &Model) -> Result<(), StateError> {
        if !self.control.is_empty() {
            check_length("control", &self.control, model.actuators.len())?;
        }
        if !self.generalized_force.is_empty() {
            check_length("generalized force", &self.generalized_force, model.nv)?;
            if !all_finite(&self.generalized_force) {
                for joint in &model.joints {
                    check_entries("generalized force", &self.generalized_force, joint.v_index, joint.kind.nv(), joint)?;
                }
            }
        }
        self.check_wrenches(model)?;
        self.check_mocap(model)?;
        match self.control.iter().position(|u| !u.is_finite()) {
            None => Ok(()),
            Some(index) => {
                let part = format!("actuator '{}'", model.actuators[index].name);
                Err(StateError::NotFinite { quantity: "control", index, part, found: self.control[index] })
            }
        }
    }
}

impl Input {
    fn check_wrenches(&self, model: &Model) -> Result<(), StateError> {
        let (expected, found) = (model.bodies.len(), self.wrench.len());
        if found != 0 && found != expected {
            return Err(StateError::WrongLength { quantity: "wrench", expected, found });
        }
        for (index, wrench) in self.wrench.iter().enumerate() {
            if let Some(found) = wrench.to_array().into_iter().find(|x| !x.is_finite()) {
                let part = format!("body '{}'", model.bodies[index].name);
                return Err(StateError::NotFinite { quantity: "wrench", index, part, found });
            }
        }
        Ok(())
    }

    fn check_mocap(&self, model: &Model) -> Result<(), StateError> {
        if self.mocap.is_empty() {
            return Ok(());
        }
        let (expected, found) = (model.mocap_bodies.len(), self.mocap.len());
        if found != expected {
            return Err(StateError::WrongLength { quantity: "mocap", expected, found });
        }
        for (index, (pose, body)) in self.mocap.iter().zip(&model.mocap_bodies).enumerate() {
            let part = || format!("body '{}'", model.bodies[body.index()].name);
            let numbers = pose.position.to_array().into_iter().chain(pose.rotation.to_array());
            if let Some(found) = numbers.into_iter().find(|x| !x.is_finite()) {
                return Err(StateError::NotFinite { quantity: "mocap", index, part: part(), found });
            }
            let norm = pose.rotation.length();
            if norm < 1e-12 {
                return Err(StateError::NotUnitQuaternion { joint: part(), norm });
            }
        }
        Ok(())
    }
}

impl Actuator {
    /// The control value of this actuator, the model's number `index`, clamped to its range.
    pub fn control(&self, input: &Input, index: usize) -> f64 {
        let value = *input.control.get(index).unwrap_or(&0.0);
        self.control_range.map_or(value, |[lower, upper]| value.clamp(lower, upper))
    }
}

/// A place where two geoms touch or could touch within the step (formulation §1).
///
/// The normal points from body A to body B; a positive normal impulse pushes the bodies apart.
#[derive(Clone, Copy, Debug, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct ContactPoint {
    /// Geom on the A side.
    pub geom_a: GeomId,
    /// Geom on the B side.
    pub geom_b: GeomId,
    /// Body that carries `geom_a`.
    pub body_a: BodyId,
    /// Body that carries `geom_b`.
    pub body_b: BodyId,
    /// Contact point in world, midway between the two surfaces, m; in a step's problem the points of a flat patch are at the mean of their heights.
    pub position: DVec3,
    /// Unit normal from A to B in world.
    pub normal: DVec3,
    /// Gap φ: signed distance of the surfaces along the normal less the pair's margin, m; negative when penetrating.
    pub gap: f64,
    /// Coefficient of friction μ of this pair; 0 is frictionless.
    pub friction: f64,
    /// Which features of the two geoms touch: stable from step to step while the same vertices, edges or faces meet,
    /// unique within the pair of geoms. Warm starts are carried by (geom_a, geom_b, feature).
    pub feature: u32,
}

impl ContactPoint {
    /// A frictionless point between two geoms that touch there, the only one of its pair.
    pub fn new([geom_a, geom_b]: [GeomId; 2], [body_a, body_b]: [BodyId; 2], position: DVec3, normal: DVec3) -> Self {
        Self { geom_a, geom_b, body_a, body_b, position, normal, gap: 0.0, friction: 0.0, feature: 0 }
    }
}
