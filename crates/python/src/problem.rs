//! Contact problems alone: from matrices of the user's own, or from a step.

use std::path::PathBuf;

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use signorini::ContactMethod;
use signorini::contact::{
    self, ContactSolver, FrictionPolygon, WarmStart, certify, gap_contradiction, problem_file, solve_as_lcp,
};
use signorini::lcp::Matrix;
use signorini::multibody::BlockDiagonal;

use crate::arrays::{self, Table, Vector};
use crate::error::{ProblemError, problem_error};
use crate::guard;
use crate::report::Certificate;
use crate::settings::contact_method;
use crate::solution::ContactSolution;

/// The contact problem of one step as plain data.
#[pyclass(frozen, module = "signorini")]
pub struct ContactProblem {
    inner: contact::ContactProblem,
}

impl From<contact::ContactProblem> for ContactProblem {
    fn from(inner: contact::ContactProblem) -> Self {
        Self { inner }
    }
}

#[pymethods]
impl ContactProblem {
    #[new]
    #[pyo3(signature = (M, Jn, Jt, phi, mu, dt, v_free, directions=None, *, Jb=None, theta=None))]
    #[allow(non_snake_case, clippy::too_many_arguments)] // the arguments are the formulation's data
    fn new(
        M: &Bound<'_, PyAny>,
        Jn: &Bound<'_, PyAny>,
        Jt: &Bound<'_, PyAny>,
        phi: &Bound<'_, PyAny>,
        mu: &Bound<'_, PyAny>,
        dt: f64,
        v_free: &Bound<'_, PyAny>,
        directions: Option<&Bound<'_, PyAny>>,
        Jb: Option<&Bound<'_, PyAny>>,
        theta: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let v_free = arrays::read_vector("v_free", v_free, None)?;
        let nv = v_free.len();
        let (_, _, mass) = arrays::read_matrix("M", M, [Some(nv), Some(nv)])?;
        let phi = arrays::read_vector("phi", phi, None)?;
        let nc = phi.len();
        let mu = arrays::read_scalars("mu", mu, nc)?;
        let (_, _, normal) = arrays::read_matrix("Jn", Jn, [Some(nc), Some(nv)])?;
        let (_, _, tangential) = arrays::read_matrix("Jt", Jt, [Some(2 * nc), Some(nv)])?;
        let polygons = polygons(directions, nc)?;
        let mass = BlockDiagonal::from_dense(nv, &mass).map_err(|e| ProblemError::new_err(format!("M: {e}")))?;
        let mut problem = contact::ContactProblem::new(mass, v_free, dt).map_err(problem_error)?;
        for i in 0..nc {
            let entry = |k: usize| [normal[i * nv + k], tangential[2 * i * nv + k], tangential[(2 * i + 1) * nv + k]];
            let columns = (0..nv).map(|k| (k as u32, entry(k))).filter(|(_, e)| e.iter().any(|x| *x != 0.0));
            problem.push_contact(columns, phi[i], mu[i], &polygons[i]);
        }
        if let (Some(Jb), Some(theta)) = (Jb, theta) {
            let theta = arrays::read_vector("theta", theta, None)?;
            let (_, _, rows) = arrays::read_matrix("Jb", Jb, [Some(theta.len()), Some(nv)])?;
            for (k, violation) in theta.into_iter().enumerate() {
                let row = &rows[k * nv..(k + 1) * nv];
                let columns = row.iter().enumerate().filter(|(_, x)| **x != 0.0).map(|(j, &x)| (j as u32, [x]));
                problem.push_bilateral(columns, violation);
            }
        } else if Jb.is_some() || theta.is_some() {
            return Err(ProblemError::new_err("Jb and theta belong together: give both or neither"));
        }
        problem.check().map_err(problem_error)?;
        Ok(Self { inner: problem })
    }

