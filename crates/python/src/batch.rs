//! `Batch`: many simulations of one model at once, on threads.

use std::sync::Mutex;

use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::exceptions::{PyIndexError, PyRuntimeError};
use pyo3::prelude::*;
use signorini::LaneStop;
use signorini::multibody::{Input, State};

use crate::arrays::{self, Cube, Vector};
use crate::error::{BatchError, ProblemError, simulation_error};
use crate::model::Model;
use crate::settings::PySettings;

/// Independent simulations of one model; each makes the steps that it would make alone, with the same bits.
#[pyclass(frozen, subclass, module = "signorini._core")]
pub struct Batch {
    #[pyo3(get)]
    model: Py<Model>,
    #[pyo3(get)]
    settings: Py<PyAny>,
    batch: Mutex<signorini::Batch>,
    count: usize,
    time: Py<PyArray1<f64>>,
    qpos: Py<PyArray2<f64>>,
    qvel: Py<PyArray2<f64>>,
    ctrl: Py<PyArray2<f64>>,
}

#[pymethods]
impl Batch {
    #[new]
    #[pyo3(signature = (model, nsim, settings, nthread=0))]
    fn new(py: Python<'_>, model: Py<Model>, nsim: usize, settings: Py<PyAny>, nthread: usize) -> PyResult<Self> {
        let inner = model.get().inner.clone();
        let (nq, nv, nu) = (inner.nq, inner.nv, inner.actuators.len());
        let options = settings.extract::<PySettings>(py)?.to_settings()?;
        let batch = py.detach(|| signorini::Batch::new(inner, options, nsim, nthread)).map_err(simulation_error)?;
        let zeros = |columns| PyArray2::zeros(py, [nsim, columns], false).unbind();
        let this = Self {
            model,
            settings,
            count: nsim,
            time: PyArray1::zeros(py, nsim, false).unbind(),
            qpos: zeros(nq),
            qvel: zeros(nv),
            ctrl: zeros(nu),
            batch: Mutex::new(batch),
        };
        this.publish(py, &*this.lock()?)?;
        Ok(this)
    }

    fn __len__(&self) -> usize {
        self.count
    }

    /// Times, (nsim,), s: a live view.
    #[getter]
    fn time<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.time.bind(py).call_method0("view")
    }

    /// Configurations, (nsim, nq): a live view; what is written to it is the state.
    #[getter]
    fn qpos<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.qpos.bind(py).call_method0("view")
    }

    /// Velocities, (nsim, nv): a live view.
    #[getter]
    fn qvel<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.qvel.bind(py).call_method0("view")
    }

    /// Control values, (nsim, nu): a live view.
    #[getter]
    fn ctrl<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.ctrl.bind(py).call_method0("view")
    }

    /// Largest residual of each simulation's last step, (nsim,).
    #[getter]
    fn residual<'py>(&self, py: Python<'py>) -> PyResult<Vector<'py>> {
        let batch = self.lock()?;
        Ok(PyArray1::from_iter(py, (0..self.count).map(|i| batch.report(i).certificate.worst())))
    }

    /// Contacts and joint limits in each simulation's last step, (nsim,).
    #[getter]
    fn ncon<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<i32>>> {
        let batch = self.lock()?;
        Ok(PyArray1::from_iter(py, (0..self.count).map(|i| batch.report(i).contacts as i32)))
    }

    /// Makes `nstep` steps of every simulation; the GIL is released meanwhile.
    #[pyo3(signature = (nstep=1))]
    fn step(&self, py: Python<'_>, nstep: u64) -> PyResult<()> {
        let mut batch = self.loaded(py)?;
        let batch = &mut *batch;
        py.detach(|| batch.step(nstep));
        self.publish(py, batch)?;
        self.check(batch)
    }

    /// Makes steps with given controls and records the states after each: `(qpos, qvel)`.
    #[pyo3(signature = (ctrl=None, nstep=None))]
    fn rollout<'py>(
        &self,
        py: Python<'py>,
        ctrl: Option<&Bound<'py, PyAny>>,
        nstep: Option<usize>,
    ) -> PyResult<(Cube<'py>, Cube<'py>)> {
        let mut batch = self.loaded(py)?;
        let batch = &mut *batch;
        let (nq, nv, nu) = (batch.model().nq, batch.model().nv, batch.model().actuators.len());
        let (steps, controls) = match (ctrl, nstep) {
            (Some(ctrl), nstep) => {
                let shape = [Some(self.count), nstep, Some(nu)];
                let (shape, controls) = arrays::read_cube("ctrl", ctrl, shape)?;
                (shape[1], controls)
            }
            (None, Some(nstep)) => (nstep, Vec::new()),
            (None, None) => return Err(ProblemError::new_err("give ctrl, (nsim, nstep, nu), or nstep")),
        };
        let mut q = vec![0.0; self.count * steps * nq];
        let mut v = vec![0.0; self.count * steps * nv];
        py.detach(|| batch.rollout(steps, &controls, &mut q, &mut v));
        self.publish(py, batch)?;
        self.check(batch)?;
        Ok((arrays::cube(py, q, [self.count, steps, nq])?, arrays::cube(py, v, [self.count, steps, nv])?))
    }

    #[pyo3(signature = (ids=None, keyframe=None))]
    fn _reset(&self, py: Python<'_>, ids: Option<Vec<usize>>, keyframe: Option<usize>) -> PyResult<()> {
        let mut batch = self.loaded(py)?;
        let batch = &mut *batch;
        let (model, nu) = (self.model.get().inner.clone(), self.model.get().inner.actuators.len());
        let (state, mut control) = match keyframe {
            None => (State::new(&model), Vec::new()),
            Some(k) => {
                let keyframe = model.keyframes.get(k);
                let keyframe = keyframe.ok_or_else(|| PyIndexError::new_err(format!("there is no keyframe {k}")))?;
                let state = State { time: keyframe.time, q: keyframe.q.clone(), v: keyframe.v.clone() };
                (state, keyframe.control.clone())
            }
        };
        control.resize(nu, 0.0);
        for i in ids.unwrap_or_else(|| (0..self.count).collect()) {
            if i >= self.count {
                return Err(PyIndexError::new_err(format!("simulation {i}: the batch has {}", self.count)));
            }
            batch.state_mut(i).clone_from(&state);
            *batch.input_mut(i) = Input { control: control.clone(), ..Input::default() };
            batch.clear_warm_start(i);
            self.ctrl.bind(py).try_readwrite()?.as_slice_mut()?[i * nu..(i + 1) * nu].copy_from_slice(&control);
        }
        self.publish(py, batch)
    }
}

