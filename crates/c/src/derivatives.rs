//! Derivatives of steps.

use std::ffi::{c_char, CString};
use std::ptr;

use signorini::derivatives::{StepDerivatives, Validity};

use crate::error::{guarded, keep_message, signorini_status, Failure, SIGNORINI_NO_SOLUTION, SIGNORINI_OK};
use crate::pointers::{array, array_of, give, owned, shared, take_back};
use crate::simulation::signorini_simulation;

/// The derivative of a step, with the flag that says whether it exists.
pub struct signorini_derivatives {
    inner: StepDerivatives,
    reason: CString,
    nv: usize,
    nu: usize,
}

/// What a derivative is worth.
pub type signorini_validity = i32;
/// Every inequality of the step holds strictly: the step is differentiable.
pub const SIGNORINI_EXACT: signorini_validity = 0;
/// Some inequalities are about to turn: the derivative is that of one side.
pub const SIGNORINI_ONE_SIDED: signorini_validity = 1;
/// There is no derivative, or none that is known: signorini_derivatives_reason() says why.
pub const SIGNORINI_REFUSED: signorini_validity = 2;

/// A matrix of derivatives.
pub type signorini_derivative_matrix = i32;
/// (q⁺, v⁺) by (q, v): 2 nv × 2 nv.
pub const SIGNORINI_BY_STATE: signorini_derivative_matrix = 0;
/// (q⁺, v⁺) by the control: 2 nv × nu.
pub const SIGNORINI_BY_CONTROL: signorini_derivative_matrix = 1;
/// (q⁺, v⁺) by the applied generalized force: 2 nv × nv.
pub const SIGNORINI_BY_FORCE: signorini_derivative_matrix = 2;

impl signorini_derivatives {
    /// A result, where there is a derivative.
    fn given<T>(&self, result: Option<T>) -> Result<T, signorini_status> {
        result.ok_or_else(|| {
            keep_message(&format!("this step has no derivative: {}", self.reason.to_string_lossy()));
            SIGNORINI_NO_SOLUTION
        })
    }
}

/// Storage for derivatives of the steps of a simulation, or of another one of the same model. Configurations are in tangent coordinates at
/// both ends: changes of a configuration have nv numbers, in the axes of v.
#[no_mangle]
pub unsafe extern "C" fn signorini_derivatives_new(
    simulation: *const signorini_simulation,
    derivatives: *mut *mut signorini_derivatives,
) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let model = unsafe { shared(simulation, "simulation") }?.inner.model();
        let (nv, nu) = (model.nv, model.actuators.len());
        let reason = CString::new("no step was given").unwrap_or_default();
        let handle = signorini_derivatives { inner: StepDerivatives::new(model), reason, nv, nu };
        // SAFETY: the caller's.
        unsafe { give(derivatives, handle) }?;
        Ok(SIGNORINI_OK)
    })
}

/// Frees derivatives.
#[no_mangle]
pub unsafe extern "C" fn signorini_derivatives_free(derivatives: *mut signorini_derivatives) {
    // SAFETY: the caller's.
    unsafe { take_back(derivatives) }
}

/// Makes one step, as signorini_step(), and takes its derivative. The derivative allocates memory, the step does not.
#[no_mangle]
pub unsafe extern "C" fn signorini_step_with_derivatives(
    simulation: *mut signorini_simulation,
    derivatives: *mut signorini_derivatives,
) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let (handle, derivatives) = unsafe { (owned(simulation, "simulation")?, owned(derivatives, "derivatives")?) };
        let (nv, nu) = (handle.inner.model().nv, handle.inner.model().actuators.len());
        if (nv, nu) != (derivatives.nv, derivatives.nu) {
            let (had, other) = (derivatives.nv, derivatives.nu);
            return Err(Failure::argument(format_args!(
                "the derivatives are for a model with nv = {had} and nu = {other}; the simulation's has nv = {nv} and nu = {nu}"
            )));
        }
        handle.is_current = false;
        let validity = derivatives.inner.step(&mut handle.inner).map_err(Failure::simulation)?;
        let reason = match validity {
            Validity::Refused { reason } => reason.replace('\0', " "),
            _ => String::new(),
        };
        derivatives.reason = CString::new(reason).unwrap_or_default();
        Ok(handle.status())
    })
}

/// What the derivative is worth; SIGNORINI_REFUSED for NULL.
#[no_mangle]
pub unsafe extern "C" fn signorini_derivatives_validity(
    derivatives: *const signorini_derivatives,
) -> signorini_validity {
    // SAFETY: the caller's.
    unsafe { derivatives.as_ref() }.map_or(SIGNORINI_REFUSED, |handle| match handle.inner.validity() {
        Validity::Exact => SIGNORINI_EXACT,
        Validity::OneSided { .. } => SIGNORINI_ONE_SIDED,
        _ => SIGNORINI_REFUSED,
    })
}

