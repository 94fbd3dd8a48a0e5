//! Derivatives of the step just made.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use signorini::derivatives::{Direction, InequalitySource, Margin as RustMargin, StepDerivatives as Rust, Validity};
use signorini::lcp::Matrix;

use crate::arrays::{self, Table, Vector};
use crate::data::{Data, need_step};
use crate::directions::directions_of;
use crate::guard;
use crate::model::Model;
use crate::stepping::check_model;

/// How far an inequality of a step is from turning.
#[pyclass(frozen, module = "signorini")]
pub struct Margin {
    /// What it belongs to.
    #[pyo3(get)]
    source: String,
    /// Index of the contact, group, row, joint or tendon it belongs to; none for points that are not in the step's problem.
    #[pyo3(get)]
    index: Option<usize>,
    /// Which of its inequalities.
    #[pyo3(get)]
    kind: String,
    /// Its distance from turning.
    #[pyo3(get)]
    value: f64,
}

#[pymethods]
impl Margin {
    fn __repr__(&self) -> String {
        let index = self.index.map_or(String::new(), |i| format!(" {i}"));
        format!("<signorini.Margin {}{index}, {}: {:.2e}>", self.source, self.kind, self.value)
    }
}

impl From<&RustMargin> for Margin {
    fn from(margin: &RustMargin) -> Self {
        let (source, index) = match margin.source {
            InequalitySource::Contact(i) => ("contact", Some(i)),
            InequalitySource::FrictionGroup(j) => ("friction group", Some(j)),
            InequalitySource::Bilateral(k) => ("bilateral row", Some(k)),
            InequalitySource::Candidate(_) => ("candidate", None),
            InequalitySource::JointLimit(joint) => ("joint limit", Some(joint.index())),
            InequalitySource::TendonLimit(tendon) => ("tendon limit", Some(tendon.index())),
            _ => ("range", None),
        };
        Self { source: source.into(), index, kind: snake_case(&format!("{:?}", margin.kind)), value: margin.value }
    }
}

/// `NormalImpulse` as `normal_impulse`.
fn snake_case(name: &str) -> String {
    let mut out = String::new();
    for c in name.chars() {
        if c.is_uppercase() && !out.is_empty() {
            out.push('_');
        }
        out.extend(c.to_lowercase());
    }
    out
}

/// The derivative of a step, with the flag that says whether it exists.
#[pyclass(frozen, module = "signorini")]
pub struct StepDerivatives {
    inner: Rust,
    nv: usize,
    nu: usize,
}

/// Steps every simulation of a batch and takes the derivatives.
pub fn step_batch(batch: &mut signorini::Batch, parameters: Vec<Direction>) -> Vec<StepDerivatives> {
    let (nv, nu) = (batch.model().nv, batch.model().actuators.len());
    let mut all = vec![Rust::with_parameters(batch.model(), parameters); batch.len()];
    Rust::step_batch(batch, &mut all);
    all.into_iter().map(|inner| StepDerivatives { inner, nv, nu }).collect()
}