impl Batch {
    fn lock(&self) -> PyResult<std::sync::MutexGuard<'_, signorini::Batch>> {
        let busy =
            |_| PyRuntimeError::new_err("this batch is being stepped in another thread: give each thread its own");
        self.batch.try_lock().map_err(busy)
    }

    /// The Rust side with what Python may have written to the arrays.
    fn loaded(&self, py: Python<'_>) -> PyResult<std::sync::MutexGuard<'_, signorini::Batch>> {
        let mut batch = self.lock()?;
        let (nq, nv, nu) = (batch.model().nq, batch.model().nv, batch.model().actuators.len());
        let (time, qpos) = (self.time.bind(py).try_readonly()?, self.qpos.bind(py).try_readonly()?);
        let (qvel, ctrl) = (self.qvel.bind(py).try_readonly()?, self.ctrl.bind(py).try_readonly()?);
        let (time, qpos, qvel, ctrl) = (time.as_slice()?, qpos.as_slice()?, qvel.as_slice()?, ctrl.as_slice()?);
        for i in 0..self.count {
            let state = batch.state_mut(i);
            state.time = time[i];
            state.q.copy_from_slice(&qpos[i * nq..(i + 1) * nq]);
            state.v.copy_from_slice(&qvel[i * nv..(i + 1) * nv]);
            let control = &mut batch.input_mut(i).control;
            control.clear();
            control.extend_from_slice(&ctrl[i * nu..(i + 1) * nu]);
        }
        Ok(batch)
    }

    fn publish(&self, py: Python<'_>, batch: &signorini::Batch) -> PyResult<()> {
        let (nq, nv) = (batch.model().nq, batch.model().nv);
        let mut time = self.time.bind(py).try_readwrite()?;
        let mut qpos = self.qpos.bind(py).try_readwrite()?;
        let mut qvel = self.qvel.bind(py).try_readwrite()?;
        let (time, qpos, qvel) = (time.as_slice_mut()?, qpos.as_slice_mut()?, qvel.as_slice_mut()?);
        for i in 0..self.count {
            let state = batch.state(i);
            time[i] = state.time;
            qpos[i * nq..(i + 1) * nq].copy_from_slice(&state.q);
            qvel[i * nv..(i + 1) * nv].copy_from_slice(&state.v);
        }
        Ok(())
    }

    /// An error that lists the simulations that stopped.
    fn check(&self, batch: &signorini::Batch) -> PyResult<()> {
        let stopped: Vec<(usize, String)> = (0..self.count)
            .filter_map(|i| match batch.stop(i)? {
                LaneStop::NoSolution => Some((i, format!("no solution at t = {} s", batch.state(i).time))),
                LaneStop::Error(error) => Some((i, error.to_string())),
            })
            .collect();
        let Some((first, reason)) = stopped.first() else {
            return Ok(());
        };
        let message = format!("{} of {} simulations stopped; simulation {first}: {reason}", stopped.len(), self.count);
        let (ids, reasons): (Vec<usize>, Vec<String>) = stopped.into_iter().unzip();
        Err(BatchError::new_err((message, ids, reasons)))
    }
}
