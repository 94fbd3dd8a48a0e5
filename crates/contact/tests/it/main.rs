//! Integration tests of `signorini-contact`.
#![allow(non_snake_case)]

mod agreement;
mod anisotropy;
mod assembly;
mod bilateral;
mod certificate;
mod circular_cone;
mod cone_gaps;
mod cone_groups;
mod cone_refinement;
mod cone_solver;
mod extremes;
mod families;
mod files;
mod formulation;
mod friction_groups;
mod given_starts;
mod indeterminacy;
mod invariance;
mod large_islands;
mod polygons;
mod random_cases;
mod reference;
mod relaxation;
mod settling;
mod shared_problems;
mod threads;
mod uniqueness;
mod unsupported;
