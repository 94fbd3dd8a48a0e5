//! `Batch`: many simulations of one model at once, on threads.

mod saving;
mod views;

use std::num::NonZeroUsize;
use std::process;
use std::sync::{Mutex, MutexGuard, TryLockError};

use numpy::{PyArray1, PyArrayDyn};
use pyo3::exceptions::{PyIndexError, PyRuntimeError};
use pyo3::prelude::*;
use signorini::multibody::{Input, State};
use signorini::{LaneStop, Variation, contact_wrenches_into};

use crate::arrays::{self, Cube, Table, Vector};
use crate::counts;
use crate::derivatives::{StepDerivatives, step_batch};
use crate::directions::directions_of;
use crate::error::{BatchError, ProblemError, simulation_error};
use crate::guard;
use crate::model::Model;
use crate::quantity::Quantity;
use crate::settings::PySettings;
use crate::simulations::{Simulations, simulation};
use views::Views;

/// Independent simulations of one model; each makes the steps that it would make alone, with the same bits.
#[pyclass(frozen, subclass, module = "signorini._core")]
pub struct Batch {
    #[pyo3(get)]
    model: Py<Model>,
    #[pyo3(get)]
    settings: Py<PyAny>,
    /// Most threads that step the simulations, as asked for; 0 for as many as the machine runs at once.
    #[pyo3(get)]
    nthread: usize,
    lanes: Mutex<Lanes>,
    /// The process whose threads step the simulations, if there are such threads.
    threads_of: Option<u32>,
    count: usize,
    views: Views,
}

/// The simulations.
pub struct Lanes {
    pub batch: signorini::Batch,
    /// Which of them have made a step since they were made or reset.
    pub stepped: Vec<bool>,
}

impl Lanes {
    /// Lets the batch work without the GIL, until a signal raises an exception, which is given back, and notes which simulations have made a step since:
    /// those that were asked to, or where a signal came those that did.
    fn work(
        &mut self,
        py: Python<'_>,
        is_asked: impl Fn(usize) -> bool,
        work: impl FnOnce(&mut signorini::Batch, &mut dyn FnMut() -> bool) -> bool + Send,
    ) -> PyResult<PyResult<()>> {
        let Self { batch, stepped } = self;
        let before: Vec<u64> = (0..batch.len()).map(|i| batch.simulation(i).summary().steps).collect();
        let (_, signal) = guard::interruptible(py, |goes_on| work(&mut *batch, goes_on))?;
        for (i, stepped) in stepped.iter_mut().enumerate() {
            *stepped |= is_asked(i) && (signal.is_ok() || batch.simulation(i).summary().steps > before[i]);
        }
        Ok(signal)
    }
}

#[pymethods]
impl Batch {
    #[new]
    #[pyo3(signature = (model, nsim, settings, nthread=0))]
    fn new(
        py: Python<'_>,
        model: Py<Model>,
        #[pyo3(from_py_with = counts::nsim)] nsim: usize,
        settings: Py<PyAny>,
        #[pyo3(from_py_with = counts::nthread)] nthread: usize,
    ) -> PyResult<Self> {
        let inner = model.get().inner.clone();
        let (nq, nv, na, nu) = (inner.nq, inner.nv, inner.na, inner.actuators.len());
        let options = settings.extract::<PySettings>(py)?.to_settings()?;
        let placements = inner.mocap_placements();
        for (what, size) in [("qpos", nq), ("qvel", nv), ("act", na), ("ctrl", nu)] {
            guard::bounded(what, &[nsim, size])?;
        }
        // The pool that simulations share has no threads in a forked process, if its parent has used it.
        let threads = if nthread == 0 && guard::is_forked() {
            std::thread::available_parallelism().map_or(1, NonZeroUsize::get)
        } else {
            nthread
        };
        let made = guard::detached(py, || signorini::Batch::new(inner, options, nsim, threads))?;
        let mut batch = made.map_err(simulation_error)?;
        (0..nsim).for_each(|i| batch.input_mut(i).mocap.clone_from(&placements));
        let this = Self {
            model,
            settings,
            nthread,
            threads_of: (threads != 1 && nsim > 1).then(process::id),
            count: nsim,
            views: Views::new(py, &batch),
            lanes: Mutex::new(Lanes { batch, stepped: vec![false; nsim] }),
        };
        {
            let mut lanes = this.lock()?;
            this.views.publish(py, &lanes.batch)?;
            (0..nsim).try_for_each(|i| this.views.publish_input(py, &mut lanes.batch, i))?;
        }
        Ok(this)
    }

