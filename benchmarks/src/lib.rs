//! Shared parts of the benchmark programs: scenes given as JSON, recorded cube tosses, robots of others, and what is measured on them.

pub mod robots;
pub mod scenes;
pub mod table;
pub mod tosses;
