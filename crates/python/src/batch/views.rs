//! The live views of a batch: what Python wrote to them, and what the simulations come to.

use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use signorini::Batch;
use signorini::multibody::Pose;
use signorini::multibody::glam::{DQuat, DVec3};

/// Arrays with one row per simulation.
pub struct Views {
    pub time: Py<PyArray1<f64>>,
    pub qpos: Py<PyArray2<f64>>,
    pub qvel: Py<PyArray2<f64>>,
    pub act: Py<PyArray2<f64>>,
    pub ctrl: Py<PyArray2<f64>>,
    pub mocap_pos: Py<PyArray3<f64>>,
    pub mocap_quat: Py<PyArray3<f64>>,
}

impl Views {
    /// Those of a batch, with zeros.
    pub fn new(py: Python<'_>, batch: &Batch) -> Self {
        let (model, count) = (batch.model(), batch.len());
        let zeros = |columns| PyArray2::zeros(py, [count, columns], false).unbind();
        let poses = |numbers| PyArray3::zeros(py, [count, model.mocap_bodies.len(), numbers], false).unbind();
        Self {
            time: PyArray1::zeros(py, count, false).unbind(),
            qpos: zeros(model.nq),
            qvel: zeros(model.nv),
            act: zeros(model.na),
            ctrl: zeros(model.actuators.len()),
            mocap_pos: poses(3),
            mocap_quat: poses(4),
        }
    }

    /// Gives the simulations what Python may have written.
    pub fn load(&self, py: Python<'_>, batch: &mut Batch) -> PyResult<()> {
        let (nq, nv) = (batch.model().nq, batch.model().nv);
        let (na, nu) = (batch.model().na, batch.model().actuators.len());
        let act = self.act.bind(py).try_readonly()?;
        let act = act.as_slice()?;
        let (time, qpos) = (self.time.bind(py).try_readonly()?, self.qpos.bind(py).try_readonly()?);
        let (qvel, ctrl) = (self.qvel.bind(py).try_readonly()?, self.ctrl.bind(py).try_readonly()?);
        let (time, qpos, qvel, ctrl) = (time.as_slice()?, qpos.as_slice()?, qvel.as_slice()?, ctrl.as_slice()?);
        let (positions, rotations) =
            (self.mocap_pos.bind(py).try_readonly()?, self.mocap_quat.bind(py).try_readonly()?);
        let (positions, rotations) = (positions.as_slice()?, rotations.as_slice()?);
        let nmocap = batch.model().mocap_bodies.len();
        for i in 0..batch.len() {
            let rows = positions.chunks_exact(3).zip(rotations.chunks_exact(4)).skip(i * nmocap);
            for (pose, (p, r)) in batch.input_mut(i).mocap.iter_mut().zip(rows) {
                *pose = Pose::new(DVec3::from_slice(p), DQuat::from_xyzw(r[1], r[2], r[3], r[0]));
            }
            let state = batch.state_mut(i);
            state.time = time[i];
            state.q.copy_from_slice(&qpos[i * nq..(i + 1) * nq]);
            state.v.copy_from_slice(&qvel[i * nv..(i + 1) * nv]);
            state.activation.copy_from_slice(&act[i * na..(i + 1) * na]);
            let control = &mut batch.input_mut(i).control;
            control.clear();
            control.extend_from_slice(&ctrl[i * nu..(i + 1) * nu]);
        }
        Ok(())
    }

    /// Shows the states of the simulations.
    pub fn publish(&self, py: Python<'_>, batch: &Batch) -> PyResult<()> {
        let (nq, nv, na) = (batch.model().nq, batch.model().nv, batch.model().na);
        let mut act = self.act.bind(py).try_readwrite()?;
        let act = act.as_slice_mut()?;
        let mut time = self.time.bind(py).try_readwrite()?;
        let mut qpos = self.qpos.bind(py).try_readwrite()?;
        let mut qvel = self.qvel.bind(py).try_readwrite()?;
        let (time, qpos, qvel) = (time.as_slice_mut()?, qpos.as_slice_mut()?, qvel.as_slice_mut()?);
        for i in 0..batch.len() {
            let state = batch.state(i);
            time[i] = state.time;
            qpos[i * nq..(i + 1) * nq].copy_from_slice(&state.q);
            qvel[i * nv..(i + 1) * nv].copy_from_slice(&state.v);
            act[i * na..(i + 1) * na].copy_from_slice(&state.activation);
        }
        Ok(())
    }

    /// Shows the control values of simulation `i`, zero where it has none, and where the bodies stand that are moved from outside: only a reset and
    /// what is restored change these.
    pub fn publish_input(&self, py: Python<'_>, batch: &mut Batch, i: usize) -> PyResult<()> {
        let nu = batch.model().actuators.len();
        let mut ctrl = self.ctrl.bind(py).try_readwrite()?;
        let own = &mut ctrl.as_slice_mut()?[i * nu..(i + 1) * nu];
        own.fill(0.0);
        own.iter_mut().zip(&batch.input_mut(i).control).for_each(|(shown, control)| *shown = *control);
        let mut positions = self.mocap_pos.bind(py).try_readwrite()?;
        let mut rotations = self.mocap_quat.bind(py).try_readwrite()?;
        let poses = &batch.input_mut(i).mocap;
        let rows = positions.as_slice_mut()?.chunks_exact_mut(3).zip(rotations.as_slice_mut()?.chunks_exact_mut(4));
        for (Pose { position: p, rotation: r }, (position, rotation)) in poses.iter().zip(rows.skip(i * poses.len())) {
            position.copy_from_slice(&p.to_array());
            rotation.copy_from_slice(&[r.w, r.x, r.y, r.z]);
        }
        Ok(())
    }
}
