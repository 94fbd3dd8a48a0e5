//! The derivatives of a step's momentum balance, as data.

use super::coriolis::CoriolisTerms;
use super::curvature::LengthCurvature;
use super::drive::MarginSource;
use super::inverse_dynamics::InverseDynamicsDerivatives;
use crate::model::Model;
use crate::spatial::SpatialVector;

/// A part of a model without derivatives.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{part} has no derivative: {reason}")]
pub struct Unsupported {
    /// Which part.
    pub part: String,
    /// Why.
    pub reason: &'static str,
}

/// `E(v⁺; q, v, u) = M̂ (v⁺ − v) − Δt (…)`, the impulse that contacts and constraints have to give for a step to end with `v⁺`, and its
/// derivatives at fixed `v⁺`. That by `v⁺` is `M̂`.
#[derive(Clone, Debug)]
pub struct BalanceDerivatives {
    /// `E`, `[nv]`, N·s, N·m·s, less the impulses from outside.
    pub impulse: Vec<f64>,
    /// `∂E/∂q` in tangent coordinates, where the impulses from outside turn with their bodies, `[nv, nv]` row by row.
    pub by_configuration: Vec<f64>,
    /// `∂E/∂v`, `[nv, nv]` row by row.
    pub by_velocity: Vec<f64>,
    /// `∂E/∂u`, `[nv, nu]` row by row.
    pub by_control: Vec<f64>,
    /// `∂E/∂τ` by the applied force, `[nv, nv]` row by row: `−Δt`, where no trees turn.
    pub by_force: Vec<f64>,
    /// `∂E` by what the force laws of actuators take as their control, `[nv, nu]` row by row.
    pub(super) by_drive: Vec<f64>,
    /// How that changes with the activation of each actuator, `[nu]`; 0 for one without.
    pub(super) activation_share: Vec<f64>,
    /// How far each inequality is from turning, relative to its range: what is 0 has two one-sided derivatives.
    pub margins: Vec<(MarginSource, f64)>,
    /// Inverse dynamics of the step's mean acceleration.
    pub dynamics: InverseDynamicsDerivatives,
    pub(super) acceleration: Vec<f64>,
    pub(super) wrenches: Vec<SpatialVector>,
    pub(super) lengths: LengthCurvature,
    /// Whether trees turn, so that the motion without contact has Coriolis forces at its end.
    pub(super) turns: bool,
    /// What they do then, and the balance at the velocity at the end of that motion with nothing from outside.
    pub(super) coriolis: Option<Box<CoriolisTerms>>,
    pub(super) at_end: Option<Box<BalanceDerivatives>>,
}

impl BalanceDerivatives {
    /// Storage for a model.
    pub fn new(model: &Model) -> Self {
        let (nv, nu) = (model.nv, model.actuators.len());
        Self {
            impulse: vec![0.0; nv],
            by_configuration: vec![0.0; nv * nv],
            by_velocity: vec![0.0; nv * nv],
            by_control: vec![0.0; nv * nu],
            by_force: vec![0.0; nv * nv],
            by_drive: vec![0.0; nv * nu],
            activation_share: vec![0.0; nu],
            margins: Vec::new(),
            dynamics: InverseDynamicsDerivatives::new(model),
            acceleration: vec![0.0; nv],
            wrenches: vec![SpatialVector::ZERO; model.bodies.len()],
            lengths: LengthCurvature::default(),
            turns: false,
            coriolis: None,
            at_end: None,
        }
    }

    /// What Coriolis forces at the end of the motion without contact add, where trees turn, and the balance there.
    pub(super) fn free_end(&self) -> Option<(&CoriolisTerms, &BalanceDerivatives)> {
        self.coriolis.as_deref().zip(self.at_end.as_deref()).filter(|_| self.turns)
    }

    pub(super) fn add(matrix: &mut [f64], nv: usize, row: usize, column: usize, value: f64) {
        matrix[row * nv + column] += value;
    }
}
