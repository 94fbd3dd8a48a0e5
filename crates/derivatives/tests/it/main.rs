//! Derivatives of steps, and what their flag says, against the steps themselves.

mod batch;
mod collisions;
mod common;
mod differences;
mod identification;
mod laws;
mod linear_system;
mod parameters;
mod servos;
mod ties;
mod verdicts;
