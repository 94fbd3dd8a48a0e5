//! The list of contact problems that solvers are compared on, seed for seed the same as in the generator that other
//! programs read (`generate_contact_problems.py`): numbers are drawn from NumPy's stream in the generator's order.
//!
//! [`families`](crate::families) has the same scenes for tests, with more freedom and cheaper random numbers.

mod bodies;
mod list;
mod random;
mod trees;

pub use list::{Entry, Shape, entries};

use signorini_contact::ContactProblem;
use signorini_multibody::glam::DVec3;

use crate::{Gap, Motion};
use random::NumpyRandom;

/// What all shapes have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Common {
    /// Coefficient of friction μ.
    pub friction: f64,
    /// Directions of each friction polygon, even.
    pub directions: usize,
    /// Motion before the step.
    pub motion: Motion,
    /// Signs of the gaps.
    pub gap: Gap,
}

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

/// The random stream of a problem with what it draws by the common parameters.
struct Draw {
    random: NumpyRandom,
    common: Common,
}

impl Draw {
    /// A gap of at most 1 mm. The stream moves on by all three candidates, whichever is taken.
    fn gap(&mut self) -> f64 {
        let positive = self.random.between(0.0, 1e-3);
        let negative = -self.random.between(0.0, 1e-3);
        let mixed = self.random.between(-1e-3, 1e-3);
        match self.common.gap {
            Gap::Zero => 0.0,
            Gap::Positive => positive,
            Gap::Negative => negative,
            Gap::Mixed => mixed,
        }
    }

    /// Linear and angular velocity of a body.
    fn motion(&mut self) -> (DVec3, DVec3) {
        let random = &mut self.random;
        match self.common.motion {
            Motion::Rest => (DVec3::ZERO, DVec3::ZERO),
            Motion::Slide => {
                let (sin, cos) = random.between(0.0, std::f64::consts::TAU).sin_cos();
                let velocity = DVec3::new(cos, sin, 0.0) * random.between(0.2, 3.0);
                (velocity, DVec3::Z * random.between(-2.0, 2.0))
            }
            Motion::Impact => {
                let (x, y) = (random.normal(), random.normal());
                let velocity = DVec3::new(x, y, -random.between(0.5, 5.0));
                (velocity, 2.0 * random.normal_vector())
            }
            Motion::Random => (random.normal_vector(), random.normal_vector()),
        }
    }
}
