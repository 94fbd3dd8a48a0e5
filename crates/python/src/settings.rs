//! `signorini.Settings` (a Python dataclass) as settings of the engine.

use pyo3::exceptions::{PyOverflowError, PyTypeError};
use pyo3::prelude::*;
use signorini::contact::SolverSettings;
use signorini::lcp::MethodKind;
use signorini::{ContactMethod, FrictionLaw, ImpulseChoice, InfeasiblePolicy, OverlapPolicy, RestitutionLaw, Settings};

use crate::error::{SettingError, lcp_error};

/// The dataclass.
pub struct PySettings(Fields);

impl<'a, 'py> FromPyObject<'a, 'py> for PySettings {
    type Error = PyErr;

    fn extract(given: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        given.extract().map(Self).map_err(|error| of_field(given.py(), error))
    }
}

/// The error of a field with its name, where PyO3 leaves the reason to the cause of an error that names a type of this file.
fn of_field(py: Python<'_>, error: PyErr) -> PyErr {
    let (mut path, mut error) = (String::from("settings"), error);
    loop {
        let message = error.value(py).to_string();
        let field = message.strip_prefix("failed to extract field ").and_then(|place| place.split('.').nth(1));
        let (Some(field), Some(cause)) = (field, error.cause(py)) else { break };
        path += &format!(".{field}");
        error = cause;
    }
    let message = format!("{path}: {}", error.value(py));
    if error.is_instance_of::<PyOverflowError>(py) {
        SettingError::new_err(message)
    } else {
        PyTypeError::new_err(message)
    }
}

/// Its fields.
#[derive(FromPyObject)]
struct Fields {
    timestep: Option<f64>,
    directions: usize,
    direction_angle: f64,
    contact_points: usize,
    stabilization: f64,
    gap_resolution: f64,
    correction_speed: f64,
    correction_angular_speed: f64,
    tolerance: f64,
    budget: Option<u32>,
    method: String,
    infeasible: String,
    overlaps: String,
    friction_law: String,
    cone_tolerance: f64,
    impulses: String,
    restitution: String,
    position_iterations: u32,
    assembly_tolerance: f64,
    sleeping: Option<bool>,
    solver: PySolverSettings,
}

/// The fields of the dataclass `SolverSettings`.
#[derive(FromPyObject)]
struct PySolverSettings {
    polish: f64,
    proximal_weight: f64,
    smallest_proximal_weight: f64,
    mode_tolerance: f64,
    newton_iterations: u32,
    max_rounds: u32,
    max_proximal_iterations: u32,
    path_changes_base: u32,
    path_changes_per_violation: u32,
    path_changes_per_contact: u32,
    lemke_pivots_per_row: usize,
    lemke_max_rows: usize,
    threads: usize,
    time_stages: bool,
}

impl PySettings {
    /// The engine's settings, checked.
    pub fn to_settings(&self) -> PyResult<Settings> {
        self.0.to_settings()
    }
}

impl Fields {
    fn to_settings(&self) -> PyResult<Settings> {
        let settings = Settings::default()
            .with_timestep(self.timestep)
            .with_directions(self.directions)
            .with_direction_angle(self.direction_angle)
            .with_contact_points(self.contact_points)
            .with_stabilization(self.stabilization)
            .with_gap_resolution(self.gap_resolution)
            .with_correction_speed(self.correction_speed)
            .with_correction_angular_speed(self.correction_angular_speed)
            .with_position_iterations(self.position_iterations)
            .with_assembly_tolerance(self.assembly_tolerance)
            .with_restitution(choose(
                "restitution",
                &self.restitution,
                &[("newton", RestitutionLaw::Newton), ("poisson", RestitutionLaw::Poisson)],
            )?)
            .with_tolerance(self.tolerance)
            .with_budget(self.budget)
            .with_friction_law(choose(
                "friction_law",
                &self.friction_law,
                &[
                    ("polygon", FrictionLaw::Polygon),
                    ("circular", FrictionLaw::Circular),
                    ("refined", FrictionLaw::Refined { tolerance: self.cone_tolerance }),
                ],
            )?)
            .with_impulses(choose(
                "impulses",
                &self.impulses,
                &[("solver", ImpulseChoice::Solver), ("least_norm", ImpulseChoice::LeastNorm)],
            )?)
            .with_method(match contact_method(&self.method, self.tolerance)? {
                ContactMethod::Structured(_) => ContactMethod::Structured(self.solver.to_settings(self.tolerance)),
                lcp => lcp,
            })
            .with_sleeping(self.sleeping)
            .with_infeasible(choose(
                "infeasible",
                &self.infeasible,
                &[
                    ("go_on", InfeasiblePolicy::GoOn),
                    ("stop", InfeasiblePolicy::Stop),
                    ("clip_gaps", InfeasiblePolicy::ClipGaps),
                ],
            )?)
            .with_overlaps(choose(
                "overlaps",
                &self.overlaps,
                &[("exclude", OverlapPolicy::Exclude), ("keep", OverlapPolicy::Keep), ("stop", OverlapPolicy::Stop)],
            )?);
        settings.validate().map_err(|error| SettingError::new_err(error.to_string()))?;
        Ok(settings)
    }
}

impl PySolverSettings {
    fn to_settings(&self, tolerance: f64) -> SolverSettings {
        SolverSettings::default()
            .with_tolerance(tolerance)
            .with_polish(self.polish)
            .with_proximal_weight(self.proximal_weight)
            .with_smallest_proximal_weight(self.smallest_proximal_weight)
            .with_mode_tolerance(self.mode_tolerance)
            .with_newton_iterations(self.newton_iterations)
            .with_max_rounds(self.max_rounds)
            .with_max_proximal_iterations(self.max_proximal_iterations)
            .with_path_changes_base(self.path_changes_base)
            .with_path_changes_per_violation(self.path_changes_per_violation)
            .with_path_changes_per_contact(self.path_changes_per_contact)
            .with_lemke_pivots_per_row(self.lemke_pivots_per_row)
            .with_lemke_max_rows(self.lemke_max_rows)
            .with_threads(self.threads)
            .with_time_stages(self.time_stages)
    }
}

/// The value of this name.
fn choose<T: Copy>(setting: &str, name: &str, values: &[(&str, T)]) -> PyResult<T> {
    values.iter().find(|(known, _)| *known == name).map(|(_, value)| *value).ok_or_else(|| {
        let known = values.iter().map(|(known, _)| format!("'{known}'")).collect::<Vec<_>>().join(" or ");
        SettingError::new_err(format!("{setting} = '{name}': must be {known}"))
    })
}

/// "structured", or the name of a method of `signorini-lcp`.
pub fn contact_method(name: &str, tolerance: f64) -> PyResult<ContactMethod> {
    match name {
        "structured" => Ok(ContactMethod::Structured(SolverSettings::default().for_tolerance(tolerance))),
        _ => name.parse::<MethodKind>().map(ContactMethod::Lcp).map_err(|e| {
            let message = lcp_error(e).to_string();
            SettingError::new_err(format!("{message}, structured").replace("SettingError: ", ""))
        }),
    }
}
