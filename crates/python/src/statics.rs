//! Does it stand? Verdicts with their proofs.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PyDict;
use signorini::ContactSource;
use signorini::contact::problem_file::write_stability;
use signorini::multibody::{self as mb, Input, State};
use signorini::statics::{self, Attraction, BodyMotion, ModelStability, StabilitySettings, stability as judge};

use crate::arrays::{self, Table, Vector};
use crate::counts;
use crate::data::Data;
use crate::error::{SettingError, problem_error, simulation_error};
use crate::guard;
use crate::model::Model;
use crate::problem::ContactProblem;
use crate::stepping::check_model;

/// A verdict with what proves it.
#[pyclass(frozen, module = "signorini")]
pub struct Stability {
    found: ModelStability,
    motion: Vec<BodyMotion>,
    names: Vec<String>,
    tolerance: f64,
}

impl Stability {
    /// A verdict with the names of the bodies.
    pub fn new(found: ModelStability, motion: Vec<BodyMotion>, names: Vec<String>, tolerance: f64) -> Self {
        Self { found, motion, names, tolerance }
    }
}

#[pymethods]
impl Stability {
    /// "must_move", "stays", "may_do_either" or "stands".
    #[getter]
    fn verdict(&self) -> &'static str {
        self.found.stability.verdict().name()
    }

    /// Residuals of the proof, by name.
    #[getter]
    fn residuals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        self.found.stability.residuals.iter().try_for_each(|(name, r)| dict.set_item(name, r))?;
        Ok(dict)
    }

    /// Whether the proof holds within the tolerance.
    #[getter]
    fn proved(&self) -> bool {
        self.found.stability.worst() <= self.tolerance
    }

    /// Contact forces on the second body in world, (nc, 3), N; zero where there is no balance, and for limits.
    #[getter]
    fn forces<'py>(&self, py: Python<'py>) -> PyResult<Table<'py>> {
        let mut rows = vec![[0.0; 3]; self.found.rest.problem.contact_count()];
        self.found.forces().iter().for_each(|f| rows[f.contact] = f.force.to_array());
        arrays::rows(py, rows.into_iter())
    }

    /// The part of its friction that every contact uses in the balance, (nc,).
    #[getter]
    fn friction_use<'py>(&self, py: Python<'py>) -> Vector<'py> {
        let mut used = vec![0.0; self.found.rest.problem.contact_count()];
        self.found.forces().iter().for_each(|f| used[f.contact] = f.friction_use);
        arrays::vector(py, &used)
    }

    /// Contact points in world, (nc, 3), m; not a number for limits.
    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> PyResult<Table<'py>> {
        let place = |source: &ContactSource| match source {
            ContactSource::Point(point) => point.position.to_array(),
            _ => [f64::NAN; 3],
        };
        arrays::rows(py, self.found.rest.contacts.iter().map(place))
    }

    /// How bodies move in the mechanism, whose fastest has speed 1, or in the first step of the moving solution: velocity of the origin
    /// and angular velocity in world, by name.
    #[getter]
    fn motion<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for body in &self.motion {
            let both = (arrays::vector3(py, body.linear), arrays::vector3(py, body.angular));
            dict.set_item(&self.names[body.body.index()], both)?;
        }
        Ok(dict)
    }

    /// Contact forces together, N, that a balance would need at least: infinite where none of any size would do; `None` where there is one.
    #[getter]
    fn required_force(&self) -> Option<f64> {
        self.found.stability.mechanism.map(|m| m.required_impulse / self.found.rest.problem.timestep)
    }

    /// The range of every contact's normal force over all balances, (nc, 2), N; empty where there is no balance.
    fn force_ranges<'py>(&self, py: Python<'py>) -> PyResult<Table<'py>> {
        let ranges = guard::detached(py, || self.found.force_ranges())?.map_err(problem_error)?;
        arrays::rows(py, ranges.into_iter().map(|range| range.normal))
    }

    /// Where the search for a moving solution started and what it ended with.
    #[getter]
    fn search(&self) -> Vec<(&'static str, &'static str)> {
        self.found.stability.search.iter().map(|run| (run.start, run.end)).collect()
    }

    /// The contact problem that the verdict speaks of.
    #[getter]
    fn problem(&self) -> ContactProblem {
        ContactProblem::from(self.found.rest.problem.clone())
    }

    /// Writes the verdict with its proof as .npz, for `signorini check PROBLEM.npz PROOF.npz`.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        write_stability(path, &self.found.stability.proof).map_err(problem_error)
    }

    fn __repr__(&self) -> String {
        let nc = self.found.rest.problem.contact_count();
        format!(
            "<signorini.Stability {}, contacts: {nc}, residual: {:.1e}>",
            self.verdict(),
            self.found.stability.worst()
        )
    }
}