    /// Reads a problem file (`.npz`).
    #[staticmethod]
    fn load(path: PathBuf) -> PyResult<Self> {
        match problem_file::read(&path).map_err(problem_error)? {
            problem_file::ProblemFile::Contact(problem) => Ok(Self { inner: *problem }),
            _ => Err(ProblemError::new_err(format!("{}: not a contact problem", path.display()))),
        }
    }

    /// Writes a problem file (`.npz`) for `signorini solve`, `signorini check` and `load`.
    fn save(&self, path: PathBuf) -> PyResult<()> {
        problem_file::write_contact(path, &self.inner).map_err(problem_error)
    }

    #[staticmethod]
    fn _from_bytes(bytes: Vec<u8>) -> PyResult<Self> {
        problem_file::contact_from_bytes(bytes).map(Self::from).map_err(problem_error)
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyBytes>,))> {
        let bytes = problem_file::contact_to_bytes(&slf.get().inner).map_err(problem_error)?;
        Ok((slf.get_type().getattr("_from_bytes")?, (PyBytes::new(slf.py(), &bytes),)))
    }

    /// Number of degrees of freedom.
    #[getter]
    fn nv(&self) -> usize {
        self.inner.nv()
    }

    /// Number of contacts.
    #[getter]
    fn nc(&self) -> usize {
        self.inner.contact_count()
    }

    /// Mass matrix, (nv, nv), kg, kg·m, kg·m²; in a step the effective one, with implicit springs and dampers.
    #[getter(M)]
    fn mass<'py>(&self, py: Python<'py>) -> PyResult<Table<'py>> {
        arrays::fixed(arrays::matrix(py, self.inner.mass.to_dense(), self.nv(), self.nv())?)
    }

    /// Normal Jacobian, (nc, nv).
    #[getter(Jn)]
    fn normal_jacobian<'py>(&self, py: Python<'py>) -> PyResult<Table<'py>> {
        arrays::fixed(self.jacobian(py, &[0])?)
    }

    /// Tangential Jacobian, (2 nc, nv): rows 2i and 2i + 1 are those of contact i.
    #[getter(Jt)]
    fn tangential_jacobian<'py>(&self, py: Python<'py>) -> PyResult<Table<'py>> {
        arrays::fixed(self.jacobian(py, &[1, 2])?)
    }

    /// Jacobian of the bilateral rows, (nb, nv).
    #[getter(Jb)]
    fn bilateral_jacobian<'py>(&self, py: Python<'py>) -> PyResult<Table<'py>> {
        let (nb, nv) = (self.inner.bilateral_violation.len(), self.nv());
        let mut dense = vec![0.0; nb * nv];
        for k in 0..nb {
            let (columns, entries) = self.inner.bilateral_jacobian.group(k);
            columns.iter().zip(entries).for_each(|(&c, e)| dense[k * nv + c as usize] = e[0]);
        }
        arrays::fixed(arrays::matrix(py, dense, nb, nv)?)
    }

    /// Violations of the bilateral rows, (nb,), m or rad.
    #[getter]
    fn theta<'py>(&self, py: Python<'py>) -> PyResult<Vector<'py>> {
        arrays::fixed(arrays::vector(py, &self.inner.bilateral_violation))
    }

    /// Gaps, (nc,), m.
    #[getter]
    fn phi<'py>(&self, py: Python<'py>) -> PyResult<Vector<'py>> {
        arrays::fixed(arrays::vector(py, &self.inner.gap))
    }

    /// Coefficients of friction, (nc,).
    #[getter]
    fn mu<'py>(&self, py: Python<'py>) -> PyResult<Vector<'py>> {
        arrays::fixed(arrays::vector(py, &self.inner.friction))
    }

    /// Time step, s.
    #[getter]
    fn dt(&self) -> f64 {
        self.inner.timestep
    }

    /// Velocity without contact, (nv,), m/s, rad/s.
    #[getter]
    fn v_free<'py>(&self, py: Python<'py>) -> PyResult<Vector<'py>> {
        arrays::fixed(arrays::vector(py, &self.inner.free_velocity))
    }

    /// Friction directions of all contacts, (m, 2), contact after contact.
    #[getter(D)]
    fn all_directions<'py>(&self, py: Python<'py>) -> PyResult<Table<'py>> {
        arrays::fixed(arrays::rows(py, self.inner.directions.iter().copied())?)
    }

    /// Where each contact's directions begin in `D`, (nc + 1,).
    #[getter]
    fn direction_offsets<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<i64>>> {
        arrays::fixed(PyArray1::from_iter(py, self.inner.direction_offsets.iter().map(|&k| k as i64)))
    }

    /// The standard LCP in z = (lambda_n, alpha, beta): (A, b).
    fn lcp<'py>(&self, py: Python<'py>) -> PyResult<(Table<'py>, Vector<'py>)> {
        let lcp = self.inner.standard_lcp().map_err(problem_error)?;
        Ok((dense(py, lcp.A())?, arrays::vector(py, lcp.b())))
    }

    /// The mixed LCP in (v, lambda_b, lambda_n, alpha, beta): (A, b, free).
    #[allow(clippy::type_complexity)]
    fn mixed_lcp<'py>(&self, py: Python<'py>) -> PyResult<(Table<'py>, Vector<'py>, Bound<'py, PyArray1<bool>>)> {
        let lcp = self.inner.mixed_lcp().map_err(problem_error)?;
        Ok((dense(py, lcp.A())?, arrays::vector(py, lcp.b()), PyArray1::from_slice(py, lcp.free())))
    }

    /// Solves the problem; the GIL is released meanwhile.
    #[pyo3(signature = (method="structured", *, tolerance=1e-9, warm_start=None, record_history=false))]
    fn solve(
        &self,
        py: Python<'_>,
        method: &str,
        tolerance: f64,
        warm_start: Option<&Bound<'_, ContactSolution>>,
        record_history: bool,
    ) -> PyResult<ContactSolution> {
        let method = contact_method(method, tolerance)?;
        let warm = warm_start.map(|earlier| {
            let earlier = &earlier.get().0;
            let mut warm = WarmStart::default();
            (0..self.nc()).for_each(|i| warm.push(earlier, Some(i)));
            warm.set_bilateral(&earlier.bilateral);
            warm
        });
        let solution = guard::detached(py, || match method {
            ContactMethod::Lcp(kind) => solve_as_lcp(&self.inner, kind.build()?.as_mut(), tolerance),
            ContactMethod::Structured(settings) => {
                let settings = settings.with_time_stages(true).with_record_history(record_history);
                Ok(ContactSolver::new(settings)?.solve(&self.inner, warm.as_ref()))
            }
        })?;
        Ok(ContactSolution(solution.map_err(problem_error)?))
    }

    /// Residuals of a claimed solution, computed from the data alone.
    #[pyo3(signature = (v, lambda_n, alpha, beta, lambda_b=None, *, alpha_f=None, beta_f=None))]
    #[allow(clippy::too_many_arguments)]
    fn certify(
        &self,
        v: &Bound<'_, PyAny>,
        lambda_n: &Bound<'_, PyAny>,
        alpha: &Bound<'_, PyAny>,
        beta: &Bound<'_, PyAny>,
        lambda_b: Option<&Bound<'_, PyAny>>,
        alpha_f: Option<&Bound<'_, PyAny>>,
        beta_f: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Certificate> {
        let (nc, m, nb) = (self.nc(), self.inner.direction_count(), self.inner.bilateral_violation.len());
        let (velocity, lambda_n) =
            (arrays::read_vector("v", v, Some(self.nv()))?, arrays::read_vector("lambda_n", lambda_n, Some(nc))?);
        let mut claimed = contact::ContactSolution::default();
        (claimed.velocity, claimed.lambda_n) = (velocity, lambda_n);
        claimed.alpha = arrays::read_vector("alpha", alpha, Some(m))?;
        claimed.beta = arrays::read_vector("beta", beta, Some(nc))?;
        claimed.bilateral = match lambda_b {
            Some(lambda_b) => arrays::read_vector("lambda_b", lambda_b, Some(nb))?,
            None => vec![0.0; nb],
        };
        let groups = &self.inner.friction_groups;
        claimed.group_alpha = self.of_groups("alpha_f", alpha_f, groups.direction_count())?;
        claimed.group_beta = self.of_groups("beta_f", beta_f, groups.len())?;
        Ok(Certificate(certify(&self.inner, &claimed)))
    }

    /// Multipliers that prove that no velocity satisfies the gap rows and bilateral rows together.
    fn contradiction<'py>(&self, py: Python<'py>) -> PyResult<Option<(Vector<'py>, Vector<'py>, f64)>> {
        let proof = guard::detached(py, || gap_contradiction(&self.inner, &[]))?;
        Ok(proof.map(|proof| {
            let residual = proof.residual(&self.inner);
            (arrays::vector(py, &proof.normal), arrays::vector(py, &proof.bilateral), residual)
        }))
    }

    fn __repr__(&self) -> String {
        let m = self.inner.direction_count();
        format!("<signorini.ContactProblem nv = {}, {} contacts, {m} friction directions>", self.nv(), self.nc())
    }
}

