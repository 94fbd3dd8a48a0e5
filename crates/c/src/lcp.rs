//! Linear complementarity problems alone.

use signorini::lcp::{Lcp, Matrix, MethodKind, Status};

use crate::error::{
    guarded, keep_message, signorini_status, Failure, SIGNORINI_MISSED_TOLERANCE, SIGNORINI_NO_SOLUTION, SIGNORINI_OK,
};
use crate::pointers::{array, array_of, check_length, text};

/// Finds z with 0 ≤ z ⟂ w = A z + b ≥ 0.
///
/// a: the matrix A, n × n, row by row; b, z, w: n numbers, w may be NULL. method: "automatic" (or NULL), "lemke", "enumeration", "principal-pivoting",
/// "psor", "newton-fischer-burmeister", "newton-minimum". residual: the natural map of z in the original data relative to max |b|, or NULL.
/// SIGNORINI_NO_SOLUTION where a ray or a proof says that there is none; the message says more.
#[no_mangle]
pub unsafe extern "C" fn signorini_lcp_solve(
    n: usize,
    a: *const f64,
    b: *const f64,
    method: *const std::ffi::c_char,
    z: *mut f64,
    w: *mut f64,
    residual: *mut f64,
) -> signorini_status {
    guarded(|| {
        let size = n.checked_mul(n).ok_or_else(|| Failure::argument("n is too large"))?;
        // SAFETY: the caller's; see the crate.
        let (entries, b, z) = unsafe { (array(a, size, "a")?, array(b, n, "b")?, array_of(z, n, n, "z")?) };
        // SAFETY: the caller's.
        let method = if method.is_null() { "automatic" } else { unsafe { text(method, "method") }? };
        let matrix = Matrix::new(n, n, entries.to_vec()).map_err(Failure::problem)?;
        let problem = Lcp::new(matrix, b.to_vec()).map_err(Failure::problem)?;
        let kind = method.parse::<MethodKind>().map_err(Failure::argument)?;
        let solution = kind.build().map_err(Failure::argument)?.solve(&problem, None);
        check_length("z", solution.z.len(), n)?;
        z.copy_from_slice(&solution.z);
        if !w.is_null() {
            // SAFETY: the caller's.
            unsafe { array_of(w, n, n, "w") }?.copy_from_slice(&problem.w(&solution.z));
        }
        // SAFETY: the caller's.
        if let Some(residual) = unsafe { residual.as_mut() } {
            *residual = solution.residual.value;
        }
        if solution.status.is_solved() {
            return Ok(SIGNORINI_OK);
        }
        keep_message(&format!("{method} ended with {}", name_of(&solution.status)));
        Ok(match solution.status {
            Status::Ray(_) | Status::Infeasible(_) | Status::NoSolution => SIGNORINI_NO_SOLUTION,
            _ => SIGNORINI_MISSED_TOLERANCE,
        })
    })
}

/// The status without its numbers.
fn name_of(status: &Status) -> String {
    let text = format!("{status:?}");
    text.split(['(', ' ', '{']).next().unwrap_or_default().to_owned()
}
