//! Tests of what the benchmark programs measure with.

mod tosses;
