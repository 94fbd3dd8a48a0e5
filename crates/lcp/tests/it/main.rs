//! Integration tests of `signorini-lcp`.
#![allow(non_snake_case)]

mod alternative;
mod cases;
mod contact_data;
mod exclude;
mod input;
mod known;
mod mixed;
mod mixed_random;
mod newton;
mod oracle;
mod principal;
mod psor;
mod shared_data;
mod solution_set;
mod support;
mod units;
mod warm;
