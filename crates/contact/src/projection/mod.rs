//! The piecewise linear projection onto friction cones with polygonal sections, and its pieces.

mod cone_data;
mod cones;
mod mode;
mod polygons;

pub use cones::Cones;
pub use mode::{Facet, Held, Mode};