    fn __len__(&self) -> usize {
        self.count
    }

    /// Times, (nsim,), s: a live view.
    #[getter]
    fn time<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.views.time.bind(py).call_method0("view")
    }

    /// Configurations, (nsim, nq): a live view; what is written to it is the state.
    #[getter]
    fn qpos<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.views.qpos.bind(py).call_method0("view")
    }

    /// Velocities, (nsim, nv): a live view.
    #[getter]
    fn qvel<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.views.qvel.bind(py).call_method0("view")
    }

    /// Activations of actuators, (nsim, na): a live view.
    #[getter]
    fn act<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.views.act.bind(py).call_method0("view")
    }

    /// Control values, (nsim, nu): a live view.
    #[getter]
    fn ctrl<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.views.ctrl.bind(py).call_method0("view")
    }

    /// Positions of the bodies that are moved from outside, (nsim, nmocap, 3), m: a live view.
    #[getter]
    fn mocap_pos<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.views.mocap_pos.bind(py).call_method0("view")
    }

    /// Their orientations, (nsim, nmocap, 4), (w, x, y, z): a live view.
    #[getter]
    fn mocap_quat<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.views.mocap_quat.bind(py).call_method0("view")
    }

    /// Part θ of the overlaps and violations asked for that each simulation's last step removes, (nsim,); 1 where there is none.
    #[getter]
    fn theta<'py>(&self, py: Python<'py>) -> PyResult<Vector<'py>> {
        let lanes = self.lock()?;
        let theta = |i| if lanes.stepped[i] { lanes.batch.report(i).theta } else { 1.0 };
        arrays::fixed(PyArray1::from_iter(py, (0..self.count).map(theta)))
    }

    /// Steps of each simulation that removed a part of them only, (nsim,): since it was made, or had its parameters varied.
    #[getter]
    fn limited_steps<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<i64>>> {
        let lanes = self.lock()?;
        let limited = |i| lanes.batch.simulation(i).summary().limited_steps as i64;
        arrays::fixed(PyArray1::from_iter(py, (0..self.count).map(limited)))
    }

    /// Work of the impulses along the corrections of all steps of each simulation, (nsim,), J: since as `limited_steps`.
    #[getter]
    fn correction_energy<'py>(&self, py: Python<'py>) -> PyResult<Vector<'py>> {
        let lanes = self.lock()?;
        let energy = |i| lanes.batch.simulation(i).summary().correction_energy;
        arrays::fixed(PyArray1::from_iter(py, (0..self.count).map(energy)))
    }

    /// Largest residual of each simulation's last step, (nsim,); 0 where there is none.
    #[getter]
    fn residual<'py>(&self, py: Python<'py>) -> PyResult<Vector<'py>> {
        let lanes = self.lock()?;
        let worst = |i| if lanes.stepped[i] { lanes.batch.report(i).certificate.worst() } else { 0.0 };
        arrays::fixed(PyArray1::from_iter(py, (0..self.count).map(worst)))
    }

    /// Contacts and joint limits in each simulation's last step, (nsim,); 0 where there is none.
    #[getter]
    fn ncon<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<i32>>> {
        let lanes = self.lock()?;
        let contacts = |i| if lanes.stepped[i] { lanes.batch.report(i).contacts as i32 } else { 0 };
        arrays::fixed(PyArray1::from_iter(py, (0..self.count).map(contacts)))
    }

    /// Numbers of all sensors at the beginning of each simulation's last step, (nsim, nsensordata); 0 where there is none.
    #[getter]
    fn sensordata<'py>(&self, py: Python<'py>) -> PyResult<Table<'py>> {
        let mut lanes = self.lock()?;
        let size = lanes.batch.model().sensor_size;
        let mut numbers = vec![0.0; self.count * size];
        for i in (0..self.count).filter(|_| size > 0) {
            if lanes.stepped[i] {
                numbers[i * size..(i + 1) * size].copy_from_slice(lanes.batch.sensors(i));
            }
        }
        arrays::fixed(arrays::matrix(py, numbers, self.count, size)?)
    }

    /// What the contacts of each simulation's last step do to its bodies, (nsim, nbody, 6).
    #[getter]
    fn contact_wrench<'py>(&self, py: Python<'py>) -> PyResult<Cube<'py>> {
        let lanes = self.lock()?;
        let bodies = lanes.batch.model().bodies.len();
        let mut numbers = vec![0.0; self.count * bodies * 6];
        for (i, out) in numbers.chunks_exact_mut(bodies * 6).enumerate() {
            if lanes.stepped[i] {
                contact_wrenches_into(lanes.batch.simulation(i).workspace(), out);
            }
        }
        arrays::fixed(arrays::cube(py, numbers, [self.count, bodies, 6])?)
    }

    /// Makes `nstep` steps of the simulations `ids`, or of all; the GIL is released meanwhile.
    #[pyo3(signature = (nstep=1, ids=None))]
    fn step(
        &self,
        py: Python<'_>,
        #[pyo3(from_py_with = counts::nstep)] nstep: u64,
        ids: Option<Simulations>,
    ) -> PyResult<()> {
        let ids = ids.map(|ids| ids.among(self.count)).transpose()?;
        let mut lanes = self.loaded(py)?;
        let mut chosen = vec![ids.is_none(); self.count];
        ids.into_iter().flatten().for_each(|i| chosen[i] = true);
        let signal = lanes.work(
            py,
            |i| chosen[i] && nstep > 0,
            |batch, goes_on| batch.step_chosen_while(nstep, &chosen, goes_on),
        )?;
        self.views.publish(py, &lanes.batch)?;
        signal?;
        self.check(&lanes.batch)
    }

    /// Makes steps with given controls and records what is asked for after each.
    fn _rollout<'py>(
        &self,
        py: Python<'py>,
        ctrl: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = counts::nstep)] nstep: Option<usize>,
        record: Vec<String>,
    ) -> PyResult<Vec<Bound<'py, PyArrayDyn<f64>>>> {
        let quantities = record.iter().map(|name| Quantity::named(name)).collect::<PyResult<Vec<_>>>()?;
        let mut lanes = self.loaded(py)?;
        let model = self.model.get().inner.clone();
        let (steps, controls) = match (ctrl, nstep) {
            (Some(ctrl), nstep) => {
                let shape = [Some(self.count), nstep, Some(model.actuators.len())];
                let (shape, controls) = arrays::read_cube("ctrl", ctrl, shape)?;
                (shape[1], controls)
            }
            (None, Some(nstep)) => (nstep, Vec::new()),
            (None, None) => return Err(ProblemError::new_err("give ctrl, (nsim, nstep, nu), or nstep")),
        };
        let mut records: Vec<Vec<Vec<f64>>> = vec![Vec::new(); self.count];
        for quantity in &quantities {
            let size = quantity.size(&model);
            guard::bounded("the record", &[self.count, steps, size])?;
            for record in &mut records {
                record.push(guard::unknowns(steps * size)?);
            }
        }
        let signal = lanes.work(
            py,
            |_| steps > 0,
            |batch, goes_on| {
                batch.rollout_while(steps, &controls, &mut records, goes_on, |k, simulation, records| {
                    for (quantity, record) in quantities.iter().zip(records) {
                        let size = quantity.size(&model);
                        quantity.write(simulation, &mut record[k * size..(k + 1) * size]);
                    }
                })
            },
        )?;
        self.views.publish(py, &lanes.batch)?;
        signal?;
        self.check(&lanes.batch)?;
        let joined = quantities.iter().enumerate().map(|(j, quantity)| {
            let shape = [vec![self.count, steps], quantity.shape(&model)].concat();
            arrays::array(py, records.iter().flat_map(|record| record[j].iter().copied()).collect(), &shape)
        });
        joined.collect()
    }

    /// One step of every simulation with its derivative.
    #[pyo3(signature = (parameters=None))]
    fn step_with_derivatives(
        &self,
        py: Python<'_>,
        parameters: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Vec<StepDerivatives>> {
        let parameters = parameters.map(|given| directions_of(&self.model.get().inner, given)).transpose()?;
        let mut lanes = self.loaded(py)?;
        let Lanes { batch, stepped } = &mut *lanes;
        let all = guard::detached(py, || step_batch(batch, parameters.unwrap_or_default()))?;
        stepped.fill(true);
        self.views.publish(py, batch)?;
        Ok(all)
    }

    /// Gives a simulation parameters of its own, relative to those of the model.
    #[pyo3(signature = (id, *, friction=1.0, mass=1.0, gravity=None))]
    fn vary(&self, py: Python<'_>, id: isize, friction: f64, mass: f64, gravity: Option<[f64; 3]>) -> PyResult<()> {
        let id = simulation(id, self.count)?;
        let mut lanes = self.loaded(py)?;
        let variation =
            Variation::default().with_friction(friction).with_mass(mass).with_gravity(gravity.map(Into::into));
        lanes.batch.vary(id, &variation).map_err(simulation_error)?;
        lanes.stepped[id] = false;
        Ok(())
    }

    /// The indices of simulations, from 0; of all without `ids`.
    #[pyo3(signature = (ids=None))]
    fn _simulations(&self, ids: Option<Simulations>) -> PyResult<Vec<usize>> {
        ids.map_or_else(|| Ok((0..self.count).collect()), |ids| ids.among(self.count))
    }

    #[pyo3(signature = (ids=None, keyframe=None))]
    fn _reset(&self, py: Python<'_>, ids: Option<Simulations>, keyframe: Option<usize>) -> PyResult<()> {
        let ids = self._simulations(ids)?;
        let mut lanes = self.loaded(py)?;
        let Lanes { batch, stepped } = &mut *lanes;
        let (model, nu) = (self.model.get().inner.clone(), self.model.get().inner.actuators.len());
        let (state, mut control, mocap) = match keyframe {
            None => (State::new(&model), Vec::new(), Vec::new()),
            Some(k) => {
                let keyframe = model.keyframes.get(k);
                let keyframe = keyframe.ok_or_else(|| PyIndexError::new_err(format!("there is no keyframe {k}")))?;
                let signorini::multibody::Keyframe { time, q, v, activation, control, mocap, .. } = keyframe.clone();
                let state = State::at(q, v).with_time(time).with_activation(activation);
                (state, control, mocap)
            }
        };
        let mocap = if mocap.is_empty() { model.mocap_placements() } else { mocap };
        control.resize(nu, 0.0);
        for i in ids {
            stepped[i] = false;
            batch.state_mut(i).clone_from(&state);
            *batch.input_mut(i) = Input::default().with_control(control.clone()).with_mocap(mocap.clone());
            batch.clear_warm_start(i);
            self.views.publish_input(py, batch, i)?;
        }
        self.views.publish(py, batch)
    }
}

