//! Tests of the public interface.

mod random_model;

mod identities;
mod mass;
mod motion;
mod mujoco;
