//! Many placements of one model, judged on all cores.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use pyo3::prelude::*;
use signorini::SimulationError;
use signorini::contact::ProblemError;
use signorini::statics::{self, Placement, StabilitySettings};

use crate::arrays::{self, Vector};
use crate::counts;
use crate::data::Data;
use crate::error::simulation_error;
use crate::guard;
use crate::limits::question;
use crate::model::Model;
use crate::statics::{attractions, held, judged};

/// What became of placements.
#[pyclass(frozen, module = "signorini")]
pub struct Placements {
    /// Nothing where neither forces nor a mechanism were found to the accuracy asked for.
    all: Vec<Option<Placement>>,
    tolerance: f64,
}

impl Placements {
    fn of<'py>(&self, py: Python<'py>, number: impl Fn(&Placement) -> f64) -> Vector<'py> {
        let of = |placement: &Option<Placement>| placement.as_ref().map_or(f64::NAN, &number);
        arrays::vector(py, &self.all.iter().map(of).collect::<Vec<f64>>())
    }
}

#[pymethods]
impl Placements {
    /// The verdicts, as of `stability`; "unknown" where neither forces nor a mechanism were found to the accuracy asked for.
    #[getter]
    fn verdict(&self) -> Vec<&'static str> {
        self.all.iter().map(|p| p.as_ref().map_or("unknown", |p| p.verdict.name())).collect()
    }

    /// Whether every proof is there and holds within the tolerance.
    #[getter]
    fn proved(&self) -> bool {
        self.all.iter().all(|p| p.as_ref().is_some_and(|p| p.residual <= self.tolerance))
    }

    /// Worst residual of each proof, (n,).
    #[getter]
    fn residual<'py>(&self, py: Python<'py>) -> Vector<'py> {
        self.of(py, |p| p.residual)
    }

    /// The deepest overlap that was taken as touching, (n,), m or rad.
    #[getter]
    fn overlap<'py>(&self, py: Python<'py>) -> Vector<'py> {
        self.of(py, |p| p.deepest_overlap)
    }

    /// The limit that was asked for, (n,); not a number where it must move or none was asked for.
    #[getter]
    fn margin<'py>(&self, py: Python<'py>) -> Vector<'py> {
        self.of(py, |p| p.margin)
    }

    fn __len__(&self) -> usize {
        self.all.len()
    }

    fn __repr__(&self) -> String {
        format!("<signorini.Placements {}>", self.all.len())
    }
}

/// Judges many configurations of a model, on all cores.
#[pyfunction]
#[pyo3(signature = (model, qpos, data=None, *, what=None, direction=None, body=None, hold=false, attraction=None, touching=1e-6, tolerance=1e-9, enumeration=0, search=true, progress=None))]
#[allow(clippy::too_many_arguments)] // Python's keywords
pub fn placements(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    qpos: &Bound<'_, PyAny>,
    data: Option<&Bound<'_, Data>>,
    what: Option<&str>,
    direction: Option<&Bound<'_, PyAny>>,
    body: Option<&str>,
    hold: bool,
    attraction: Option<&Bound<'_, PyAny>>,
    touching: f64,
    tolerance: f64,
    #[pyo3(from_py_with = counts::enumeration)] enumeration: usize,
    search: bool,
    progress: Option<Py<PyAny>>,
) -> PyResult<Placements> {
    let settings = StabilitySettings::default()
        .with_contact_tolerance(touching)
        .with_tolerance(tolerance)
        .with_enumeration_programs(enumeration);
    let (inner, state, input, settings) = judged(py, model, data, settings)?;
    let inner = if hold { held(&inner)? } else { inner };
    let settings = settings.with_attraction(attractions(&inner, attraction)?);
    let settings = if search { settings } else { settings.with_search_contacts(0) };
    let question = what.map(|what| question(&inner, what, direction, None, body)).transpose()?;
    let (_, _, rows) = arrays::read_matrix("qpos", qpos, [None, Some(inner.nq)])?;
    let placed = |row: &[f64]| {
        let mut placed = state.clone();
        placed.q.copy_from_slice(row);
        placed
    };
    let states: Vec<_> = rows.chunks_exact(inner.nq.max(1)).map(placed).collect();
    let done = AtomicUsize::new(0);
    let told = Mutex::new(Ok(()));
    let tell = || {
        let count = done.fetch_add(1, Ordering::Relaxed) + 1;
        let Some(progress) = &progress else { return };
        Python::attach(|py| {
            if let Err(error) = progress.call1(py, (count,)) {
                let mut first = told.lock().unwrap_or_else(PoisonError::into_inner);
                if first.is_ok() {
                    *first = Err(error);
                }
            }
        });
    };
    let found =
        guard::detached(py, || statics::placements(&inner, &states, &input, &settings, question.as_ref(), tell))?;
    told.into_inner().unwrap_or_else(PoisonError::into_inner)?;
    let judged = |found| match found {
        Ok(placement) => Ok(Some(placement)),
        Err(SimulationError::Problem(ProblemError::NotASolution { .. })) => Ok(None),
        Err(error) => Err(simulation_error(error)),
    };
    let all = found.into_iter().map(judged).collect::<PyResult<Vec<_>>>()?;
    Ok(Placements { all, tolerance })
}
