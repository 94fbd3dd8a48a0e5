//! Derivatives of steps, and what their flag says, against the steps themselves.

mod common;
mod differences;
mod identification;
mod parameters;
mod ties;
mod verdicts;
