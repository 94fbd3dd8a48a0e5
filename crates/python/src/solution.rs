//! Solutions of contact problems.

use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use signorini::contact;

use crate::arrays::{self, Table, Vector};
use crate::contacts::{directions_array, mode_code};
use crate::report::{Certificate, StageRun, contacts_of, stages_dict, status_of};

/// Velocity and impulses that solve a contact problem, with their certificate.
#[pyclass(frozen, module = "signorini")]
pub struct ContactSolution(pub contact::ContactSolution);

#[pymethods]
impl ContactSolution {
    /// Velocity at the end of the step, (nv,), m/s, rad/s.
    #[getter]
    fn v<'py>(&self, py: Python<'py>) -> PyResult<Vector<'py>> {
        arrays::fixed(arrays::vector(py, &self.0.velocity))
    }

    /// Normal impulses, (nc,), N·s.
    #[getter]
    fn lambda_n<'py>(&self, py: Python<'py>) -> PyResult<Vector<'py>> {
        arrays::fixed(arrays::vector(py, &self.0.lambda_n))
    }

    /// Impulses along the friction directions, (m,), N·s.
    #[getter]
    fn alpha<'py>(&self, py: Python<'py>) -> PyResult<Vector<'py>> {
        arrays::fixed(arrays::vector(py, &self.0.alpha))
    }

    /// Multipliers of the friction bounds, (nc,), m/s.
    #[getter]
    fn beta<'py>(&self, py: Python<'py>) -> PyResult<Vector<'py>> {
        arrays::fixed(arrays::vector(py, &self.0.beta))
    }

    /// Impulses of the bilateral rows, (nb,), N·s or N·m·s.
    #[getter]
    fn lambda_b<'py>(&self, py: Python<'py>) -> PyResult<Vector<'py>> {
        arrays::fixed(arrays::vector(py, &self.0.bilateral))
    }

    /// Impulses along the directions of friction that belongs to no contact's sliding, N·s or N·m·s.
    #[getter]
    fn alpha_f<'py>(&self, py: Python<'py>) -> PyResult<Vector<'py>> {
        arrays::fixed(arrays::vector(py, &self.0.group_alpha))
    }

    /// Multipliers of the bounds of that friction, m/s or rad/s.
    #[getter]
    fn beta_f<'py>(&self, py: Python<'py>) -> PyResult<Vector<'py>> {
        arrays::fixed(arrays::vector(py, &self.0.group_beta))
    }

    /// z = (lambda_n, alpha, beta) of the standard LCP.
    #[getter]
    fn z<'py>(&self, py: Python<'py>) -> PyResult<Vector<'py>> {
        arrays::fixed(PyArray1::from_vec(py, self.0.z()))
    }

    /// Impulses along normal and tangents, (nc, 3), N·s.
    #[getter]
    fn impulse<'py>(&self, py: Python<'py>) -> PyResult<Table<'py>> {
        arrays::fixed(arrays::rows(py, self.0.impulse.iter().copied())?)
    }

    /// What each contact does, (nc,): values of `signorini.ContactMode`.
    #[getter]
    fn mode<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<i8>>> {
        arrays::fixed(PyArray1::from_iter(py, self.0.modes.iter().map(|&m| mode_code(m).0)))
    }

    /// The friction directions that a sliding contact's impulse lies on, (nc, 2); -1 where there is none.
    #[getter]
    fn direction<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i32>>> {
        arrays::fixed(directions_array(py, self.0.modes.iter().map(|&m| mode_code(m).1))?)
    }

    /// "solved", "inaccurate", "unresolved", "infeasible", "iteration_limit".
    #[getter]
    fn status(&self) -> String {
        status_of(&self.0.status)
    }

    /// Whether every law holds within the tolerance.
    #[getter]
    fn solved(&self) -> bool {
        self.0.status == contact::SolveStatus::Solved
    }

    /// Contacts that contradict each other, where the status says so.
    #[getter]
    fn blamed(&self) -> Vec<usize> {
        contacts_of(&self.0.status).to_vec()
    }

    /// Residuals of the laws, computed from the data.
    #[getter]
    fn certificate(&self) -> Certificate {
        Certificate(self.0.certificate)
    }

    /// Mode changes, proximal iterations and pivots together.
    #[getter]
    fn iterations(&self) -> u32 {
        self.0.report.iterations()
    }

    /// What the structured solver's stages did, those that were asked, by name in the order of the cascade.
    #[getter]
    fn stages<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        stages_dict(py, &self.0.report.stages)
    }

    /// What each stage did on each island, in order; empty unless the solve was asked to record it.
    #[getter]
    fn history(&self) -> Vec<StageRun> {
        self.0.history.iter().map(StageRun::from).collect()
    }

    fn __repr__(&self) -> String {
        let worst = self.0.certificate.worst();
        format!(
            "<signorini.ContactSolution {}: {} contacts, worst residual {worst:.1e}>",
            self.status(),
            self.0.lambda_n.len()
        )
    }
}
