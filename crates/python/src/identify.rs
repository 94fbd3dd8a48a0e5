//! Parameters from recordings.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use signorini::derivatives::identification::{
    Identification as Found, IdentificationError, IdentificationSettings, Recording, Unknown, identify,
};
use signorini::multibody::{Input, State};

use crate::arrays::{self, Table, Vector};
use crate::counts;
use crate::directions::direction_of;
use crate::error::simulation_error;
use crate::guard;
use crate::model::Model;
use crate::settings::PySettings;

/// Samples of a recording: qpos (n, nq), qvel (n, nv), ctrl (n − 1, nu) or none, act (n, na) or none.
type Samples<'py> = (Bound<'py, PyAny>, Bound<'py, PyAny>, Option<Bound<'py, PyAny>>, Option<Bound<'py, PyAny>>);
/// Name, parameter, bounds, value and deviation known before.
type Asked<'py> = (String, Bound<'py, PyAny>, [f64; 2], Option<[f64; 2]>);

/// What was found.
#[pyclass(frozen, module = "signorini._core")]
pub struct IdentifiedValues {
    found: Found,
}

#[pymethods]
impl IdentifiedValues {
    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> Vector<'py> {
        arrays::vector(py, &self.found.values)
    }

    #[getter]
    fn covariance<'py>(&self, py: Python<'py>) -> PyResult<Table<'py>> {
        let n = self.found.values.len();
        arrays::matrix(py, self.found.covariance.clone(), n, n)
    }

    #[getter]
    fn determined(&self) -> Vec<bool> {
        self.found.determined.clone()
    }

    #[getter]
    fn at_bound(&self) -> Vec<bool> {
        self.found.at_bound.clone()
    }

    #[getter]
    fn objective(&self) -> (f64, f64) {
        self.found.objective.into()
    }

    #[getter]
    fn deviation(&self) -> f64 {
        self.found.deviation
    }

    #[getter]
    fn iterations(&self) -> usize {
        self.found.iterations
    }

    #[getter]
    fn converged(&self) -> bool {
        self.found.converged
    }

    #[getter]
    fn steps(&self) -> (usize, usize) {
        self.found.steps.into()
    }
}

/// Looks for parameters; `progress` gets iteration, objective and values, and ends it with `False`.
#[pyfunction]
#[pyo3(signature = (model, recordings, unknowns, settings, interval, substeps, window, weights, outlier, equal_recordings, starts, draws, iterations, tolerance, progress))]
#[expect(clippy::too_many_arguments, reason = "they are keywords in Python")]
pub fn identify_parameters(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    recordings: Vec<Samples<'_>>,
    unknowns: Vec<Asked<'_>>,
    settings: PySettings,
    interval: f64,
    #[pyo3(from_py_with = counts::substeps)] substeps: usize,
    #[pyo3(from_py_with = counts::window)] window: usize,
    weights: Vec<f64>,
    outlier: f64,
    equal_recordings: bool,
    #[pyo3(from_py_with = counts::starts)] starts: usize,
    #[pyo3(from_py_with = counts::draws)] draws: usize,
    #[pyo3(from_py_with = counts::iterations)] iterations: usize,
    tolerance: f64,
    progress: Option<Py<PyAny>>,
) -> PyResult<IdentifiedValues> {
    let inner = model.get().inner.clone();
    let settings = settings.to_settings()?;
    let recordings = recordings.iter().map(|samples| read(&inner, samples)).collect::<PyResult<Vec<_>>>()?;
    let mut asked = IdentificationSettings::new(interval);
    (asked.substeps, asked.window, asked.weights) = (substeps, window, weights);
    (asked.outlier, asked.iterations, asked.tolerance) = (outlier, iterations, tolerance);
    (asked.equal_recordings, asked.starts, asked.draws) = (equal_recordings, starts, draws);
    let unknown = |(name, parameter, bounds, prior): &Asked<'_>| -> PyResult<Unknown> {
        let unknown = Unknown::new(name, direction_of(&inner, parameter)?).with_bounds(*bounds);
        Ok(prior.map_or(unknown.clone(), |[value, deviation]| unknown.with_prior(value, deviation)))
    };
    let unknowns = unknowns.iter().map(unknown).collect::<PyResult<Vec<_>>>()?;
    let mut stopped = Ok(());
    let found = guard::detached(py, || {
        identify(&inner, &settings, &recordings, &unknowns, &asked, |news| {
            Python::attach(|py| {
                let told = py.check_signals().and_then(|()| match &progress {
                    Some(progress) => {
                        let values = arrays::vector(py, &news.values);
                        let answer = progress.call1(py, (news.iteration, news.objective, values))?;
                        Ok(answer.extract::<bool>(py).unwrap_or(true))
                    }
                    None => Ok(true),
                });
                told.unwrap_or_else(|error| {
                    stopped = Err(error);
                    false
                })
            })
        })
    })?;
    stopped?;
    let found = found.map_err(|error| match error {
        IdentificationError::Simulation(error) => simulation_error(error),
        error => PyValueError::new_err(error.to_string()),
    })?;
    Ok(IdentifiedValues { found })
}

fn read(model: &signorini::multibody::Model, (qpos, qvel, ctrl, act): &Samples<'_>) -> PyResult<Recording> {
    let (samples, nq, q) = arrays::read_matrix("qpos", qpos, [None, Some(model.nq)])?;
    let (_, nv, v) = arrays::read_matrix("qvel", qvel, [Some(samples), Some(model.nv)])?;
    let na = model.na;
    let activations = match act {
        Some(act) => arrays::read_matrix("act", act, [Some(samples), Some(na)])?.2,
        None => vec![0.0; samples * na],
    };
    let state = |k: usize| {
        let mut state = State::at(q[k * nq..(k + 1) * nq].to_vec(), v[k * nv..(k + 1) * nv].to_vec());
        state.activation = activations[k * na..(k + 1) * na].to_vec();
        state
    };
    let recording = Recording::new((0..samples).map(state).collect());
    let Some(ctrl) = ctrl else { return Ok(recording) };
    let nu = model.actuators.len();
    let (_, _, u) = arrays::read_matrix("ctrl", ctrl, [Some(samples.saturating_sub(1)), Some(nu)])?;
    let inputs = (0..samples.saturating_sub(1)).map(|k| Input::of_control(u[k * nu..(k + 1) * nu].to_vec()));
    Ok(recording.with_inputs(inputs.collect()))
}