/// Why the derivative is refused, until the next step with these derivatives; NULL where it is not, and for NULL.
#[no_mangle]
pub unsafe extern "C" fn signorini_derivatives_reason(derivatives: *const signorini_derivatives) -> *const c_char {
    // SAFETY: the caller's.
    let handle = unsafe { derivatives.as_ref() };
    handle.filter(|handle| !handle.reason.is_empty()).map_or(ptr::null(), |handle| handle.reason.as_ptr())
}

/// How near the nearest inequality of the step is to turning, where another derivative begins; 0 where the derivative is one-sided. It has no
/// unit; NaN where there is no derivative, and for NULL.
#[no_mangle]
pub unsafe extern "C" fn signorini_derivatives_margin(derivatives: *const signorini_derivatives) -> f64 {
    // SAFETY: the caller's.
    unsafe { derivatives.as_ref() }.map_or(f64::NAN, |handle| match handle.inner.validity() {
        Validity::Exact => handle.inner.margins().iter().fold(f64::INFINITY, |least, margin| least.min(margin.value)),
        Validity::OneSided { .. } => 0.0,
        _ => f64::NAN,
    })
}

/// Writes a matrix row by row. length: its number of entries. SIGNORINI_NO_SOLUTION where the derivative is refused; the message says why.
#[no_mangle]
pub unsafe extern "C" fn signorini_derivatives_matrix(
    derivatives: *const signorini_derivatives,
    which: signorini_derivative_matrix,
    entries: *mut f64,
    length: usize,
) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's; see the crate.
        let handle = unsafe { shared(derivatives, "derivatives") }?;
        let (columns, matrix) = match which {
            SIGNORINI_BY_STATE => (2 * handle.nv, handle.inner.state_matrix()),
            SIGNORINI_BY_CONTROL => (handle.nu, handle.inner.control_matrix()),
            SIGNORINI_BY_FORCE => (handle.nv, handle.inner.force_matrix()),
            _ => return Err(Failure::argument(format_args!("there is no matrix {which}"))),
        };
        // SAFETY: the caller's.
        let entries = unsafe { array_of(entries, length, 2 * handle.nv * columns, "entries") }?;
        match handle.given(matrix) {
            Ok(matrix) => entries.copy_from_slice(matrix.data()),
            Err(status) => return Ok(status),
        }
        Ok(SIGNORINI_OK)
    })
}

/// The change of (q⁺, v⁺), 2 nv numbers, with a change of (q, v, control, force), 3 nv + nu numbers, without forming matrices.
#[no_mangle]
pub unsafe extern "C" fn signorini_derivatives_product(
    derivatives: *const signorini_derivatives,
    change: *const f64,
    end: *mut f64,
) -> signorini_status {
    // SAFETY: the caller's.
    unsafe { multiplied(derivatives, (change, "change"), (end, "end"), false) }
}

/// The gradient by (q, v, control, force), 3 nv + nu numbers, of a function whose gradient by (q⁺, v⁺), 2 nv numbers, is given.
#[no_mangle]
pub unsafe extern "C" fn signorini_derivatives_transposed_product(
    derivatives: *const signorini_derivatives,
    gradient: *const f64,
    begin: *mut f64,
) -> signorini_status {
    // SAFETY: the caller's.
    unsafe { multiplied(derivatives, (gradient, "gradient"), (begin, "begin"), true) }
}

/// A product with the derivative or with its transpose.
///
/// # Safety
/// The pointers are null or valid for as many numbers as the product has.
unsafe fn multiplied(
    derivatives: *const signorini_derivatives,
    (given, given_name): (*const f64, &str),
    (result, result_name): (*mut f64, &str),
    transposed: bool,
) -> signorini_status {
    guarded(|| {
        // SAFETY: the caller's.
        let handle = unsafe { shared(derivatives, "derivatives") }?;
        let (begin, end) = (3 * handle.nv + handle.nu, 2 * handle.nv);
        let (from, to) = if transposed { (end, begin) } else { (begin, end) };
        // SAFETY: the caller's.
        let (given, result) = unsafe { (array(given, from, given_name)?, array_of(result, to, to, result_name)?) };
        let product = if transposed { handle.inner.transposed_product(given) } else { handle.inner.product(given) };
        match handle.given(product) {
            Ok(product) => result.copy_from_slice(&product),
            Err(status) => return Ok(status),
        }
        Ok(SIGNORINI_OK)
    })
}
