//! NumPy arrays made and read by copying.

use numpy::{IntoPyArray, PyArray1, PyArray2, PyArray3, PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::PyTypeError;
use pyo3::intern;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use signorini::multibody::glam::DVec3;

use crate::error::ProblemError;

/// An array with one axis.
pub type Vector<'py> = Bound<'py, PyArray1<f64>>;

/// An array with two axes.
pub type Table<'py> = Bound<'py, PyArray2<f64>>;

/// An array with three axes.
pub type Cube<'py> = Bound<'py, PyArray3<f64>>;

/// A new array of rows.
pub fn rows<'py, const N: usize>(py: Python<'py>, rows: impl Iterator<Item = [f64; N]>) -> PyResult<Table<'py>> {
    let data: Vec<f64> = rows.flatten().collect();
    let count = data.len() / N;
    matrix(py, data, count, N)
}

/// A new matrix from its entries, row after row.
pub fn matrix<'py>(py: Python<'py>, data: Vec<f64>, rows: usize, cols: usize) -> PyResult<Table<'py>> {
    data.into_pyarray(py).reshape([rows, cols])
}

/// A new array with three axes.
pub fn cube<'py>(py: Python<'py>, data: Vec<f64>, shape: [usize; 3]) -> PyResult<Cube<'py>> {
    data.into_pyarray(py).reshape(shape)
}

/// A new array with any number of axes.
pub fn array<'py>(py: Python<'py>, data: Vec<f64>, shape: &[usize]) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    data.into_pyarray(py).reshape(shape)
}

/// A new array of numbers.
pub fn vector<'py>(py: Python<'py>, numbers: &[f64]) -> Vector<'py> {
    PyArray1::from_slice(py, numbers)
}

/// A new array of a vector's components.
pub fn vector3<'py>(py: Python<'py>, v: DVec3) -> Vector<'py> {
    PyArray1::from_slice(py, &v.to_array())
}

/// The array, which can be read only: NumPy refuses to write to what would change a copy.
pub fn fixed<'py, T>(array: Bound<'py, T>) -> PyResult<Bound<'py, T>> {
    let flags = PyDict::new(array.py());
    flags.set_item("write", false)?;
    array.as_any().call_method("setflags", (), Some(&flags))?;
    Ok(array)
}

/// Whatever NumPy or SciPy can make an array of `f64` of: its shape and entries, row after row.
fn read(name: &str, value: &Bound<'_, PyAny>) -> PyResult<(Vec<usize>, Vec<f64>)> {
    let py = value.py();
    let dense = match value.getattr_opt(intern!(py, "toarray"))? {
        Some(to_array) => to_array.call0()?,
        None => value.clone(),
    };
    let unreadable = |reason: &dyn std::fmt::Display| {
        ProblemError::new_err(format!("{name} cannot be read as an array of numbers: {reason}"))
    };
    let numpy = py.import(intern!(py, "numpy"))?;
    let given = numpy.call_method1(intern!(py, "asarray"), (dense,)).map_err(|e| unreadable(&e))?;
    // NumPy would leave imaginary parts out with a warning.
    if given.getattr(intern!(py, "dtype"))?.getattr(intern!(py, "kind"))?.extract::<char>()? == 'c' {
        return Err(unreadable(&"it has complex numbers"));
    }
    let options = PyDict::new(py);
    options.set_item("dtype", "float64")?;
    options.set_item("order", "C")?;
    let array = numpy.call_method(intern!(py, "asarray"), (given,), Some(&options)).map_err(|e| unreadable(&e))?;
    let array = array.cast::<PyArrayDyn<f64>>()?;
    let entries = array.try_readonly()?.as_slice()?.to_vec();
    Ok((array.shape().to_vec(), entries))
}

/// The value, where it is not `None` and lists none, which NumPy would take for NaN.
pub fn without_none<'a, 'py>(name: &str, value: &'a Bound<'py, PyAny>) -> PyResult<&'a Bound<'py, PyAny>> {
    // Most are arrays of numbers, assigned in every step.
    if value.cast::<PyArrayDyn<f64>>().is_ok() {
        return Ok(value);
    }
    let py = value.py();
    let array = py.import(intern!(py, "numpy"))?.call_method1(intern!(py, "asarray"), (value,))?;
    let is_object = array.getattr(intern!(py, "dtype"))?.getattr(intern!(py, "hasobject"))?.is_truthy()?;
    if is_object && array.getattr(intern!(py, "flat"))?.try_iter()?.any(|x| x.is_ok_and(|x| x.is_none())) {
        return Err(PyTypeError::new_err(format!("{name}: None is no number")));
    }
    Ok(value)
}

/// A vector from Python, of `expected` entries where that is known.
pub fn read_vector(name: &str, value: &Bound<'_, PyAny>, expected: Option<usize>) -> PyResult<Vec<f64>> {
    let (shape, entries) = read(name, value)?;
    match (&shape[..], expected) {
        ([n], Some(expected)) if *n == expected => Ok(entries),
        ([_], None) => Ok(entries),
        (_, Some(n)) => Err(wrong_shape(name, &shape, &format!("({n},)"))),
        (_, None) => Err(wrong_shape(name, &shape, "one axis")),
    }
}

/// A number for each of `count` things; one number stands for all.
pub fn read_scalars(name: &str, value: &Bound<'_, PyAny>, count: usize) -> PyResult<Vec<f64>> {
    let (shape, entries) = read(name, value)?;
    match (&shape[..], &entries[..]) {
        ([], [x]) => Ok(vec![*x; count]),
        _ => read_vector(name, value, Some(count)),
    }
}

/// A dense or sparse matrix from Python of a known shape, `None` where a size may be anything.
pub fn read_matrix(
    name: &str,
    value: &Bound<'_, PyAny>,
    expected: [Option<usize>; 2],
) -> PyResult<(usize, usize, Vec<f64>)> {
    let (shape, entries) = read(name, value)?;
    match shape[..] {
        [r, c] if expected[0].is_none_or(|e| e == r) && expected[1].is_none_or(|e| e == c) => Ok((r, c, entries)),
        _ => {
            let sizes = expected.map(|e| e.map_or("any".to_owned(), |e| e.to_string()));
            Err(wrong_shape(name, &shape, &format!("({}, {})", sizes[0], sizes[1])))
        }
    }
}

/// An array of three axes from Python of a known shape, `None` where a size may be anything: its shape and entries.
pub fn read_cube(
    name: &str,
    value: &Bound<'_, PyAny>,
    expected: [Option<usize>; 3],
) -> PyResult<([usize; 3], Vec<f64>)> {
    let (shape, entries) = read(name, value)?;
    match <[usize; 3]>::try_from(&shape[..]) {
        Ok(sizes) if sizes.iter().zip(expected).all(|(s, e)| e.is_none_or(|e| e == *s)) => Ok((sizes, entries)),
        _ => {
            let sizes = expected.map(|e| e.map_or("any".to_owned(), |e| e.to_string()));
            Err(wrong_shape(name, &shape, &format!("({})", sizes.join(", "))))
        }
    }
}

fn wrong_shape(name: &str, shape: &[usize], expected: &str) -> PyErr {
    ProblemError::new_err(format!("{name} has shape {shape:?}, expected {expected}"))
}
