//! The step near a state as a linear complementarity system.

use pyo3::prelude::*;
use signorini::lcp::{Matrix, MethodKind};
use signorini::{LinearComplementaritySystem as System, LinearizedContacts, linear_complementarity_system_with};

use crate::arrays::{self, Table, Vector};
use crate::data::Data;
use crate::error::{SolveError, lcp_error, simulation_error};
use crate::guard;
use crate::model::Model;
use crate::problem::ContactProblem;
use crate::report::name_of;
use crate::stepping::check_model;

/// `x⁺ = A x + B u + D λ + d`, `0 ≤ λ ⟂ E x + F λ + H u + c ≥ 0`, about a state.
#[pyclass(frozen, module = "signorini")]
pub struct LinearComplementaritySystem(System);

/// Getters of matrices, named by the field.
macro_rules! matrices {
    ($($(#[$doc:meta])* $name:ident, $getter:ident;)*) => {
        #[pymethods]
        impl LinearComplementaritySystem {
            $($(#[$doc])*
            #[getter($name)]
            fn $getter<'py>(&self, py: Python<'py>) -> PyResult<Table<'py>> {
                to_numpy(py, &self.0.$name)
            })*
        }
    };
}

matrices! {
    /// (2 nv, 2 nv).
    A, get_a;
    /// (2 nv, nu).
    B, get_b;
    /// (2 nv, nlambda).
    D, get_d_matrix;
    /// (nlambda, 2 nv).
    E, get_e;
    /// (nlambda, nlambda).
    F, get_f;
    /// (nlambda, nu).
    H, get_h;
}

#[pymethods]
impl LinearComplementaritySystem {
    /// (2 nv,).
    #[getter]
    fn d<'py>(&self, py: Python<'py>) -> Vector<'py> {
        arrays::vector(py, &self.0.d)
    }

    /// (nlambda,).
    #[getter]
    fn c<'py>(&self, py: Python<'py>) -> Vector<'py> {
        arrays::vector(py, &self.0.c)
    }

    /// The state about which it was made, (0, qvel), (2 nv,).
    #[getter]
    fn x<'py>(&self, py: Python<'py>) -> Vector<'py> {
        arrays::vector(py, &self.0.x)
    }

    /// The control about which it was made, (nu,).
    #[getter]
    fn u<'py>(&self, py: Python<'py>) -> Vector<'py> {
        arrays::vector(py, &self.0.u)
    }

    /// The contact problem of the step from there.
    #[getter]
    fn problem(&self) -> ContactProblem {
        ContactProblem::from(self.0.problem.clone())
    }

    /// One step of the system: `(x⁺, λ)`. Without `x` or `u`, those about which it was made.
    #[pyo3(signature = (x=None, u=None, method="automatic"))]
    fn step<'py>(
        &self,
        py: Python<'py>,
        x: Option<&Bound<'py, PyAny>>,
        u: Option<&Bound<'py, PyAny>>,
        method: &str,
    ) -> PyResult<(Vector<'py>, Vector<'py>)> {
        let system = &self.0;
        let given = |name, value: Option<&Bound<'py, PyAny>>, own: &[f64]| match value {
            Some(value) => arrays::read_vector(name, value, Some(own.len())),
            None => Ok(own.to_vec()),
        };
        let (x, u) = (given("x", x, &system.x)?, given("u", u, &system.u)?);
        let mut method = method.parse::<MethodKind>().and_then(|kind| kind.build()).map_err(lcp_error)?;
        let (next, lambda) = guard::detached(py, || -> PyResult<_> {
            let lcp = system.lcp(&x, &u).map_err(lcp_error)?;
            let solution = method.solve(&lcp, None);
            if !solution.status.is_solved() {
                let status = name_of(&solution.status);
                let message =
                    format!("the LCP of the step was not solved: {status}, residual {:.1e}", solution.residual.value);
                return Err(SolveError::new_err((message, status)));
            }
            Ok((system.next(&x, &u, &solution.z), solution.z))
        })??;
        Ok((arrays::vector(py, &next), arrays::vector(py, &lambda)))
    }

    fn __repr__(&self) -> String {
        format!(
            "<signorini.LinearComplementaritySystem x: {}, u: {}, lambda: {}>",
            self.0.x.len(),
            self.0.u.len(),
            self.0.c.len()
        )
    }
}

fn to_numpy<'py>(py: Python<'py>, matrix: &Matrix) -> PyResult<Table<'py>> {
    arrays::matrix(py, matrix.data().to_vec(), matrix.rows(), matrix.cols())
}

/// The linear complementarity system of a step from the present qpos, qvel, ctrl and qfrc_applied.
#[pyfunction]
#[pyo3(signature = (model, data, *, within=None))]
pub fn linearize(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    data: &Bound<'_, Data>,
    within: Option<f64>,
) -> PyResult<LinearComplementaritySystem> {
    check_model(model, data)?;
    let guard = data.get().loaded(py)?;
    let core = &*guard;
    let (model, state, input, settings) = (&core.model, &core.state, &core.input, &core.settings);
    let contacts = within.map_or(LinearizedContacts::OfStep, LinearizedContacts::Within);
    let system = guard::detached(py, || linear_complementarity_system_with(model, state, input, settings, &contacts))?;
    Ok(LinearComplementaritySystem(system.map_err(simulation_error)?))
}