impl ContactProblem {
    /// Numbers of the friction groups, which a claimed solution must have where there are some.
    fn of_groups(&self, name: &str, value: Option<&Bound<'_, PyAny>>, count: usize) -> PyResult<Vec<f64>> {
        match value {
            Some(value) => arrays::read_vector(name, value, Some(count)),
            None if count == 0 => Ok(Vec::new()),
            None => Err(ProblemError::new_err(format!(
                "the problem has friction that is no contact's sliding (of joints, servos and belts, spinning, rolling), whose {count} \
                 numbers {name} are missing: give them, of a solution of ours solution.{name}"
            ))),
        }
    }

    /// Some rows of every contact's group.
    fn jacobian<'py>(&self, py: Python<'py>, rows: &[usize]) -> PyResult<Table<'py>> {
        let (nc, nv) = (self.nc(), self.nv());
        let mut out = vec![0.0; rows.len() * nc * nv];
        for i in 0..nc {
            let (columns, entries) = self.inner.jacobian.group(i);
            for (place, &r) in rows.iter().enumerate() {
                let start = (rows.len() * i + place) * nv;
                columns.iter().zip(entries).for_each(|(&c, e)| out[start + c as usize] = e[r]);
            }
        }
        arrays::matrix(py, out, rows.len() * nc, nv)
    }
}

