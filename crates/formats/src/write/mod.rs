//! Models written as files.

mod actuation;
mod element;
mod looks;
mod mjcf;
mod shapes;
mod urdf;

pub use mjcf::{Written, write_mjcf};
pub use urdf::write_urdf;
