//! Motions, forces and momenta of rigid bodies.

use glamx::glam::DVec3;

/// An angular and a linear part: velocity (rad/s, m/s), acceleration (rad/s², m/s²) or momentum (kg·m²/s, kg·m/s), wrench (N·m, N).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpatialVector {
    /// Angular part.
    pub angular: DVec3,
    /// Linear part.
    pub linear: DVec3,
}

impl SpatialVector {
    /// Nothing.
    pub const ZERO: Self = Self { angular: DVec3::ZERO, linear: DVec3::ZERO };

    /// Angular before linear, `[6]`.
    pub fn to_array(self) -> [f64; 6] {
        let (a, l) = (self.angular, self.linear);
        [a.x, a.y, a.z, l.x, l.y, l.z]
    }
}
