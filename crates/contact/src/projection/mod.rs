//! The piecewise linear projection onto friction cones with polygonal sections, and its pieces.

mod cone_data;
mod mode;
mod polygons;

pub use mode::{Cones, Facet, Held, Mode};
