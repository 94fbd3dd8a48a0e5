//! Contact LCPs: where they come from, who solves them, what is recorded and what is printed.
//!
//! Every solver runs in a process of its own that the benchmark asks over a pipe, one request per line: this program's own
//! [`serve`] and the peers' `peers.py`. So every solve has a time limit, a crash costs one solve only, and solvers take turns on
//! the same machine within one problem. One residual, [`signorini::lcp::Lcp::residual`], judges every point.

mod delassus;
mod measure;
mod own;
mod problems;
mod record;
mod stopwatch;
mod tables;
mod worker;

pub use measure::{Limits, Session};
pub use own::serve;
pub use problems::{Problem, Spec};
pub use record::{Outcome, PeerRecord, Record, SOLVED};
pub use tables::print_all;
pub use worker::{Failure, Worker};
