//! Simulations of a batch by their indices, wherever Python asks for some.

use pyo3::exceptions::{PyIndexError, PyTypeError};
use pyo3::prelude::*;

/// Indices as they were given; negative ones count from the end.
pub struct Simulations(Vec<isize>);

impl<'a, 'py> FromPyObject<'a, 'py> for Simulations {
    type Error = PyErr;

    fn extract(given: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        given.try_iter()?.map(|index| index_of(&index?)).collect::<PyResult<_>>().map(Self)
    }
}

impl Simulations {
    /// The indices among so many simulations.
    pub fn among(&self, count: usize) -> PyResult<Vec<usize>> {
        self.0.iter().map(|index| simulation(*index, count)).collect()
    }
}

/// The index of a simulation among so many; an `IndexError` where there is none.
pub fn simulation(index: isize, count: usize) -> PyResult<usize> {
    let from_start = if index < 0 { index.checked_add_unsigned(count) } else { Some(index) };
    let found = from_start.and_then(|i| usize::try_from(i).ok()).filter(|i| *i < count);
    found.ok_or_else(|| PyIndexError::new_err(format!("simulation {index}: the batch has {count}")))
}

/// An index; no truth value, which Python would take for 0 or 1: a mask would choose the first two simulations.
fn index_of(given: &Bound<'_, PyAny>) -> PyResult<isize> {
    let sort = given.get_type().name()?.to_string();
    if matches!(sort.as_str(), "bool" | "bool_") {
        return Err(PyTypeError::new_err(
            "simulations are asked for by their indices, not by truth values: numpy.flatnonzero(mask) gives those of a mask",
        ));
    }
    given.extract()
}
