//! Models written as files.

mod actuation;
mod element;
mod mjcf;
mod shapes;

pub use mjcf::{Written, write_mjcf};
