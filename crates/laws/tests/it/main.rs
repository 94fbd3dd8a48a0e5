//! Integration tests of `signorini-laws`.
#![allow(non_snake_case)]

mod circular_cone;
mod cone_gaps;
mod cone_groups;
mod cone_refinement;
mod cone_solver;
mod constraints_alone;
mod contradiction;
mod indeterminacy;
mod indeterminacy_sets;
mod relaxation;
mod relaxation_certificate;
mod settling;
mod unsupported;
