//! `Data`: a state with its live arrays, and the functions that move it.

use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, TryLockError};

use numpy::PyArray1;
use pyo3::exceptions::{PyIndexError, PyRuntimeError};
use pyo3::prelude::*;
use signorini::multibody::{kinetic_energy, potential_energy};

use crate::arrays::{self, LiveArray};
use crate::contacts::{Contacts, Limits};
use crate::core::Core;
use crate::error::{StateError, recording_error, simulation_error};
use crate::model::Model;
use crate::problem::{ContactProblem, ContactSolution};
use crate::recording::Recording;
use crate::report::{Certificate, StepReport};
use crate::settings::PySettings;

/// The arrays that every step updates.
struct Live {
    qpos: LiveArray,
    qvel: LiveArray,
    qacc: LiveArray,
    ctrl: LiveArray,
    qfrc_applied: LiveArray,
    xpos: LiveArray,
    xquat: LiveArray,
    xmat: LiveArray,
    xipos: LiveArray,
    linear_velocity: LiveArray,
    angular_velocity: LiveArray,
}

/// The state of a model and what a step needs.
#[pyclass(frozen, subclass, module = "signorini._core")]
pub struct Data {
    #[pyo3(get)]
    pub model: Py<Model>,
    #[pyo3(get)]
    settings: Py<PyAny>,
    core: Mutex<Core>,
    live: Live,
}

