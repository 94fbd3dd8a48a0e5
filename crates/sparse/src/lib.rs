//! Direct solution of block-sparse systems: an elimination order, and an LU factorisation in that order.
//!
//! ```
//! use signorini_sparse::{BlockLu, Symbolic};
//!
//! // Two blocks of one row that are coupled: [[4, 2], [1, 3]], the first eliminated first.
//! let mut symbolic = Symbolic::default();
//! symbolic.analyse(&[0, 1, 2], &[(0, 1)]);
//! let mut lu = BlockLu::default();
//! lu.clear(&symbolic);
//! let place = symbolic.place(0, 1);
//! lu.upper[symbolic.upper_panel(0)] = 4.0;
//! lu.upper[symbolic.upper_panel(1)] = 3.0;
//! lu.upper[place.upper] = 2.0;
//! lu.lower[place.lower] = 1.0;
//! assert!(lu.factor(&symbolic) > 0.0);
//! let mut x = [10.0, 5.0];
//! lu.solve(&symbolic, &mut x);
//! assert_eq!(x, [2.0, 1.0]);
//! ```

mod bisection;
mod block_lu;
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
mod tuning;

pub use block_lu::BlockLu;
pub use kernels::{FREE, LIMB, copy_few};
pub use panels::{SUMS, load};
pub use random::Random;
pub use symbolic::{Place, Symbolic};
