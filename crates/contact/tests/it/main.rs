//! Integration tests of `signorini-contact`.
#![allow(non_snake_case)]

mod agreement;
mod assembly;
mod bilateral;
mod certificate;
mod circular_cone;
mod extremes;
mod families;
mod files;
mod indeterminacy;
mod invariance;
mod polygons;
mod reference;
mod relaxation;
mod shared_problems;
