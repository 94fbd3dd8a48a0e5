//! Derivatives of steps, and what their flag says, against the steps themselves.

mod common;
mod differences;
mod parameters;
mod verdicts;
