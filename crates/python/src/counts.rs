//! Counts among the arguments of Python: whole numbers from 0 on, whose errors have the argument's name.

use pyo3::conversion::FromPyObjectOwned;
use pyo3::exceptions::{PyOverflowError, PyValueError};
use pyo3::prelude::*;

fn read<'py, T: FromPyObjectOwned<'py>>(name: &str, value: &Bound<'py, PyAny>) -> PyResult<T> {
    value.extract::<T>().map_err(Into::into).map_err(|error| {
        if !error.is_instance_of::<PyOverflowError>(value.py()) {
            return error;
        }
        let problem = if value.lt(0).unwrap_or(false) { "must not be negative" } else { "is too large" };
        PyValueError::new_err(format!("{name} = {value}: {problem}"))
    })
}

macro_rules! counts {
    ($($name:ident)*) => {
        $(
            #[doc = concat!("The argument `", stringify!($name), "`.")]
            pub fn $name<'py, T: FromPyObjectOwned<'py>>(value: &Bound<'py, PyAny>) -> PyResult<T> {
                read(stringify!($name), value)
            }
        )*
    };
}

counts! {
    columns count courses draws enumeration height iterations layers max_frames max_iterations max_steps nsim nstep nthread objects points
    port samples seed starts steps substeps width window
}
