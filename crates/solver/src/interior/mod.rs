//! Starts for the exact iterations of large islands: an interior-point method on the laws themselves, and its central path.

mod control;
mod path;
mod series;
mod start;
mod step;
mod unit;

pub(crate) use start::{Ground, InteriorLaw, InteriorStart};
