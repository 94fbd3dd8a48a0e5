//! Physics of whole simulations against closed forms and identities.

mod contradiction;
mod convergence;
mod determinism;
mod friction;
mod impact;
mod incline;
mod input;
mod invariants;
mod inverse;
mod joints;
mod scenes;
mod stacking;
mod support;
