//! `Data`: a state with its live arrays, and the functions that move it.

use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, TryLockError};

use numpy::PyArray1;
use pyo3::exceptions::{PyIndexError, PyRuntimeError};
use pyo3::prelude::*;
use signorini::multibody::glam::{DQuat, DVec3};
use signorini::multibody::{BodyId, Pose, SpatialVector, kinetic_energy, potential_energy};

use crate::arrays::{self, Vector};
use crate::contacts::{Contacts, Limits};
use crate::core::Core;
use crate::error::{StateError, recording_error, simulation_error};
use crate::guard;
use crate::live::{Field, Live, force_first};
use crate::model::Model;
use crate::problem::ContactProblem;
use crate::recording::Recording;
use crate::report::{Certificate, StepReport};
use crate::settings::PySettings;
use crate::solution::ContactSolution;

/// The state of a model and what a step needs.
#[pyclass(frozen, subclass, module = "signorini._core")]
pub struct Data {
    #[pyo3(get)]
    pub model: Py<Model>,
    #[pyo3(get)]
    settings: Py<PyAny>,
    core: Mutex<Core>,
    pub live: Live,
}

macro_rules! live_arrays {
    ($($(#[$doc:meta])* $name:ident, $setter:ident, $field:ident;)*) => {
        #[pymethods]
        impl Data {
            $($(#[$doc])*
            #[getter]
            fn $name(&self, py: Python<'_>) -> Py<PyAny> {
                self.live.view(py, Field::$field)
            }

            #[setter]
            fn $setter(&self, py: Python<'_>, value: &Bound<'_, PyAny>) -> PyResult<()> {
                self.live.assign(py, stringify!($name), Field::$field, value)
            })*
        }
    };
}

live_arrays! {
    /// Configuration, (nq,), m, rad, unit quaternions (w, x, y, z): a live view; what is written to it is the state.
    qpos, set_qpos, Qpos;
    /// Generalized velocity, (nv,), m/s, rad/s: a live view.
    qvel, set_qvel, Qvel;
    /// Activations of actuators, (na,): a live view.
    act, set_act, Act;
    /// Control values, (nu,): a live view.
    ctrl, set_ctrl, Ctrl;
    /// Applied generalized force, (nv,), N, N·m: a live view.
    qfrc_applied, set_qfrc_applied, QfrcApplied;
    /// Applied force (N) and moment (N·m) on each body at its centre of mass, world axes, (nbody, 6): a live view.
    xfrc_applied, set_xfrc_applied, XfrcApplied;
    /// Positions of the bodies that are moved from outside, (nmocap, 3), m: a live view.
    mocap_pos, set_mocap_pos, MocapPos;
    /// Their orientations, (nmocap, 4), (w, x, y, z): a live view.
    mocap_quat, set_mocap_quat, MocapQuat;
}

macro_rules! results {
    ($($(#[$doc:meta])* $name:ident, $field:ident;)*) => {
        #[pymethods]
        impl Data {
            $($(#[$doc])*
            #[getter]
            fn $name(&self, py: Python<'_>) -> Py<PyAny> {
                self.live.view(py, Field::$field)
            })*
        }
    };
}

results! {
    /// Mean acceleration over the last step, (nv,), m/s², rad/s²: (v⁺ − v)/Δt.
    qacc, Qacc;
    /// Positions of the bodies' origins in world, (nbody, 3), m.
    xpos, Xpos;
    /// Orientations of the bodies, (nbody, 4), (w, x, y, z).
    xquat, Xquat;
    /// Rotation matrices of the bodies, (nbody, 3, 3), body to world.
    xmat, Xmat;
    /// Centres of mass of the bodies in world, (nbody, 3), m.
    xipos, Xipos;
    /// Velocities of the bodies' origins, (nbody, 3), world axes, m/s.
    linear_velocity, LinearVelocity;
    /// Angular velocities of the bodies, (nbody, 3), world axes, rad/s.
    angular_velocity, AngularVelocity;
}

#[pymethods]
impl Data {
    #[new]
    fn new(py: Python<'_>, model: Py<Model>, settings: Py<PyAny>) -> PyResult<Self> {
        let inner = model.get().inner.clone();
        let options = settings.extract::<PySettings>(py)?.to_settings()?;
        let live = Live::new(py, &inner)?;
        let core = guard::detached(py, || Core::new(inner, options))?.map_err(simulation_error)?;
        let data = Self { model, settings, core: Mutex::new(core), live };
        let core = data.core()?;
        data.write_all(py, &core)?;
        drop(core);
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

    /// Steps made with this object that were permitted to remove a part of their overlaps and violations only.
    #[getter]
    fn limited_steps(&self) -> PyResult<u64> {
        Ok(self.core()?.limited_steps)
    }

    /// Work of the impulses along corrections of overlaps and violations, J, of all steps made with this object.
    #[getter]
    fn correction_energy(&self) -> PyResult<f64> {
        Ok(self.core()?.correction_energy)
    }

    /// Steps made with this object in which negative gaps were taken as zero.
    #[getter]
    fn clipped_steps(&self) -> PyResult<u64> {
        Ok(self.core()?.clipped_steps)
    }

    /// Contacts of the last step.
    #[getter]
    fn contact(&self) -> PyResult<Contacts> {
        let core = self.core()?;
        let model = &core.model;
        Ok(if core.stepped {
            Contacts::of_step(model, &core.workspace, &core.settings)
        } else {
            Contacts::none(model, core.timestep())
        })
    }

    /// Numbers of all sensors, (nsensordata,): those of the state at the beginning of the last step, and the accelerations and
    /// forces with which it went on; zeros before the first step.
    #[getter]
    fn sensordata<'py>(&self, py: Python<'py>) -> PyResult<Vector<'py>> {
        arrays::fixed(PyArray1::from_vec(py, self.core()?.sensors()))
    }

    /// Forces of the actuators in the last step, before the gear, (nu,), N or N·m; zeros before the first step.
    #[getter]
    fn actuator_force<'py>(&self, py: Python<'py>) -> PyResult<Vector<'py>> {
        let core = self.core()?;
        let mut forces = vec![0.0; core.model.actuators.len()];
        if core.stepped {
            signorini::actuator_forces_into(&core.model, &core.workspace, &mut forces);
        }
        arrays::fixed(PyArray1::from_vec(py, forces))
    }

    /// Limits of joints and tendons in the last step's problem.
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

    /// Whether the last step left each body alone, (nbody,), because it and what is around it stood as they had stood before
    /// (`Settings.sleeping`); its contacts are among those of the step.
    #[getter]
    fn body_asleep<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<bool>>> {
        let core = self.core()?;
        let bodies = (0..core.model.bodies.len() as u32).map(|i| core.workspace.sleeps(BodyId(i)));
        arrays::fixed(PyArray1::from_iter(py, bodies))
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
        let kinetic = kinetic_energy(&core.model, core.kinematics(), &core.state.v);
        Ok((kinetic, potential_energy(&core.model, core.kinematics(), &core.state.q)))
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
                core.input.mocap = model.mocap_placements();
            }
            Some(k) => {
                let keyframe = model.keyframes.get(k).ok_or_else(|| {
                    PyIndexError::new_err(format!("keyframe {k}: the model has {}", model.keyframes.len()))
                })?;
                core.state.time = keyframe.time;
                core.state.q.clone_from(&keyframe.q);
                core.state.v.clone_from(&keyframe.v);
                core.state.activation.clone_from(&keyframe.activation);
                core.input.control.clone_from(&keyframe.control);
                core.input.control.resize(model.actuators.len(), 0.0);
                core.input.mocap = match keyframe.mocap.is_empty() {
                    true => model.mocap_placements(),
                    false => keyframe.mocap.clone(),
                };
            }
        }
        core.input.generalized_force.fill(0.0);
        core.input.wrench.fill(SpatialVector::ZERO);
        core.forget();
        core.update_kinematics();
        self.write_all(py, &core)
    }

    /// Time, qpos, qvel, act, ctrl, qfrc_applied, xfrc_applied, mocap_pos with mocap_quat body by body, and the solver's warm start, as one vector.
    #[pyo3(signature = (*, warm_start=true))]
    fn get_state<'py>(&self, py: Python<'py>, warm_start: bool) -> PyResult<Vector<'py>> {
        let core = self.loaded(py)?;
        let mut numbers = vec![core.state.time];
        numbers.extend(&core.state.q);
        numbers.extend(&core.state.v);
        numbers.extend(&core.state.activation);
        numbers.extend(&core.input.control);
        numbers.extend(&core.input.generalized_force);
        numbers.extend(core.input.wrench.iter().flat_map(force_first));
        for Pose { position: p, rotation: r } in &core.input.mocap {
            numbers.extend([p.x, p.y, p.z, r.w, r.x, r.y, r.z]);
        }
        if warm_start {
            numbers.extend(core.workspace.warm_start());
        }
        Ok(PyArray1::from_vec(py, numbers))
    }

    /// Takes over a vector of `get_state`; one without warm start makes the next step start cold.
    fn set_state(&self, py: Python<'_>, state: &Bound<'_, PyAny>) -> PyResult<()> {
        let numbers = arrays::read_vector("state", state, None)?;
        let mut core = self.core()?;
        let (nq, nv, na, nu) = (core.model.nq, core.model.nv, core.model.na, core.model.actuators.len());
        let size = 1 + nq + 2 * nv + na + nu + 6 * core.model.bodies.len() + 7 * core.model.mocap_bodies.len();
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
        let (time, plain) = plain.split_at(1);
        let (q, plain) = plain.split_at(nq);
        let (v, plain) = plain.split_at(nv);
        let (activation, plain) = plain.split_at(na);
        let (control, plain) = plain.split_at(nu);
        let (force, plain) = plain.split_at(nv);
        let (wrench, mocap) = plain.split_at(6 * core.model.bodies.len());
        core.state.time = time[0];
        core.state.q.copy_from_slice(q);
        core.state.v.copy_from_slice(v);
        core.state.activation.copy_from_slice(activation);
        core.input.control.copy_from_slice(control);
        core.input.generalized_force.copy_from_slice(force);
        for (own, x) in core.input.wrench.iter_mut().zip(wrench.chunks_exact(6)) {
            *own = SpatialVector { linear: DVec3::from_slice(x), angular: DVec3::from_slice(&x[3..]) };
        }
        for (pose, x) in core.input.mocap.iter_mut().zip(mocap.chunks_exact(7)) {
            *pose = Pose::new(DVec3::from_slice(x), DQuat::from_xyzw(x[4], x[5], x[6], x[3]));
        }
        core.stepped = false;
        core.report = Default::default();
        let core = &mut *core;
        core.other.v.clone_from(&core.state.v);
        core.update_kinematics();
        self.write_all(py, core)
    }

    #[pyo3(signature = (path=None))]
    fn _start_recording(&self, path: Option<PathBuf>) -> PyResult<()> {
        let source = self.model.get().source.clone();
        let mut core = self.core()?;
        if core.is_recording() {
            return Err(PyRuntimeError::new_err("this data is being recorded already: stop that recorder first"));
        }
        core.start_recording(path.as_deref(), source).map_err(recording_error)
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
        self.live.read_into(py, &mut guard)?;
        Ok(guard)
    }

    /// Writes everything that is not of a step.
    pub fn write_all(&self, py: Python<'_>, core: &Core) -> PyResult<()> {
        self.live.write(py, |live| {
            live.state(core);
            live.input(core);
            live.kinematics(core);
            live.acceleration(&core.state.v, &core.state.v, core.timestep());
        })
    }
}

/// An error where there was no step yet.
pub fn need_step(core: &Core) -> PyResult<()> {
    if core.stepped {
        return Ok(());
    }
    Err(PyRuntimeError::new_err("there is no step to show: call signorini.step or signorini.forward first"))
}
