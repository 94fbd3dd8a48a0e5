//! What actuators pull on: joints, tendons, sites.

use derive_setters::Setters;

use super::{JointId, SiteId, TendonId};

/// What an actuator acts on. Its length is a function of `q`, its force acts on `v` through the gradient of the length
/// (MuJoCo's transmissions), both times the actuator's gear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Transmission {
    /// A hinge or slide: the length is its `q`.
    Joint(JointId),
    /// A ball or free joint: a constant generalized force along `axes` in the coordinates of its `v` (3 or 6 of them).
    /// The length is the rotation vector of a ball along `axes`, and 0 for a free joint.
    JointAxes {
        /// The ball or free joint.
        joint: JointId,
        /// Direction in its `v`; a ball uses the first three.
        axes: [f64; 6],
    },
    /// A tendon: the length is that of the tendon.
    Tendon(TendonId),
    /// A wrench at a site in the axes of the site or, where there is a reference, of the reference; the length is 0, or
    /// the place of the site in the reference frame along the wrench.
    Site {
        /// Where it acts.
        site: SiteId,
        /// The frame it acts relative to, which takes the opposite wrench; none for the world, which the force then does
        /// not measure against.
        reference: Option<SiteId>,
        /// Force and moment per unit of actuator force.
        wrench: [f64; 6],
    },
}

impl From<JointId> for Transmission {
    fn from(joint: JointId) -> Self {
        Self::Joint(joint)
    }
}

impl From<TendonId> for Transmission {
    fn from(tendon: TendonId) -> Self {
        Self::Tendon(tendon)
    }
}

/// A fixed tendon: a length that is a linear combination of joint coordinates, with a spring, a damper and limits.
#[derive(Clone, Debug, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct Tendon {
    /// Unique name.
    #[setters(into)]
    pub name: String,
    /// Hinges and slides with their coefficients: the length is `Σ c_j q_j`.
    pub terms: Vec<(JointId, f64)>,
    /// Stiffness of the spring, N/m, ≥ 0.
    pub stiffness: f64,
    /// Viscous damping of the length, N·s/m, ≥ 0.
    pub damping: f64,
    /// The lengths between which the spring is slack, m.
    pub rest: [f64; 2],
    /// Lower and upper limit of the length, m.
    #[setters(into)]
    pub limits: Option<[f64; 2]>,
}

impl Tendon {
    /// A tendon with nothing acting in it.
    pub fn new(name: impl Into<String>, terms: Vec<(JointId, f64)>) -> Self {
        Self { name: name.into(), terms, stiffness: 0.0, damping: 0.0, rest: [0.0; 2], limits: None }
    }

    /// How far a length is beyond the end of the range in which the spring is slack, m.
    pub fn stretch(&self, length: f64) -> f64 {
        length - length.clamp(self.rest[0], self.rest[1])
    }
}
