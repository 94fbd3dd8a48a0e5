//! What the rows of a step's problem come from.

use signorini_multibody::glam::DVec3;
use signorini_multibody::{ContactPoint, JointId, TendonId};

/// What a contact of a step's problem comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ContactSource {
    /// Two geoms that touch or could touch.
    Point(ContactPoint),
    /// A limit of a joint.
    Limit {
        /// The joint.
        joint: JointId,
        /// Whether it is the upper limit.
        upper: bool,
    },
    /// A limit of a tendon.
    TendonLimit {
        /// The tendon.
        tendon: TendonId,
        /// Whether it is the upper limit.
        upper: bool,
    },
}

/// What a friction group of a step's problem comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrictionSource {
    /// Dry friction in a degree of freedom of a joint.
    Joint {
        /// Index of the joint.
        joint: usize,
        /// The degree of freedom.
        dof: usize,
    },
    /// A servo of speed.
    Servo {
        /// Index of the actuator.
        actuator: usize,
    },
    /// Sliding on a moving surface; the contact itself has no friction then.
    Belt {
        /// Index of the contact.
        contact: usize,
    },
    /// Spinning about the normal of a contact.
    Spinning {
        /// Index of the contact.
        contact: usize,
    },
    /// Rolling about the tangents of a contact.
    Rolling {
        /// Index of the contact.
        contact: usize,
    },
}

impl FrictionSource {
    /// The same where contacts have other indices.
    pub(crate) fn renumbered(self, to: impl Fn(usize) -> usize) -> Self {
        match self {
            Self::Belt { contact } => Self::Belt { contact: to(contact) },
            Self::Spinning { contact } => Self::Spinning { contact: to(contact) },
            Self::Rolling { contact } => Self::Rolling { contact: to(contact) },
            Self::Joint { .. } | Self::Servo { .. } => self,
        }
    }
}

/// What a bilateral row of a step's problem comes from: a row of a block of an equality constraint
/// ([`equality_block_into`](signorini_multibody::equality_block_into)).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BilateralSource {
    pub equality: usize,
    pub block: usize,
    pub axis: usize,
}

/// What a limit's row in a step's problem was made from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LimitRow {
    /// Distance to the limit at the beginning of the step along the row, rad or m.
    pub distance: f64,
    /// Axis along which the rotation of a ball joint is bounded; zero for other limits.
    pub axis: DVec3,
}
