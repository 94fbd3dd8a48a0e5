//! Integration tests of `signorini-contact`.
#![allow(non_snake_case)]

mod assembly;
mod certificate;
mod edited_files;
mod files;
mod formulation;
mod polygons;