/// The model whose motors hold.
pub fn held(model: &mb::Model) -> PyResult<Arc<mb::Model>> {
    statics::held_by_motors(model).map(Arc::new).map_err(simulation_error)
}

/// What holds bodies together: a force for every contact point, or forces of pairs of bodies.
pub fn attractions(model: &mb::Model, given: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<Attraction>> {
    let Some(given) = given else { return Ok(Vec::new()) };
    if let Ok(force) = given.extract::<f64>() {
        return Ok(vec![Attraction::Points(force)]);
    }
    let pairs: BTreeMap<(String, String), f64> = given.extract().map_err(|_| {
        SettingError::new_err("attraction must be a force in N, or a dict of forces by pairs of bodies")
    })?;
    let body = |name: &str| -> PyResult<mb::BodyId> {
        let place = model.bodies.iter().position(|body| body.name == name);
        let place = place.ok_or_else(|| SettingError::new_err(format!("there is no body '{name}'")))?;
        Ok(mb::BodyId(place as u32))
    };
    pairs.iter().map(|((a, b), force)| Ok(Attraction::Pair([body(a)?, body(b)?], *force))).collect()
}

/// What is judged: the state and settings of a data, or the model's reference configuration.
pub fn judged(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    data: Option<&Bound<'_, Data>>,
    settings: StabilitySettings,
) -> PyResult<(Arc<mb::Model>, State, Input, StabilitySettings)> {
    let Some(data) = data else {
        let inner = model.get().inner.clone();
        let state = State::new(&inner);
        return Ok((inner, state, Input::default(), settings));
    };
    check_model(model, data)?;
    let core = data.get().loaded(py)?;
    Ok((core.model.clone(), core.state.clone(), core.input.clone(), settings.with_simulation(core.settings.clone())))
}

/// Whether a model at rest stands under its loads.
#[pyfunction]
#[pyo3(signature = (model, data=None, *, hold=false, attraction=None, touching=1e-6, tolerance=1e-9, enumeration=1000))]
#[allow(clippy::too_many_arguments)] // Python's keywords
pub fn stability(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    data: Option<&Bound<'_, Data>>,
    hold: bool,
    attraction: Option<&Bound<'_, PyAny>>,
    touching: f64,
    tolerance: f64,
    #[pyo3(from_py_with = counts::enumeration)] enumeration: usize,
) -> PyResult<Stability> {
    let settings = StabilitySettings::default()
        .with_contact_tolerance(touching)
        .with_tolerance(tolerance)
        .with_enumeration_programs(enumeration);
    let (inner, state, input, settings) = judged(py, model, data, settings)?;
    let inner = if hold { held(&inner)? } else { inner };
    let settings = settings.with_attraction(attractions(&inner, attraction)?);
    let found = guard::detached(py, || judge(&inner, &state, &input, &settings))?.map_err(simulation_error)?;
    let motion = found.motion(&inner, &state, &input);
    let names = inner.bodies.iter().map(|body| body.name.clone()).collect();
    Ok(Stability { found, motion, names, tolerance })
}
