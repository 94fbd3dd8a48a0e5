//! Direct solution of block-sparse systems: an elimination order, and an LU factorisation in that order.
//!
//! ```
//! let mut lu = signorini_sparse::DenseLu::default();
//! lu.resize(2);
//! lu.entries.copy_from_slice(&[0.0, 2.0, 4.0, 1.0]);
//! assert!(lu.factor());
//! let mut x = [6.0, 7.0];
//! lu.solve(&mut x);
//! assert_eq!(x, [1.0, 3.0]);
//! ```

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
mod random;
mod symbolic;
mod vectors;

pub use block_lu::BlockLu;
pub use dense_lu::DenseLu;
pub use kernels::{FREE, LIMB, copy_few};
pub use panels::load;
pub use random::Random;
pub use symbolic::{Place, Symbolic};
pub use vectors::{Vectorised, run_widest};
