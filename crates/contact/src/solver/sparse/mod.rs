//! Direct solution of block-sparse systems: an elimination order, and an LU factorisation in that order.

mod block_lu;
mod kernels;
mod ordering;
mod symbolic;

pub(crate) use block_lu::BlockLu;
pub(crate) use kernels::{FREE, FreeRows, add_free_product};
pub(crate) use symbolic::Symbolic;
