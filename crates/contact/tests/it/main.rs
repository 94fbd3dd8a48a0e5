//! Integration tests of `signorini-contact`.
#![allow(non_snake_case)]

mod assembly;
mod certificate;
mod cone_formulation;
mod cone_gaps;

mod contradiction;
mod edited_files;
mod files;
mod formulation;
mod frames;
mod impulse_space;
mod polygons;
mod projection;
mod recovery;
mod rows;
mod scales;
mod solutions;
mod statics;
mod written;