impl Batch {
    fn lock(&self) -> PyResult<MutexGuard<'_, Lanes>> {
        if self.threads_of.is_some_and(|process| process != process::id()) {
            return Err(PyRuntimeError::new_err(
                "this batch was made before the process was forked, and its threads stayed behind: make it in the child, \
                 or with nthread=1",
            ));
        }
        self.lanes.try_lock().map_err(|error| {
            PyRuntimeError::new_err(match error {
                TryLockError::WouldBlock => "this batch is being stepped in another thread: give each thread its own",
                TryLockError::Poisoned(_) => "a step of this batch failed by an internal error: make it anew",
            })
        })
    }

    /// The Rust side with what Python may have written to the arrays.
    pub fn loaded(&self, py: Python<'_>) -> PyResult<MutexGuard<'_, Lanes>> {
        let mut lanes = self.lock()?;
        self.views.load(py, &mut lanes.batch)?;
        Ok(lanes)
    }

    /// An error that lists the simulations that stopped.
    fn check(&self, batch: &signorini::Batch) -> PyResult<()> {
        let stopped: Vec<(usize, String)> = (0..self.count)
            .filter_map(|i| match batch.stop(i)? {
                LaneStop::NoSolution => Some((i, format!("no solution found at t = {} s", batch.state(i).time))),
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
