//! Bilateral constraints between parts of a mechanism: loop closures and coupled joints.

use glamx::glam::DVec3;

use super::{BodyId, JointId, TendonId};
use crate::math::Pose;

/// A constraint `Θ(q) = 0` (formulation §5).
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Equality {
    /// Unique name.
    pub name: String,
    /// What it holds together.
    pub kind: EqualityKind,
}

impl Equality {
    /// A constraint by this name.
    pub fn new(name: impl Into<String>, kind: EqualityKind) -> Self {
        Self { name: name.into(), kind }
    }
}

/// What a constraint holds together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EqualityKind {
    /// A point of one body stays at a point of another: a ball joint that closes a loop. Three rows, m.
    Connect {
        /// One body.
        body_a: BodyId,
        /// Its point, in its frame, m.
        point_a: DVec3,
        /// The other body.
        body_b: BodyId,
        /// Its point, in its frame, m.
        point_b: DVec3,
    },
    /// A frame of one body stays on a frame of another. Six rows, m and rad.
    Weld {
        /// One body.
        body_a: BodyId,
        /// Its frame `X_AF`.
        frame_a: Pose,
        /// The other body.
        body_b: BodyId,
        /// Its frame `X_BF`.
        frame_b: Pose,
    },
    /// A hinge or slide follows another one: `q − q₀ = Σ a_k (q′ − q′₀)^k`, where `q₀` and `q′₀` are the joints' references
    /// and `q′` belongs to the driver. Without a driver the joint is held at `q₀ + a_0`. One row, rad or m.
    Joint {
        /// The joint that follows.
        joint: JointId,
        /// The joint that leads.
        driver: Option<JointId>,
        /// `a_0 … a_4`.
        polynomial: [f64; 5],
    },
    /// The length of a tendon follows that of another one: `l − l₀ = Σ a_k (l′ − l′₀)^k`, with the lengths `l₀` and `l′₀` at the reference
    /// configuration. Without a driver the tendon is held at `l₀ + a_0`. One row, m.
    Tendon {
        /// The tendon that follows.
        tendon: TendonId,
        /// The tendon that leads.
        driver: Option<TendonId>,
        /// `a_0 … a_4`.
        polynomial: [f64; 5],
    },
}

impl EqualityKind {
    /// Number of blocks of at most three rows; see [`equality_block_into`](crate::equality_block_into).
    pub fn block_count(&self) -> usize {
        if matches!(self, Self::Weld { .. }) { 2 } else { 1 }
    }

    /// The joints it refers to.
    pub(super) fn joints_mut(&mut self) -> impl Iterator<Item = &mut JointId> {
        let (joint, driver) = match self {
            Self::Joint { joint, driver, .. } => (Some(joint), driver.as_mut()),
            Self::Connect { .. } | Self::Weld { .. } | Self::Tendon { .. } => (None, None),
        };
        joint.into_iter().chain(driver)
    }
}
