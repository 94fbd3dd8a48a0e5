//! Tests of what the benchmark programs measure with.

mod contact_lcp;
mod random_steps;
mod tosses;
