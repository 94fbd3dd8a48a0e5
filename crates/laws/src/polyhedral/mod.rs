//! Convex piecewise quadratic problems over polyhedral cones of contact impulses, one group of coupled bodies after another.
//!
//! What the choice among indeterminate impulses ([`LeastNorm`](crate::LeastNorm)) and the convex relaxation
//! ([`ConvexRelaxation`](crate::ConvexRelaxation)) have in common: both minimise a quadratic function plus the squared
//! Euclidean distance of trial impulses from the polar cones, by Newton's method in velocity space.

mod cones;
mod groups;
mod line_search;
mod newton;

pub(crate) use cones::{ImpulseCones, Piece};
pub(crate) use groups::{Group, Groups};
pub(crate) use line_search::step_length;
pub(crate) use newton::{ConeNewton, Objective};
