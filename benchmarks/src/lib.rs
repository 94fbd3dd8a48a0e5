//! Shared parts of the benchmark programs: scenes given as JSON, recorded cube tosses, and what is measured on them.

pub mod scenes;
pub mod table;
pub mod tosses;
