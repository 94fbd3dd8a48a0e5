//! Shared parts of the benchmark programs: scenes given as JSON, and what is measured on them.

pub mod scenes;
