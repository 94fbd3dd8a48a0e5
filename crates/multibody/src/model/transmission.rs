//! What actuators pull on: joints, tendons, sites, contacts.

use super::{BodyId, JointId, SiteId, TendonId};

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
    /// The contacts of a body (MuJoCo's adhesion): the force pulls the body and what it touches together, spread evenly over the contact
    /// points of its own geoms and along their normals. The length is 0. Which points these are is known in a step: the row is empty, and
    /// the smooth dynamics do not have the force.
    Body {
        /// The body that sticks.
        body: BodyId,
        /// Gap up to which a point is pulled, m, ≥ 0 (MJCF's `gap` of a geom).
        layer: f64,
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
