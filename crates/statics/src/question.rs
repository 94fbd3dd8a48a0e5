//! What is asked of a configuration beside its verdict.

use signorini_multibody::BodyId;
use signorini_multibody::glam::DVec3;

/// What is increased until the configuration must move.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum SafetyQuestion {
    /// A horizontal share of gravity in this direction (any length) beside gravity itself; a number, as in seismic design.
    Horizontal(DVec3),
    /// The angle by which gravity is turned towards this direction (any length, not along gravity), rad: a tilting table.
    Tilt(DVec3),
    /// The multiplier of all coefficients of friction of contacts, which is lowered instead.
    Friction,
    /// The multiplier of a generalized force beside the loads, `[nv]`, N and N·m.
    Load(Vec<f64>),
    /// The multiplier of the force ranges of all servos of speed, which is lowered instead: the torque margin of motors that
    /// [hold](crate::held_by_motors).
    Motors,
    /// A weight that is added to a body at its centre of mass, kg.
    Weight(BodyId),
    /// A force at a body's centre of mass in this direction (any length) in world, N.
    Push(BodyId, DVec3),
}

impl SafetyQuestion {
    /// From where it balances to where it is looked for at most.
    pub(crate) fn range(&self) -> [f64; 2] {
        match self {
            Self::Horizontal(_) | Self::Load(_) | Self::Weight(_) | Self::Push(..) => [0.0, 1e6],
            Self::Tilt(_) => [0.0, std::f64::consts::PI],
            Self::Friction | Self::Motors => [1.0, 0.0],
        }
    }
}