#[pymethods]
impl StepDerivatives {
    /// "exact", "one_sided" or "refused".
    #[getter]
    fn validity(&self) -> &'static str {
        match self.inner.validity() {
            Validity::Exact => "exact",
            Validity::OneSided { .. } => "one_sided",
            _ => "refused",
        }
    }

    /// Why there is no derivative; none where there is one.
    #[getter]
    fn reason(&self) -> Option<String> {
        match self.inner.validity() {
            Validity::Refused { reason } => Some(reason.clone()),
            _ => None,
        }
    }

    /// The inequalities that are about to turn, where the derivative is one-sided.
    #[getter]
    fn deciding(&self) -> Vec<Margin> {
        match self.inner.validity() {
            Validity::OneSided { deciding } => deciding.iter().map(Margin::from).collect(),
            _ => Vec::new(),
        }
    }

    /// How far every inequality of the step is from turning.
    #[getter]
    fn margins(&self) -> Vec<Margin> {
        self.inner.margins().iter().map(Margin::from).collect()
    }

    /// ∂(q⁺, v⁺)/∂(q, v), (2 nv, 2 nv).
    #[getter(A)]
    fn state_matrix<'py>(&self, py: Python<'py>) -> PyResult<Table<'py>> {
        self.table(py, self.inner.state_matrix())
    }

    /// ∂(q⁺, v⁺)/∂ctrl, (2 nv, nu).
    #[getter(B)]
    fn control_matrix<'py>(&self, py: Python<'py>) -> PyResult<Table<'py>> {
        self.table(py, self.inner.control_matrix())
    }

    /// ∂(q⁺, v⁺)/∂qfrc_applied, (2 nv, nv).
    #[getter(B_force)]
    fn force_matrix<'py>(&self, py: Python<'py>) -> PyResult<Table<'py>> {
        self.table(py, self.inner.force_matrix())
    }

    /// ∂(q⁺, v⁺) by the parameters asked for, (2 nv, number of parameters).
    #[getter(P)]
    fn parameter_matrix<'py>(&self, py: Python<'py>) -> PyResult<Table<'py>> {
        let matrix = self.inner.parameter_matrix().map_err(PyValueError::new_err)?;
        arrays::matrix(py, matrix.data().to_vec(), matrix.rows(), matrix.cols())
    }

    /// The gradient by the parameters of a function whose gradient by (q⁺, v⁺) is given.
    #[pyo3(signature = (gq=None, gv=None))]
    fn parameter_vjp<'py>(
        &self,
        py: Python<'py>,
        gq: Option<&Bound<'py, PyAny>>,
        gv: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Vector<'py>> {
        self.inner.parameter_matrix().map_err(PyValueError::new_err)?;
        let begin = self.gradient(gq, gv)?;
        Ok(arrays::vector(py, &begin[3 * self.nv + self.nu..]))
    }

    /// The change of (q⁺, v⁺) with a change of the arguments.
    #[pyo3(signature = (dq=None, dv=None, dctrl=None, dqfrc=None))]
    fn jvp<'py>(
        &self,
        py: Python<'py>,
        dq: Option<&Bound<'py, PyAny>>,
        dv: Option<&Bound<'py, PyAny>>,
        dctrl: Option<&Bound<'py, PyAny>>,
        dqfrc: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<(Vector<'py>, Vector<'py>)> {
        let change = self.change(dq, dv, dctrl, dqfrc)?;
        let nv = self.nv;
        let end = self.inner.product(&change).ok_or_else(|| self.none())?;
        Ok((arrays::vector(py, &end[..nv]), arrays::vector(py, &end[nv..])))
    }

    /// The change of (q⁺, v⁺) to the side of a change of the arguments, at ties, too.
    #[pyo3(signature = (dq=None, dv=None, dctrl=None, dqfrc=None))]
    fn directional<'py>(
        &self,
        py: Python<'py>,
        dq: Option<&Bound<'py, PyAny>>,
        dv: Option<&Bound<'py, PyAny>>,
        dctrl: Option<&Bound<'py, PyAny>>,
        dqfrc: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<(Vector<'py>, Vector<'py>)> {
        let change = self.change(dq, dv, dctrl, dqfrc)?;
        let end = self.inner.directional(&change).map_err(PyValueError::new_err)?;
        Ok((arrays::vector(py, &end[..self.nv]), arrays::vector(py, &end[self.nv..])))
    }

    /// The gradient by (q, v, ctrl, qfrc_applied) of a function whose gradient by (q⁺, v⁺) is given.
    #[pyo3(signature = (gq=None, gv=None))]
    #[allow(clippy::type_complexity)]
    fn vjp<'py>(
        &self,
        py: Python<'py>,
        gq: Option<&Bound<'py, PyAny>>,
        gv: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<(Vector<'py>, Vector<'py>, Vector<'py>, Vector<'py>)> {
        let (nv, nu) = (self.nv, self.nu);
        let begin = self.gradient(gq, gv)?;
        let (q, rest) = begin.split_at(nv);
        let (v, rest) = rest.split_at(nv);
        let (ctrl, rest) = rest.split_at(nu);
        let force = &rest[..nv];
        let of = |numbers: &[f64]| arrays::vector(py, numbers);
        Ok((of(q), of(v), of(ctrl), of(force)))
    }

    fn __repr__(&self) -> String {
        match self.inner.validity() {
            Validity::Refused { reason } => format!("<signorini.StepDerivatives refused: {reason}>"),
            _ => format!("<signorini.StepDerivatives {}, nv: {}, nu: {}>", self.validity(), self.nv, self.nu),
        }
    }
}

impl StepDerivatives {
    fn table<'py>(&self, py: Python<'py>, matrix: Option<Matrix>) -> PyResult<Table<'py>> {
        let matrix = matrix.ok_or_else(|| self.none())?;
        arrays::matrix(py, matrix.data().to_vec(), matrix.rows(), matrix.cols())
    }

    /// A change of the arguments as one list.
    fn change(
        &self,
        dq: Option<&Bound<'_, PyAny>>,
        dv: Option<&Bound<'_, PyAny>>,
        dctrl: Option<&Bound<'_, PyAny>>,
        dqfrc: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Vec<f64>> {
        let (nv, nu) = (self.nv, self.nu);
        let mut change = Vec::with_capacity(3 * nv + nu);
        for (name, given, n) in [("dq", dq, nv), ("dv", dv, nv), ("dctrl", dctrl, nu), ("dqfrc", dqfrc, nv)] {
            match given {
                Some(given) => change.extend(arrays::read_vector(name, given, Some(n))?),
                None => change.resize(change.len() + n, 0.0),
            }
        }
        Ok(change)
    }

    /// By (q, v, ctrl, qfrc_applied) and the parameters.
    fn gradient(&self, gq: Option<&Bound<'_, PyAny>>, gv: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<f64>> {
        let nv = self.nv;
        let mut gradient = Vec::with_capacity(2 * nv);
        for (name, given) in [("gq", gq), ("gv", gv)] {
            match given {
                Some(given) => gradient.extend(arrays::read_vector(name, given, Some(nv))?),
                None => gradient.resize(gradient.len() + nv, 0.0),
            }
        }
        self.inner.transposed_product(&gradient).ok_or_else(|| self.none())
    }

    fn none(&self) -> PyErr {
        let reason = self.reason().unwrap_or_default();
        PyValueError::new_err(format!("this step has no derivative: {reason}"))
    }
}

/// The derivative of the step just made.
#[pyfunction]
#[pyo3(signature = (model, data, parameters=None, *, twice=false))]
pub fn derivatives(
    py: Python<'_>,
    model: &Bound<'_, Model>,
    data: &Bound<'_, Data>,
    parameters: Option<&Bound<'_, PyAny>>,
    twice: bool,
) -> PyResult<StepDerivatives> {
    check_model(model, data)?;
    let parameters = parameters.map(|given| directions_of(&model.get().inner, given)).transpose()?.unwrap_or_default();
    let mut guard = data.get().core()?;
    need_step(&guard)?;
    let core = &mut *guard;
    let inner = guard::detached(py, || core.derivatives(parameters, twice))?;
    Ok(StepDerivatives { inner, nv: core.model.nv, nu: core.model.actuators.len() })
}
