//! Physics of whole simulations against closed forms and identities.

mod contradiction;
mod determinism;
mod friction;
mod impact;
mod incline;
mod input;
mod invariants;
mod joints;
mod scenes;
mod sensors;
mod stacking;
mod support;
