//! Dense kernels: compensated dot products and an LU factorisation with partial pivoting.
//!
//! Everything is row-major, sequential and allocation-free once its buffers have grown.

mod kernels;
mod lu;

pub(crate) use kernels::{DoubleSum, add_scaled, dot, power_of_two};
pub use lu::Lu;
