//! Dense kernels: compensated dot products, an LU factorisation with partial pivoting and a Cholesky factorisation.
//!
//! Everything is row-major, sequential and allocation-free once its buffers have grown.

mod cholesky;
mod kernels;
mod lu;
mod vectors;

pub use cholesky::{Cholesky, SHORT, whole_lanes};
pub(crate) use kernels::{DoubleSum, add_product, add_scaled, power_of_two};
pub use lu::Lu;
pub use signorini_complementarity::dot;
pub(crate) use vectors::{
    add_product_doubled, add_scaled_wide, apply_updates, larger, largest_entries, largest_product, ratio_bound,
    scale_transposed,
};