macro_rules! live_arrays {
    ($($(#[$doc:meta])* $name:ident, $setter:ident;)*) => {
        #[pymethods]
        impl Data {
            $($(#[$doc])*
            #[getter]
            fn $name(&self, py: Python<'_>) -> Py<PyAny> {
                self.live.$name.view(py)
            }

            #[setter]
            fn $setter(&self, py: Python<'_>, value: &Bound<'_, PyAny>) -> PyResult<()> {
                self.live.$name.assign(py, value)
            })*
        }
    };
}

live_arrays! {
    /// Configuration, (nq,), m, rad, unit quaternions (w, x, y, z): a live view; what is written to it is the state.
    qpos, set_qpos;
    /// Generalized velocity, (nv,), m/s, rad/s: a live view.
    qvel, set_qvel;
    /// Control values, (nu,): a live view.
    ctrl, set_ctrl;
    /// Applied generalized force, (nv,), N, N·m: a live view.
    qfrc_applied, set_qfrc_applied;
}

macro_rules! results {
    ($($(#[$doc:meta])* $name:ident;)*) => {
        #[pymethods]
        impl Data {
            $($(#[$doc])*
            #[getter]
            fn $name(&self, py: Python<'_>) -> Py<PyAny> {
                self.live.$name.view(py)
            })*
        }
    };
}

results! {
    /// Mean acceleration over the last step, (nv,), m/s², rad/s²: (v⁺ − v)/Δt.
    qacc;
    /// Positions of the bodies' origins in world, (nbody, 3), m.
    xpos;
    /// Orientations of the bodies, (nbody, 4), (w, x, y, z).
    xquat;
    /// Rotation matrices of the bodies, (nbody, 3, 3), body to world.
    xmat;
    /// Centres of mass of the bodies in world, (nbody, 3), m.
    xipos;
    /// Velocities of the bodies' origins, (nbody, 3), world axes, m/s.
    linear_velocity;
    /// Angular velocities of the bodies, (nbody, 3), world axes, rad/s.
    angular_velocity;
}

#[pymethods]
impl Data {
    #[new]
    fn new(py: Python<'_>, model: Py<Model>, settings: Py<PyAny>) -> PyResult<Self> {
        let inner = model.get().inner.clone();
        let (nq, nv, nu, nbody) = (inner.nq, inner.nv, inner.actuators.len(), inner.bodies.len());
        let options = settings.extract::<PySettings>(py)?.to_settings()?;
        let core = py.detach(|| Core::new(inner, options)).map_err(simulation_error)?;
        let array = |shape: &[usize]| LiveArray::new(py, shape);
        let live = Live {
            qpos: array(&[nq])?,
            qvel: array(&[nv])?,
            qacc: array(&[nv])?,
            ctrl: array(&[nu])?,
            qfrc_applied: array(&[nv])?,
            xpos: array(&[nbody, 3])?,
            xquat: array(&[nbody, 4])?,
            xmat: array(&[nbody, 3, 3])?,
            xipos: array(&[nbody, 3])?,
            linear_velocity: array(&[nbody, 3])?,
            angular_velocity: array(&[nbody, 3])?,
        };
        let data = Self { model, settings, core: Mutex::new(core), live };
        {
            let core = data.core()?;
            data.write_state(py, &core)?;
            data.write_kinematics(py, &core)?;
        }
        Ok(data)
    }

    /// Time, s.
    #[getter]
    fn time(&self) -> PyResult<f64> {
        Ok(self.core()?.state.time)
    }

    #[setter]
    fn set_time(&self, time: f64) -> PyResult<()> {
        self.core()?.state.time = time;
        Ok(())
    }

    /// Length of a step, s.
    #[getter]
    fn timestep(&self) -> PyResult<f64> {
        Ok(self.core()?.timestep())
    }

    /// Steps made with this object.
    #[getter]
    fn steps(&self) -> PyResult<u64> {
        Ok(self.core()?.steps)
    }

    /// Steps made with this object whose residuals exceed the tolerance.
    #[getter]
    fn missed_steps(&self) -> PyResult<u64> {
        Ok(self.core()?.missed_steps)
    }

    /// Contacts of the last step.
    #[getter]
    fn contact(&self) -> PyResult<Contacts> {
        let core = self.core()?;
        Ok(if core.stepped { Contacts::of_step(&core.workspace) } else { Contacts::none(core.timestep()) })
    }

    /// Joint limits in the last step's problem.
    #[getter]
    fn limit(&self) -> PyResult<Limits> {
        let core = self.core()?;
        Ok(if core.stepped { Limits::of_step(&core.workspace) } else { Limits::none(core.timestep()) })
    }

    /// Number of contacts of the last step.
    #[getter]
    fn ncon(&self) -> PyResult<usize> {
        let core = self.core()?;
        Ok(if core.stepped { core.workspace.contact_points().len() } else { 0 })
    }

    /// Residuals of the laws in the last step.
    #[getter]
    fn certificate(&self) -> PyResult<Certificate> {
        Ok(Certificate(self.core()?.report.certificate))
    }

    /// How the last step was solved.
    #[getter]
    fn report(&self) -> PyResult<StepReport> {
        Ok(StepReport::new(&self.core()?.report))
    }

    /// Kinetic and potential energy at the present qpos and qvel, J.
    #[getter]
    fn energy(&self, py: Python<'_>) -> PyResult<(f64, f64)> {
        let mut core = self.loaded(py)?;
        core.update_kinematics();
        let kinetic = kinetic_energy(&core.model, &core.kinematics, &core.state.v);
        Ok((kinetic, potential_energy(&core.model, &core.kinematics, &core.state.q)))
    }

    /// The contact problem of the last step, a copy.
    fn problem(&self) -> PyResult<ContactProblem> {
        let core = self.core()?;
        need_step(&core)?;
        Ok(ContactProblem::from(core.workspace.problem().clone()))
    }

    /// The solution of the last step's contact problem, a copy.
    fn solution(&self) -> PyResult<ContactSolution> {
        let core = self.core()?;
        need_step(&core)?;
        Ok(ContactSolution(core.workspace.solution().clone()))
    }

    #[pyo3(signature = (keyframe=None))]
    fn _reset(&self, py: Python<'_>, keyframe: Option<usize>) -> PyResult<()> {
        let mut core = self.core()?;
        let model = core.model.clone();
        match keyframe {
            None => {
                core.state = signorini::multibody::State::new(&model);
                core.input.control.fill(0.0);
            }
            Some(k) => {
                let keyframe = model.keyframes.get(k).ok_or_else(|| {
                    PyIndexError::new_err(format!("keyframe {k}: the model has {}", model.keyframes.len()))
                })?;
                core.state.time = keyframe.time;
                core.state.q.clone_from(&keyframe.q);
                core.state.v.clone_from(&keyframe.v);
                core.input.control.clone_from(&keyframe.control);
                core.input.control.resize(model.actuators.len(), 0.0);
            }
        }
        core.input.generalized_force.fill(0.0);
        core.forget();
        core.update_kinematics();
        self.write_state(py, &core)?;
        self.write_kinematics(py, &core)
    }

    /// Time, qpos, qvel, ctrl, qfrc_applied, and the solver's warm start, as one vector.
    #[pyo3(signature = (*, warm_start=true))]
    fn get_state<'py>(&self, py: Python<'py>, warm_start: bool) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let core = self.loaded(py)?;
        let mut numbers = vec![core.state.time];
        numbers.extend(&core.state.q);
        numbers.extend(&core.state.v);
        numbers.extend(&core.input.control);
        numbers.extend(&core.input.generalized_force);
        if warm_start {
            numbers.extend(core.workspace.warm_start());
        }
        Ok(PyArray1::from_vec(py, numbers))
    }

    /// Takes over a vector of `get_state`; one without warm start makes the next step start cold.
    fn set_state(&self, py: Python<'_>, state: &Bound<'_, PyAny>) -> PyResult<()> {
        let numbers = arrays::read_vector("state", state, None)?;
        let mut core = self.core()?;
        let (nq, nv, nu) = (core.model.nq, core.model.nv, core.model.actuators.len());
        let size = 1 + nq + 2 * nv + nu;
        if numbers.len() < size {
            let message = format!("the state has {} numbers, this model's has at least {size}", numbers.len());
            return Err(StateError::new_err(message));
        }
        let (plain, warm) = numbers.split_at(size);
        if let Some(i) = plain.iter().position(|x| !x.is_finite()) {
            return Err(StateError::new_err(format!("state[{i}] is {}: it must be finite", plain[i])));
        }
        core.workspace.clear_warm_start();
        if !warm.is_empty() {
            core.workspace.set_warm_start(warm).map_err(simulation_error)?;
        }
        core.state.time = plain[0];
        core.state.q.copy_from_slice(&plain[1..1 + nq]);
        core.state.v.copy_from_slice(&plain[1 + nq..1 + nq + nv]);
        core.input.control.copy_from_slice(&plain[1 + nq + nv..1 + nq + nv + nu]);
        core.input.generalized_force.copy_from_slice(&plain[1 + nq + nv + nu..]);
        core.stepped = false;
        core.report = Default::default();
        let core = &mut *core;
        core.other.v.clone_from(&core.state.v);
        core.update_kinematics();
        self.write_state(py, core)?;
        self.write_kinematics(py, core)
    }

    #[pyo3(signature = (path=None))]
    fn _start_recording(&self, path: Option<PathBuf>) -> PyResult<()> {
        let mut core = self.core()?;
        if core.is_recording() {
            return Err(PyRuntimeError::new_err("this data is being recorded already: stop that recorder first"));
        }
        core.start_recording(path.as_deref()).map_err(recording_error)
    }

    fn _stop_recording(&self, py: Python<'_>, reason: &str) -> PyResult<Option<Recording>> {
        let recording = self.loaded(py)?.stop_recording(reason).map_err(recording_error)?;
        Ok(recording.map(Recording))
    }
}

impl Data {
    /// The Rust side; an error while another thread steps this data.
    pub fn core(&self) -> PyResult<MutexGuard<'_, Core>> {
        match self.core.try_lock() {
            Ok(core) => Ok(core),
            Err(TryLockError::WouldBlock) => {
                Err(PyRuntimeError::new_err("this data is being stepped in another thread: give each thread its own"))
            }
            Err(TryLockError::Poisoned(_)) => {
                Err(PyRuntimeError::new_err("an earlier step of this data ended in a bug: make a new Data"))
            }
        }
    }

    /// The Rust side with what Python may have written to the arrays.
    pub fn loaded(&self, py: Python<'_>) -> PyResult<MutexGuard<'_, Core>> {
        let mut guard = self.core()?;
        let core = &mut *guard;
        self.live.qpos.read_into(py, &mut core.state.q)?;
        self.live.qvel.read_into(py, &mut core.state.v)?;
        self.live.ctrl.read_into(py, &mut core.input.control)?;
        self.live.qfrc_applied.read_into(py, &mut core.input.generalized_force)?;
        Ok(guard)
    }

    fn write_state(&self, py: Python<'_>, core: &Core) -> PyResult<()> {
        self.live.qpos.write(py, &core.state.q)?;
        self.live.qvel.write(py, &core.state.v)?;
        self.live.ctrl.write(py, &core.input.control)?;
        self.live.qfrc_applied.write(py, &core.input.generalized_force)
    }

    /// Poses and velocities of the bodies.
    pub fn write_kinematics(&self, py: Python<'_>, core: &Core) -> PyResult<()> {
        let (live, k) = (&self.live, &core.kinematics);
        live.xpos.write_rows(py, k.pose.iter().map(|x| x.position.to_array()))?;
        live.xquat.write_rows(py, k.pose.iter().map(|x| x.rotation).map(|r| [r.w, r.x, r.y, r.z]))?;
        live.xmat.write_rows(py, k.rotation.iter().map(|r| r.transpose().to_cols_array()))?;
        live.xipos.write_rows(py, k.center_of_mass.iter().map(|x| x.to_array()))?;
        live.linear_velocity.write_rows(py, k.linear_velocity.iter().map(|x| x.to_array()))?;
        live.angular_velocity.write_rows(py, k.angular_velocity.iter().map(|x| x.to_array()))
    }

    /// What a step changes.
    pub fn publish(&self, py: Python<'_>, core: &Core) -> PyResult<()> {
        self.live.qpos.write(py, &core.state.q)?;
        self.live.qvel.write(py, &core.state.v)?;
        self.write_kinematics(py, core)
    }

    /// `(after − before)/Δt`.
    pub fn write_acceleration(&self, py: Python<'_>, core: &Core, after: &[f64], before: &[f64]) -> PyResult<()> {
        let dt = core.timestep();
        self.live.qacc.write_rows(py, after.iter().zip(before).map(|(a, b)| [(a - b) / dt]))
    }
}

fn need_step(core: &Core) -> PyResult<()> {
    if core.stepped {
        return Ok(());
    }
    Err(PyRuntimeError::new_err("there is no step to show: call signorini.step or signorini.forward first"))
}
