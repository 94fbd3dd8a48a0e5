//! What a batch can tell of each of its simulations after a step.

use pyo3::prelude::*;
use signorini::multibody::Model;
use signorini::{Simulation, contact_wrenches_into};

use crate::error::ProblemError;

/// A quantity with a row of numbers per simulation.
#[derive(Clone, Copy)]
pub enum Quantity {
    Qpos,
    Qvel,
    Act,
    SensorData,
    ContactWrench,
    Residual,
}

impl Quantity {
    const NAMES: [(&'static str, Self); 6] = [
        ("qpos", Self::Qpos),
        ("qvel", Self::Qvel),
        ("act", Self::Act),
        ("sensordata", Self::SensorData),
        ("contact_wrench", Self::ContactWrench),
        ("residual", Self::Residual),
    ];

    /// The one of this name.
    pub fn named(name: &str) -> PyResult<Self> {
        Self::NAMES.iter().find(|(n, _)| *n == name).map(|&(_, quantity)| quantity).ok_or_else(|| {
            let known = Self::NAMES.map(|(n, _)| format!("'{n}'")).join(", ");
            ProblemError::new_err(format!("record = '{name}': must be of {known}"))
        })
    }

    /// Axes of its numbers for one simulation.
    pub fn shape(self, model: &Model) -> Vec<usize> {
        match self {
            Self::Qpos => vec![model.nq],
            Self::Qvel => vec![model.nv],
            Self::Act => vec![model.na],
            Self::SensorData => vec![model.sensor_size],
            Self::ContactWrench => vec![model.bodies.len(), 6],
            Self::Residual => vec![],
        }
    }

    /// How many numbers that are.
    pub fn size(self, model: &Model) -> usize {
        self.shape(model).iter().product()
    }

    /// Its numbers after a step.
    pub fn write(self, simulation: &mut Simulation, out: &mut [f64]) {
        match self {
            Self::Qpos => out.copy_from_slice(&simulation.state().q),
            Self::Qvel => out.copy_from_slice(&simulation.state().v),
            Self::Act => out.copy_from_slice(&simulation.state().activation),
            Self::SensorData => out.copy_from_slice(simulation.sensors()),
            Self::ContactWrench => contact_wrenches_into(simulation.workspace(), out),
            Self::Residual => out[0] = simulation.report().certificate.worst(),
        }
    }
}
