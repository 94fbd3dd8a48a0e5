//! Physics of whole simulations against closed forms and identities.

mod batch;
mod contradiction;
mod convergence;
mod determinism;
mod dry_friction;
mod friction;
mod friction_law;
mod impact;
mod incline;
mod input;
mod invariants;
mod inverse;
mod joints;
mod linear_system;
mod literature;
mod mechanisms;
mod recertify;
mod restitution;
mod scenes;
mod sensors;
mod sleeping;
mod snapshot;
mod stacking;
mod support;
mod trajectories;
mod variation;
