//! The functions that move a `Data`.

use std::ops::ControlFlow;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use signorini::multibody::{self as mb, GeomId};
use signorini::{ContactSource, SettleSettings, SimulationError};

use crate::core::{Core, Stop};
use crate::counts;
use crate::data::Data;
use crate::error::{SolveError, recording_error, simulation_error};
use crate::guard;
use crate::model::Model;
use crate::report::{SettleReport, contacts_of, status_of};

/// Checks that a data belongs to a model.
pub fn check_model(model: &Bound<'_, Model>, data: &Bound<'_, Data>) -> PyResult<()> {
    if model.is(data.get().model.bind(data.py())) {
        return Ok(());
    }
    Err(PyValueError::new_err("data belongs to another model: pass data.model"))
}

/// Makes `nstep` steps; the GIL is released meanwhile.
#[pyfunction]
#[pyo3(signature = (model, data, nstep=1))]
pub fn step(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    data: &Bound<'_, Data>,
    #[pyo3(from_py_with = counts::nstep)] nstep: u64,
) -> PyResult<()> {
    check_model(model, data)?;
    let data = data.get();
    let mut guard = data.loaded(py)?;
    let core = &mut *guard;
    let missed = core.missed_steps;
    let mut left = nstep;
    let mut outcome = Ok(());
    loop {
        let stop = guard::detached(py, || {
            let end = core.run(&mut left);
            core.update_kinematics();
            end
        })?;
        match stop {
            Err(Stop::Slice) => {
                outcome = py.check_signals();
                if outcome.is_ok() {
                    continue;
                }
            }
            Err(Stop::NoSolution) => outcome = Err(no_solution(core)),
            Err(Stop::Simulation(error)) => outcome = Err(simulation_error(error)),
            Err(Stop::Recording(error)) => outcome = Err(recording_error(error)),
            Ok(()) => {}
        }
        break;
    }
    if left < nstep {
        data.live.write(py, |live| {
            live.state(core);
            live.kinematics(core);
            live.acceleration(&core.state.v, &core.other.v, core.timestep());
        })?;
    }
    let note = core.start_note.take();
    let count = core.missed_steps - missed;
    drop(guard);
    if let Some(note) = note {
        warn(py, "OverlapWarning", note)?;
    }
    if count > 0 {
        let steps = if count == 1 { "step" } else { "steps" };
        let more = "data.certificate and data.missed_steps say more";
        warn(py, "ToleranceWarning", format!("{count} {steps} missed the tolerance; {more}"))?;
    }
    outcome
}

/// Issues a warning of the package.
fn warn(py: Python<'_>, category: &str, message: String) -> PyResult<()> {
    let category = py.import("signorini.errors")?.getattr(category)?;
    py.import("warnings")?.call_method1("warn", (message, category, 1)).map(|_| ())
}

fn no_solution(core: &Core) -> PyErr {
    let status = status_of(&core.report.status);
    let contacts = contacts_of(&core.report.status).to_vec();
    let sources = contacts.iter().filter_map(|&i| core.workspace.contact_source(i));
    let names: Vec<String> = sources.map(|source| describe(&core.model, source)).collect();
    let end = if status == "infeasible" { "has no solution" } else { "was not solved" };
    let message = format!(
        "the contact problem at t = {} s {end} ({status}); the state is the one before the step; \
         contacts that contradict each other: {}",
        core.state.time,
        if names.is_empty() { "not known".to_owned() } else { names.join(", ") }
    );
    SolveError::new_err((message, status, contacts, core.state.time))
}

fn describe(model: &mb::Model, source: ContactSource) -> String {
    let side = |upper| if upper { "upper" } else { "lower" };
    match source {
        ContactSource::Point(p) => {
            let name = |g: GeomId| model.geoms[g.index()].name.as_str();
            format!("'{}' on '{}' (gap {:.1e} m)", name(p.geom_b), name(p.geom_a), p.gap)
        }
        ContactSource::Limit { joint, upper } => {
            format!("{} limit of '{}'", side(upper), model.joints[joint.index()].name)
        }
        ContactSource::TendonLimit { tendon, upper } => {
            format!("{} limit of tendon '{}'", side(upper), model.tendons[tendon.index()].name)
        }
    }
}

/// Brings the state to rest; the GIL is released meanwhile, and signals are looked for after every step.
#[pyfunction]
#[pyo3(signature = (model, data, *, max_steps=2000, timestep=None, momentum=0.5))]
pub fn settle(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    data: &Bound<'_, Data>,
    #[pyo3(from_py_with = counts::max_steps)] max_steps: u32,
    timestep: Option<f64>,
    momentum: f64,
) -> PyResult<SettleReport> {
    check_model(model, data)?;
    let data = data.get();
    let mut guard = data.loaded(py)?;
    let core = &mut *guard;
    let mut signal = Ok(());
    let settled = guard::detached(py, || {
        core.settle(
            &SettleSettings::default().with_max_steps(max_steps).with_timestep(timestep).with_momentum(momentum),
            |_| {
                signal = Python::attach(|py| py.check_signals());
                if signal.is_ok() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
            },
        )
    })?;
    if matches!(settled, Ok(_) | Err(SimulationError::NotSettled { .. })) {
        data.live.write(py, |live| {
            live.state(core);
            live.kinematics(core);
            live.acceleration(&core.other.v, &core.state.v, core.timestep());
        })?;
    }
    signal?;
    Ok(SettleReport::new(&settled.map_err(simulation_error)?))
}

/// Solves the step from the present state without making it.
#[pyfunction]
pub fn forward(py: Python<'_>, model: &Bound<'_, Model>, data: &Bound<'_, Data>) -> PyResult<()> {
    check_model(model, data)?;
    let data = data.get();
    let mut guard = data.loaded(py)?;
    let core = &mut *guard;
    let end = guard::detached(py, || core.preview())?;
    end.map_err(simulation_error)?;
    data.live.write(py, |live| {
        live.kinematics(core);
        live.acceleration(&core.other.v, &core.state.v, core.timestep());
    })?;
    if core.report.advanced() { Ok(()) } else { Err(no_solution(core)) }
}

/// Updates poses and velocities of the bodies after qpos or qvel was written to.
#[pyfunction]
pub fn kinematics(py: Python<'_>, model: &Bound<'_, Model>, data: &Bound<'_, Data>) -> PyResult<()> {
    check_model(model, data)?;
    let data = data.get();
    let mut core = data.loaded(py)?;
    core.update_kinematics();
    data.live.write(py, |live| live.kinematics(&core))
}
