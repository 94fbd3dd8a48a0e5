//! Statuses, and the message of a thread's last error.

use std::cell::RefCell;
use std::ffi::{c_char, CString};
use std::fmt::Display;
use std::panic::{catch_unwind, AssertUnwindSafe};

/// What a function returns: 0 for success, positive for a result that one should look at, negative for an error.
pub type signorini_status = i32;

/// Done, and every law holds within the tolerance.
pub const SIGNORINI_OK: signorini_status = 0;
/// Done, with the best answer found: a residual exceeds the tolerance.
pub const SIGNORINI_MISSED_TOLERANCE: signorini_status = 1;
/// There is no solution: contacts contradict or wedge each other. A step was not carried out.
pub const SIGNORINI_NO_SOLUTION: signorini_status = 2;
/// An argument is NULL, of a wrong length, out of its range, or no number.
pub const SIGNORINI_ERROR_ARGUMENT: signorini_status = -1;
/// A file cannot be read, or makes no sense.
pub const SIGNORINI_ERROR_FILE: signorini_status = -2;
/// A simulation cannot be set up or cannot go on.
pub const SIGNORINI_ERROR_SIMULATION: signorini_status = -3;
/// A contact problem or complementarity problem is malformed.
pub const SIGNORINI_ERROR_PROBLEM: signorini_status = -4;
/// A defect of this library: please report it with the message.
pub const SIGNORINI_ERROR_INTERNAL: signorini_status = -99;

thread_local! {
    static LAST: RefCell<CString> = RefCell::new(CString::default());
}

/// What went wrong in the last call of this thread that returned a negative status, or no handle; an empty text before the first one. It
/// stays until the next error of this thread. A simulation that ended with SIGNORINI_NO_SOLUTION says here which contacts are meant.
#[no_mangle]
pub extern "C" fn signorini_last_error() -> *const c_char {
    LAST.with(|last| last.borrow().as_ptr())
}

/// An error's status and message.
pub(crate) struct Failure {
    status: signorini_status,
    message: String,
}

impl Failure {
    pub fn new(status: signorini_status, message: impl Display) -> Self {
        Self { status, message: message.to_string() }
    }

    pub fn argument(message: impl Display) -> Self {
        Self::new(SIGNORINI_ERROR_ARGUMENT, message)
    }

    pub fn simulation(message: impl Display) -> Self {
        Self::new(SIGNORINI_ERROR_SIMULATION, message)
    }

    pub fn problem(message: impl Display) -> Self {
        Self::new(SIGNORINI_ERROR_PROBLEM, message)
    }

    /// Keeps the message for [`signorini_last_error`]; returns the status.
    pub fn keep(self) -> signorini_status {
        keep_message(&self.message);
        self.status
    }
}

/// Makes a text the one of [`signorini_last_error`].
pub(crate) fn keep_message(message: &str) {
    let text = CString::new(message.replace('\0', " ")).unwrap_or_default();
    LAST.with(|last| *last.borrow_mut() = text);
}

/// The status of what was asked for; a panic does not leave the library.
pub(crate) fn guarded(work: impl FnOnce() -> Result<signorini_status, Failure>) -> signorini_status {
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(status)) => status,
        Ok(Err(failure)) => failure.keep(),
        Err(panic) => {
            let text = panic.downcast_ref::<&str>().map(ToString::to_string);
            let text = text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
            Failure::new(SIGNORINI_ERROR_INTERNAL, format!("a defect of the library, please report it: {text}")).keep()
        }
    }
}
