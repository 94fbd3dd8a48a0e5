//! What most families of problems have in common.

use signorini_contact::{ContactProblem, FrictionPolygon};
use signorini_multibody::glam::DVec3;

use crate::{Random, Scene};

/// Signs of the gaps φ, of at most 1 mm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gap {
    /// Touching.
    Zero,
    /// Open.
    Positive,
    /// Penetrating.
    Negative,
    /// Both.
    Mixed,
}

/// How the bodies move before the step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// At rest.
    Rest,
    /// Horizontally, with spin about the vertical.
    Slide,
    /// Downwards with spin.
    Impact,
    /// In any direction.
    Random,
}

/// What most families have in common.
#[derive(Clone, Copy, Debug)]
pub struct Parameters {
    /// Coefficient of friction μ of every contact.
    pub friction: f64,
    /// Directions of each friction polygon, even.
    pub directions: usize,
    /// Whether each contact has its own number (4 … `directions`) and orientation of directions.
    pub own_polygons: bool,
    /// Signs of the gaps.
    pub gap: Gap,
    /// Motion before the step.
    pub motion: Motion,
    /// Mass of the heaviest body relative to the lightest.
    pub mass_ratio: f64,
    /// How often every contact point is given.
    pub copies: usize,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            friction: 0.5,
            directions: 4,
            own_polygons: false,
            gap: Gap::Zero,
            motion: Motion::Rest,
            mass_ratio: 1.0,
            copies: 1,
        }
    }
}

impl Parameters {
    /// A random choice over the whole range, gaps included.
    pub fn random(random: &mut Random) -> Self {
        Self {
            friction: random.choice(&[0.0, 0.1, 0.3, 0.5, 1.0, 2.0]),
            directions: random.choice(&[4, 6, 8, 12]),
            own_polygons: random.below(2) == 0,
            gap: random.choice(&[Gap::Zero, Gap::Positive, Gap::Negative, Gap::Mixed]),
            motion: random.choice(&[Motion::Rest, Motion::Slide, Motion::Impact, Motion::Random]),
            mass_ratio: random.choice(&[1.0, 1.0, 1e2, 1e4]),
            copies: random.choice(&[1, 1, 1, 2]),
        }
    }

    pub(crate) fn draw_gap(&self, random: &mut Random) -> f64 {
        let size = random.between(0.0, 1e-3);
        match self.gap {
            Gap::Zero => 0.0,
            Gap::Positive => size,
            Gap::Negative => -size,
            Gap::Mixed => 2.0 * size - 1e-3,
        }
    }

    /// Linear and angular velocity of a body.
    pub(crate) fn draw_motion(&self, random: &mut Random) -> (DVec3, DVec3) {
        match self.motion {
            Motion::Rest => (DVec3::ZERO, DVec3::ZERO),
            Motion::Slide => {
                let (sin, cos) = random.between(0.0, std::f64::consts::TAU).sin_cos();
                (DVec3::new(cos, sin, 0.0) * random.between(0.2, 3.0), DVec3::Z * random.between(-2.0, 2.0))
            }
            Motion::Impact => {
                let down = -random.between(0.5, 5.0);
                (DVec3::new(random.normal(), random.normal(), down), 2.0 * random.normal_vector())
            }
            Motion::Random => (random.normal_vector(), random.normal_vector()),
        }
    }

    /// The polygon of the next contact.
    pub(crate) fn draw_polygon(&self, random: &mut Random) -> FrictionPolygon {
        let (count, angle) = if self.own_polygons {
            (4 + 2 * random.below(self.directions / 2 - 1), random.between(0.0, std::f64::consts::TAU))
        } else {
            (self.directions, 0.0)
        };
        FrictionPolygon::regular(count, angle).expect("an even number of directions")
    }

    pub(crate) fn problem(&self, scene: &Scene, random: &mut Random) -> ContactProblem {
        let mut all = scene.clone();
        all.contacts = scene.contacts.iter().flat_map(|c| std::iter::repeat_n(*c, self.copies)).collect();
        all.problem(|_| (self.friction, self.draw_polygon(random)))
    }
}
