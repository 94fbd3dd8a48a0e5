//! `signorini.Settings` (a Python dataclass) as settings of the engine.

use pyo3::prelude::*;
use signorini::contact::SolverSettings;
use signorini::lcp::MethodKind;
use signorini::{ContactMethod, InfeasiblePolicy, Settings};

use crate::error::{SettingError, lcp_error, simulation_error};

/// The fields of the dataclass.
#[derive(FromPyObject)]
pub struct PySettings {
    timestep: Option<f64>,
    directions: usize,
    direction_angle: f64,
    stabilization: f64,
    tolerance: f64,
    method: String,
    infeasible: String,
}

impl PySettings {
    /// The engine's settings, checked.
    pub fn to_settings(&self) -> PyResult<Settings> {
        let settings = Settings {
            timestep: self.timestep,
            directions: self.directions,
            direction_angle: self.direction_angle,
            stabilization: self.stabilization,
            tolerance: self.tolerance,
            method: contact_method(&self.method, self.tolerance)?,
            infeasible: match self.infeasible.as_str() {
                "stop" => InfeasiblePolicy::Stop,
                "clip_gaps" => InfeasiblePolicy::ClipGaps,
                other => {
                    let message = format!("infeasible = '{other}': must be 'stop' or 'clip_gaps'");
                    return Err(SettingError::new_err(message));
                }
            },
            ..Settings::default()
        };
        settings.validate().map_err(simulation_error)?;
        Ok(settings)
    }
}

/// "structured", or the name of a method of `signorini-lcp`.
pub fn contact_method(name: &str, tolerance: f64) -> PyResult<ContactMethod> {
    match name {
        "structured" => Ok(ContactMethod::Structured(SolverSettings { tolerance, ..SolverSettings::default() })),
        _ => name.parse::<MethodKind>().map(ContactMethod::Lcp).map_err(|e| {
            let message = lcp_error(e).to_string();
            SettingError::new_err(format!("{message}, structured").replace("SettingError: ", ""))
        }),
    }
}
