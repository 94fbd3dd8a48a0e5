//! Physics of whole simulations against closed forms and identities.

mod batch;
mod contradiction;
mod determinism;
mod friction;
mod impact;
mod incline;
mod input;
mod invariants;
mod joints;
mod linear_system;
mod scenes;
mod stacking;
mod support;
