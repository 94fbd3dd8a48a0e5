//! Integration tests of the readers.

mod actuation;
mod actuator_defaults;
mod decompose;
mod forgiven;
mod mechanism;
mod meshes;
mod mjcf_errors;
mod mjcf_reference;
mod places;
mod report;
mod robots;
mod robustness;
mod sdf;
mod sdf_frames;
mod sdf_links;
mod sdf_loops;
mod support;
mod tendons;
mod urdf;
mod visuals;
