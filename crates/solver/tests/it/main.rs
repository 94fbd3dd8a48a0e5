//! Integration tests of `signorini-solver`.
#![allow(non_snake_case)]

mod agreement;
mod anisotropy;
mod bilateral;
mod budget;
mod contact_sweeps;
mod extremes;
mod families;
mod friction_groups;
mod given_starts;
mod invariance;
mod islands;
mod large_islands;
mod random_cases;
mod shared_problems;
mod stages;
mod threads;
mod uniqueness;
