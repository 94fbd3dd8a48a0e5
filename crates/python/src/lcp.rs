//! Complementarity problems alone.

use numpy::PyArray1;
use pyo3::prelude::*;
use signorini::lcp::{
    Basis, Exclusion, Lcp, LcpError, Matrix, MethodKind, MixedLcp, PairCase, Solution, Status, decide, solve_mixed,
};

use crate::arrays::{self, Vector};
use crate::error::{ProblemError, lcp_error};
use crate::guard;
use crate::report::name_of;

/// An excluded case: pairs with z = 0, pairs with w = 0, multipliers.
type Case<'py> = (Vec<usize>, Vec<usize>, Vector<'py>);

/// The end of a run of a method on a complementarity problem.
#[pyclass(frozen, module = "signorini")]
pub struct LcpResult {
    solution: Solution,
    exclusion: Option<Exclusion>,
}

#[pymethods]
impl LcpResult {
    /// The point, (n,); the best one found where the problem was not solved.
    #[getter]
    fn z<'py>(&self, py: Python<'py>) -> Vector<'py> {
        arrays::vector(py, &self.solution.z)
    }

    /// `w = A z + b`, (n,).
    #[getter]
    fn w<'py>(&self, py: Python<'py>) -> Vector<'py> {
        arrays::vector(py, &self.solution.w)
    }

    /// "solved", "inaccurate", "unresolved", "infeasible", "no_solution", "iteration_limit", "inconsistent", "singular", "too_large".
    #[getter]
    fn status(&self) -> String {
        match &self.solution.status {
            Status::Ray(_) => "unresolved".into(),
            Status::NoSolution if self.exclusion.is_none() => "unresolved".into(),
            status => name_of(status),
        }
    }

    /// Whether the residual is within the method's tolerance.
    #[getter]
    fn solved(&self) -> bool {
        self.solution.status.is_solved()
    }

    /// Natural-map residual of `z` in the original data, relative to max |b|.
    #[getter]
    fn residual(&self) -> f64 {
        self.solution.residual.value
    }

    /// Pivots (Lemke) or bases (enumeration).
    #[getter]
    fn iterations(&self) -> usize {
        self.solution.iterations
    }

    /// Which `z` are basic, (n,): a warm start for a similar problem.
    #[getter]
    fn basis<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<bool>> {
        PyArray1::from_slice(py, &self.solution.basis.z_basic)
    }

    /// Direction in `z` of the ray on which Lemke's path ended, (n,); `None` where it did not.
    #[getter]
    fn ray<'py>(&self, py: Python<'py>) -> Option<Vector<'py>> {
        match &self.solution.status {
            Status::Ray(ray) => Some(arrays::vector(py, &ray.z)),
            _ => None,
        }
    }

    /// A proof that no `z ≥ 0` has `A z + b ≥ 0`: `y ≥ 0`, `Aᵀ y ≤ 0`, `bᵀ y < 0`, (n,); `None` where none was found.
    #[getter]
    fn farkas<'py>(&self, py: Python<'py>) -> Option<Vector<'py>> {
        match &self.solution.status {
            Status::Infeasible(farkas) => Some(arrays::vector(py, &farkas.y)),
            _ => None,
        }
    }

    /// What was excluded, where there is a proof that there is no solution: cases that together are all, each as (pairs with z = 0, pairs
    /// with w = 0, multipliers); `None` where there is none.
    #[getter]
    fn exclusion<'py>(&self, py: Python<'py>) -> Option<Vec<Case<'py>>> {
        let cases = &self.exclusion.as_ref()?.cases;
        let decided = |pairs: &[PairCase], to| (0..pairs.len()).filter(|&i| pairs[i] == to).collect();
        let case = |case: &signorini::lcp::ExcludedCase| {
            let pairs = &case.pairs;
            (decided(pairs, PairCase::NoZ), decided(pairs, PairCase::NoW), arrays::vector(py, &case.multipliers))
        };
        Some(cases.iter().map(case).collect())
    }

    fn __repr__(&self) -> String {
        let s = &self.solution;
        let (status, n) = (self.status(), s.z.len());
        format!(
            "<signorini.LcpResult {status}: {n} pairs, residual {:.1e}, {} iterations>",
            s.residual.value, s.iterations
        )
    }
}

/// Names of the methods that `solve_lcp` knows.
#[pyfunction]
pub fn lcp_methods() -> Vec<String> {
    MethodKind::all().iter().map(ToString::to_string).collect()
}

/// Finds `z` with `0 ≤ z ⟂ w = A z + b ≥ 0`; on rows that are `free`, `w = 0` and `z` has any sign.
#[pyfunction]
#[pyo3(signature = (A, b, method="automatic", *, free=None, warm_start=None, explain=true))]
#[allow(non_snake_case)]
pub fn solve_lcp(
    py: Python<'_>,
    A: &Bound<'_, PyAny>,
    b: &Bound<'_, PyAny>,
    method: &str,
    free: Option<Vec<bool>>,
    warm_start: Option<Vec<bool>>,
    explain: bool,
) -> PyResult<LcpResult> {
    let (rows, cols, entries) = arrays::read_matrix("A", A, [None, None])?;
    let b = arrays::read_vector("b", b, Some(rows))?;
    let A = Matrix::new(rows, cols, entries).map_err(lcp_error)?;
    let mut method = method.parse::<MethodKind>().and_then(|kind| kind.build()).map_err(lcp_error)?;
    if let Some(given) = warm_start.as_ref().filter(|given| given.len() != rows) {
        return Err(ProblemError::new_err(format!(
            "warm_start has {} entries, expected {rows}, one for each row of A",
            given.len()
        )));
    }
    let warm = warm_start.map(|z_basic| Basis { z_basic });
    guard::detached(py, || -> Result<LcpResult, LcpError> {
        let (mixed, mut solution) = match free {
            Some(free) => {
                let problem = MixedLcp::new(A, b, free)?;
                let solution = solve_mixed(&problem, method.as_mut(), warm.as_ref());
                (problem, solution)
            }
            None => {
                let problem = Lcp::new(A, b)?;
                let solution = method.solve(&problem, warm.as_ref());
                (problem.into(), solution)
            }
        };
        let exclusion = if explain { decide(&mixed, &mut solution) } else { None };
        Ok(LcpResult { solution, exclusion })
    })?
    .map_err(lcp_error)
}
