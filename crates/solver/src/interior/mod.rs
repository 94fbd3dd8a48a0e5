//! Starts for the exact iterations of large islands: an interior-point method on the laws themselves, and its central path.

mod control;
mod parts;
mod path;
mod point;
mod series;
mod start;
mod step;
mod unit;

pub(crate) use point::Ground;
pub(crate) use start::InteriorStart;
