//! Direct solution of block-sparse systems: an elimination order, and an LU factorisation in that order.

mod block_lu;
mod dense_lu;
mod kernels;
mod ordering;
mod panels;
mod products;
mod symbolic;
mod vectors;

pub(crate) use block_lu::BlockLu;
pub(crate) use dense_lu::DenseLu;
pub(crate) use kernels::{FREE, LIMB, copy_few};
pub(crate) use panels::load;
pub(crate) use symbolic::Symbolic;
pub(crate) use vectors::{Vectorised, run_widest};
