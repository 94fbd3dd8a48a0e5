//! Sensors of contacts between two sides.

use derive_setters::Setters;

use super::{BodyId, GeomId, SiteId};

/// What a contact has to touch on one side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactSide {
    /// Anything.
    Any,
    /// This geom.
    Geom(GeomId),
    /// A geom of this body.
    Body(BodyId),
    /// A geom of this body or of one that hangs on it.
    Subtree(BodyId),
    /// Anything, at a point inside the zone of this site.
    Zone(SiteId),
}

/// Which contacts come first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ContactReduction {
    /// Those found first.
    #[default]
    None,
    /// The deepest.
    SmallestDistance,
    /// Those with the largest force.
    LargestForce,
    /// All as one, in world axes, at the mean of their points weighted with their forces.
    NetForce,
}

/// A sensor of contacts between two sides (MJCF `<contact>`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct ContactSensor {
    /// The two sides; normals point from the first to the second, on which the force acts.
    pub sides: [ContactSide; 2],
    /// For how many contacts there are numbers, ≥ 1.
    pub slots: u16,
    /// Which numbers each has, in this order: how many contacts match (0 of a slot that is empty); force and moment in the axes of the
    /// contact, N and N·m; distance, m; point in world, m; normal; first tangent.
    pub data: [bool; 7],
    /// Which contacts come first.
    pub reduction: ContactReduction,
}

impl ContactSensor {
    /// How many numbers each sort of data has.
    pub const SIZES: [usize; 7] = [1, 3, 3, 1, 3, 3, 3];

    /// Whether two sides touch.
    pub fn new(sides: [ContactSide; 2]) -> Self {
        let data = [true, false, false, false, false, false, false];
        Self { sides, slots: 1, data, reduction: ContactReduction::None }
    }

    /// How many numbers a slot has.
    pub fn slot_size(&self) -> usize {
        self.data.iter().zip(Self::SIZES).map(|(&wanted, size)| if wanted { size } else { 0 }).sum()
    }
}
