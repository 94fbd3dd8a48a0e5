//! The C interface of signorini: `include/signorini.h`, made from these sources by cbindgen, and `include/signorini.hpp` for C++.
//!
//! A handle is a box given away as a pointer; [`signorini_model_free`] and its like take it back. Functions that can fail return a
//! status; the message of the last error of a thread is at [`signorini_last_error`]. A panic, which would be a defect, ends at this border as
//! [`SIGNORINI_ERROR_INTERNAL`].
//!
//! ```c
//! signorini_model *model = NULL;
//! signorini_simulation *simulation = NULL;
//! if (signorini_model_load("robot.urdf", NULL, &model) != SIGNORINI_OK || signorini_simulation_new(model, NULL, &simulation) != SIGNORINI_OK)
//!   fprintf(stderr, "%s\n", signorini_last_error());
//! ```
//!
//! # Safety
//! Of all functions that take pointers: a handle is one that was made here and not freed, used by one thread at a time (a model by any number);
//! an array has at least the length that is passed or said, and is written by nobody else during the call; text ends with a zero.
//! `NULL` is an error with a message where the documentation does not allow it.

#![allow(non_camel_case_types)]

mod contacts;
mod derivatives;
mod error;
mod input;
mod lcp;
mod model;
mod pointers;
mod problem;
mod report;
mod sensors;
mod settings;
mod simulation;
mod snapshot;

pub use contacts::*;
pub use derivatives::*;
pub use error::*;
pub use input::*;
pub use lcp::*;
pub use model::*;
pub use problem::*;
pub use report::*;
pub use sensors::*;
pub use settings::*;
pub use simulation::*;
pub use snapshot::*;

use std::ffi::c_char;

/// Version of this interface: that of the header is compared with that of the library by `signorini_abi_version() ==
/// SIGNORINI_ABI_VERSION`. It changes whenever a function or a structure does in a way that compiled programs would notice.
pub const SIGNORINI_ABI_VERSION: u32 = 3;

/// The interface's version of the library that is linked.
#[no_mangle]
pub extern "C" fn signorini_abi_version() -> u32 {
    SIGNORINI_ABI_VERSION
}

/// The version of the library, such as "0.1.0".
#[no_mangle]
pub extern "C" fn signorini_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}
