//! Direct solution of block-sparse systems: an elimination order, and an LU factorisation in that order.

mod bisection;
mod block_lu;
mod dense_lu;
mod dissection;
mod elimination;
mod graph;
mod kernels;
mod minimum_degree;
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
