//! The list of contact problems that solvers are compared on, seed for seed the same as in the generator that other
//! programs read (`generate_contact_problems.py`): numbers are drawn from NumPy's stream in the generator's order.
//!
//! [`families`](crate::families) has the same scenes for tests, with more freedom and cheaper random numbers.

mod bodies;
mod draw;
mod list;
mod random;
mod trees;

pub use draw::Common;
pub use list::{Entry, Shape, entries};

use draw::Draw;
use random::NumpyRandom;
use signorini_contact::ContactProblem;

impl Entry {
    /// The problem of a seed. The generator's list gives entry `k` the seed `k`.
    pub fn problem(&self, seed: u32) -> ContactProblem {
        let mut draw = Draw { random: NumpyRandom::new(seed), common: self.common };
        match self.shape {
            Shape::Box { slope } => bodies::box_on_plane(&mut draw, slope),
            Shape::Stack { boxes, ratio, copies, jitter } => bodies::stack(&mut draw, boxes, ratio, copies, jitter),
            Shape::Pyramid { rows } => bodies::pyramid(&mut draw, rows),
            Shape::Cluster { bodies, ratio, turned } => bodies::cluster(&mut draw, bodies, ratio, turned),
            Shape::Articulated { nv, contacts } => trees::articulated(&mut draw, nv, contacts),
            Shape::Painleve { angle, speed, spin, timestep } => {
                bodies::painleve(&mut draw, angle, speed, spin, timestep)
            }
            Shape::Wedge { half_angle, points } => bodies::wedge(&mut draw, half_angle, points),
            Shape::Squeeze { boxes, depth } => bodies::squeeze(&mut draw, boxes, depth),
        }
    }
}
