//! Integration tests of the readers.

mod mjcf_errors;
mod mjcf_reference;
mod report;
mod robots;
mod urdf;
