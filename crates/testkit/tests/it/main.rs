//! Tests of what the other crates test with.

mod reference;
mod suite;
