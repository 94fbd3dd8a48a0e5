//! Shared parts of the benchmark programs: contact problems and the programs that solve them, scenes given as JSON, recorded cube tosses, robots of others, and what is measured on them.

pub mod contact_lcp;
pub mod robots;
pub mod sim;
pub mod table;
pub mod tosses;
