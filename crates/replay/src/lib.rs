//! What is done with a recording after the run.
//!
//! - [`model_source`] and [`rebuild`]: the model's file goes into the header of a recording, and the model comes out again.
//! - [`check`]: every step is certified again, without any solver.
//! - [`export`]: NumPy arrays, a table, or an MCAP file for Foxglove.
//!
//! All of them read frame by frame from a [`FrameSource`]: a file, or a recording in memory.

mod check;
mod error;
pub mod export;
mod frames;
mod source;

pub use check::{RecordingCheck, Violation, check};
pub use error::ReplayError;
pub use frames::FrameSource;
pub use source::{model_source, read_model_source, rebuild};
