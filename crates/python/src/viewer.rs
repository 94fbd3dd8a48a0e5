//! A copy of a `Data` that runs in the browser.

use std::sync::{Arc, Mutex, PoisonError};

use pyo3::exceptions::{PyOSError, PyRuntimeError};
use pyo3::prelude::*;
use signorini::Simulation;
use signorini::viewer::{self as live, ViewerError, ViewerSettings};

use crate::arrays::{self, Vector};
use crate::counts;
use crate::data::Data;
use crate::error::{SettingError, simulation_error};
use crate::guard;

/// Base of `signorini.viewer.Viewer`.
#[pyclass(frozen, subclass, module = "signorini._core")]
pub struct Viewer {
    /// Absent once closed.
    inner: Mutex<Option<live::Viewer>>,
}

#[pymethods]
impl Viewer {
    #[new]
    fn new(
        py: Python<'_>,
        data: &Bound<'_, Data>,
        #[pyo3(from_py_with = counts::port)] port: u16,
        title: String,
        running: bool,
        speed: f64,
    ) -> PyResult<Self> {
        let core = data.get().loaded(py)?;
        let (model, options) = (Arc::clone(&core.model), core.settings.clone());
        let mut simulation = Simulation::new(model, options).map_err(simulation_error)?;
        simulation.set_state(&core.state).map_err(simulation_error)?;
        simulation.input = core.input.clone();
        drop(core);
        let settings = ViewerSettings::default()
            .with_port(port)
            .with_title(title)
            .with_notes(Vec::new())
            .with_running(running)
            .with_speed(speed);
        let viewer = guard::detached(py, || live::Viewer::launch(simulation, &settings))?.map_err(viewer_error)?;
        Ok(Self { inner: Mutex::new(Some(viewer)) })
    }

    /// The address of the page; whoever knows it can see and move the simulation.
    #[getter]
    fn url(&self) -> PyResult<String> {
        self.with(|viewer| viewer.address().to_owned())
    }

    /// Whether it has not been closed.
    #[getter]
    fn is_open(&self) -> bool {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner).is_some()
    }

    fn _state<'py>(&self, py: Python<'py>) -> PyResult<(f64, Vector<'py>, Vector<'py>)> {
        let state = self.with(live::Viewer::state)?;
        Ok((state.time, arrays::vector(py, &state.q), arrays::vector(py, &state.v)))
    }

    fn _open_browser(&self) -> PyResult<()> {
        Ok(self.with(live::Viewer::open_browser)??)
    }

    /// Ends the simulation in the browser; closing twice is closing once.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        let viewer = self.inner.lock().unwrap_or_else(PoisonError::into_inner).take();
        guard::detached(py, || drop(viewer))
    }
}

impl Viewer {
    fn with<T>(&self, what: impl FnOnce(&live::Viewer) -> T) -> PyResult<T> {
        let guard = self.inner.lock().unwrap_or_else(PoisonError::into_inner);
        let viewer = guard.as_ref().ok_or_else(|| PyRuntimeError::new_err("the viewer is closed: launch another"))?;
        Ok(what(viewer))
    }
}

fn viewer_error(error: ViewerError) -> PyErr {
    match error {
        ViewerError::Speed { .. } => SettingError::new_err(error.to_string()),
        _ => PyOSError::new_err(error.to_string()),
    }
}
