//! Tests of the public interface.

mod random_model;
mod tasks;
mod tree_file;

mod actuators;
mod balance;
mod closed_forms;
mod constraints;
mod coriolis;
mod derivatives;
mod equations;
mod frames;
mod free_motion;
mod free_rotation;
mod identities;
mod mass;
mod model;
mod motion;
mod mujoco;
mod muscles;
mod peers;
mod rotations;
mod sensors;
mod tendons;
mod turning_servos;