fn dense<'py>(py: Python<'py>, matrix: &Matrix) -> PyResult<Table<'py>> {
    arrays::matrix(py, matrix.data().to_vec(), matrix.rows(), matrix.cols())
}

/// The friction polygon of every contact: a number of directions for all, or one (m_i, 2) array per contact. Default 8.
fn polygons(directions: Option<&Bound<'_, PyAny>>, nc: usize) -> PyResult<Vec<FrictionPolygon>> {
    let count = directions.map_or(Some(8), |d| d.extract::<usize>().ok());
    if let Some(count) = count {
        return Ok(vec![FrictionPolygon::regular(count, 0.0).map_err(problem_error)?; nc]);
    }
    let lists: Vec<Bound<'_, PyAny>> = directions.map_or(Ok(Vec::new()), |d| d.extract())?;
    if lists.len() != nc {
        let message =
            format!("directions has {} arrays for {nc} contacts: give one for each, or a number", lists.len());
        return Err(ProblemError::new_err(message));
    }
    let polygon = |(i, list): (usize, &Bound<'_, PyAny>)| {
        let (_, _, entries) = arrays::read_matrix(&format!("directions[{i}]"), list, [None, Some(2)])?;
        let own = entries.chunks_exact(2).map(|d| [d[0], d[1]]).collect();
        FrictionPolygon::from_directions(own).map_err(|e| ProblemError::new_err(format!("directions[{i}]: {e}")))
    };
    lists.iter().enumerate().map(polygon).collect()
}
