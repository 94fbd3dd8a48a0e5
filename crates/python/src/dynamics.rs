//! Smooth dynamics at the present state of a `Data`.

use pyo3::prelude::*;
use signorini::multibody::{self as mb, MassMatrix, NewtonEuler};

use crate::arrays::{self, Table, Vector};
use crate::data::Data;
use crate::model::Model;
use crate::stepping::check_model;

/// Inverse dynamics: `τ = M qacc + h` at the present qpos and qvel, (nv,), N, N·m.
#[pyfunction]
#[pyo3(signature = (model, data, qacc=None))]
pub fn inverse<'py>(
    py: Python<'py>,
    model: &Bound<'py, Model>,
    data: &Bound<'py, Data>,
    qacc: Option<&Bound<'py, PyAny>>,
) -> PyResult<Vector<'py>> {
    check_model(model, data)?;
    let nv = model.get().inner.nv;
    let acceleration = match qacc {
        Some(qacc) => arrays::read_vector("qacc", qacc, Some(nv))?,
        None => arrays::read_vector("data.qacc", &data.getattr("qacc")?, Some(nv))?,
    };
    let mut core = data.get().loaded(py)?;
    core.update_kinematics();
    let mut tau = vec![0.0; nv];
    let mut work = NewtonEuler::new(&core.model);
    mb::inverse_dynamics_into(&core.model, core.kinematics(), &acceleration, &mut work, &mut tau);
    Ok(arrays::vector(py, &tau))
}

/// Coriolis, centrifugal, gyroscopic and gravity forces `h` of `M v̇ + h = τ` at the present qpos and qvel, (nv,), N, N·m.
#[pyfunction]
pub fn bias_force<'py>(py: Python<'py>, model: &Bound<'py, Model>, data: &Bound<'py, Data>) -> PyResult<Vector<'py>> {
    check_model(model, data)?;
    let mut core = data.get().loaded(py)?;
    core.update_kinematics();
    let mut h = vec![0.0; core.model.nv];
    mb::bias_force_into(&core.model, core.kinematics(), &mut NewtonEuler::new(&core.model), &mut h);
    Ok(arrays::vector(py, &h))
}

/// The mass matrix `M` at the present qpos, (nv, nv), kg, kg·m, kg·m².
#[pyfunction]
pub fn mass_matrix<'py>(py: Python<'py>, model: &Bound<'py, Model>, data: &Bound<'py, Data>) -> PyResult<Table<'py>> {
    check_model(model, data)?;
    let mut core = data.get().loaded(py)?;
    core.update_kinematics();
    let mut mass = MassMatrix::new(&core.model);
    mb::mass_matrix_into(&core.model, core.kinematics(), &mut mass);
    arrays::matrix(py, mass.matrix.to_dense(), core.model.nv, core.model.nv)
}

/// `qpos ⊕ dt qvel`, (nq,): a configuration moved along a velocity; quaternions stay unit.
#[pyfunction]
#[pyo3(signature = (model, qpos, qvel, dt=1.0))]
pub fn integrate<'py>(
    py: Python<'py>,
    model: &Bound<'py, Model>,
    qpos: &Bound<'py, PyAny>,
    qvel: &Bound<'py, PyAny>,
    dt: f64,
) -> PyResult<Vector<'py>> {
    let model = &model.get().inner;
    let q = arrays::read_vector("qpos", qpos, Some(model.nq))?;
    let v = arrays::read_vector("qvel", qvel, Some(model.nv))?;
    let mut out = vec![0.0; model.nq];
    mb::integrate_into(model, &q, &v, dt, &mut out);
    Ok(arrays::vector(py, &out))
}

/// The velocity that leads from `qpos0` to `qpos1` in unit time, (nv,); rotations go the short way.
#[pyfunction]
pub fn difference<'py>(
    py: Python<'py>,
    model: &Bound<'py, Model>,
    qpos1: &Bound<'py, PyAny>,
    qpos0: &Bound<'py, PyAny>,
) -> PyResult<Vector<'py>> {
    let model = &model.get().inner;
    let q1 = arrays::read_vector("qpos1", qpos1, Some(model.nq))?;
    let q0 = arrays::read_vector("qpos0", qpos0, Some(model.nq))?;
    let mut out = vec![0.0; model.nv];
    mb::difference_into(model, &q1, &q0, &mut out);
    Ok(arrays::vector(py, &out))
}
