//! Integration tests of `signorini-contact`.
#![allow(non_snake_case)]

mod assembly;
mod certificate;
mod files;
mod formulation;
mod polygons;
