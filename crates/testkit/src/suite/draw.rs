//! What problems draw by the parameters that all shapes have.

use signorini_multibody::glam::DVec3;

use super::random::NumpyRandom;
use crate::{Gap, Motion};

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

/// The random stream of a problem with what it draws by the common parameters.
pub struct Draw {
    /// NumPy's stream.
    pub random: NumpyRandom,
    /// What all shapes have in common.
    pub common: Common,
}

impl Draw {
    /// A gap of at most 1 mm. The stream moves on by all three candidates, whichever is taken.
    pub fn gap(&mut self) -> f64 {
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
    pub fn motion(&mut self) -> (DVec3, DVec3) {
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
