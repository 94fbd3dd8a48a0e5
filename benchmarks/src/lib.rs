//! Shared parts of the benchmark programs: contact problems and the programs that solve them, random ones by the million, scenes given as JSON, recorded cube tosses, robots of others, and what is measured on them.

pub mod contact_lcp;
pub mod derivative_scenes;
pub mod random_steps;
pub mod robots;
pub mod sim;
pub mod table;
pub mod toss_fit;
pub mod tosses;
