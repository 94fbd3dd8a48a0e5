//! What native code must not do to an interpreter: panic through it, wait for threads that a fork left behind, or ask for more memory
//! than there can be.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process;
use std::sync::OnceLock;

use pyo3::exceptions::{PyMemoryError, PyRuntimeError};
use pyo3::prelude::*;

/// Numbers that one call may be asked to give back: 64 GiB of them.
const MOST_NUMBERS: usize = 1 << 33;

static LOADED_IN: OnceLock<u32> = OnceLock::new();

/// Remembers the process that loads the package.
pub fn loaded() {
    LOADED_IN.get_or_init(process::id);
}

/// Whether this process was forked from the one that loaded the package: the threads of a pool, if there is one, stayed there.
pub fn is_forked() -> bool {
    LOADED_IN.get().is_some_and(|loaded| *loaded != process::id())
}

/// Does long work without the interpreter's lock; a panic becomes a `RuntimeError`.
pub fn detached<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let done = py.detach(|| catch_unwind(AssertUnwindSafe(work)));
    done.map_err(|_| {
        PyRuntimeError::new_err("internal error of signorini, told above: please report it with the model")
    })
}

/// As [`detached`], for work that asks now and then whether to go on. It does until a signal raises an exception, as Ctrl-C does, which is given
/// back beside what the work came to.
pub fn interruptible<T: Send>(
    py: Python<'_>,
    work: impl FnOnce(&mut dyn FnMut() -> bool) -> T + Send,
) -> PyResult<(T, PyResult<()>)> {
    let mut signal = Ok(());
    let done = detached(py, || {
        work(&mut || {
            signal = Python::attach(|py| py.check_signals());
            signal.is_ok()
        })
    })?;
    Ok((done, signal))
}

/// The product of some sizes, if so many numbers can be given back.
pub fn bounded(what: &str, sizes: &[usize]) -> PyResult<usize> {
    let count = sizes.iter().try_fold(1usize, |product, size| product.checked_mul(*size));
    count.filter(|count| *count <= MOST_NUMBERS).ok_or_else(|| {
        let sizes = sizes.iter().map(ToString::to_string).collect::<Vec<_>>().join(" × ");
        PyMemoryError::new_err(format!("{what} would have {sizes} numbers; one call gives back {MOST_NUMBERS} at most"))
    })
}

/// So many numbers that are not known yet.
pub fn unknowns(count: usize) -> PyResult<Vec<f64>> {
    let mut numbers = Vec::new();
    let refused = |_| PyMemoryError::new_err(format!("there is no memory for {count} numbers"));
    numbers.try_reserve_exact(count).map_err(refused)?;
    numbers.resize(count, f64::NAN);
    Ok(numbers)
}
