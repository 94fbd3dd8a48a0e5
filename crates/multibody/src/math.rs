//! Rigid poses.

use glamx::glam::{DMat3, DQuat, DVec3};

/// A rigid pose `X_AB`: frame B placed in frame A, `p_A = rotation · p_B + position`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Origin of B in A, m.
    pub position: DVec3,
    /// Rotation from B's axes to A's, unit quaternion.
    pub rotation: DQuat,
}

impl Pose {
    /// The pose of a frame in itself.
    pub const IDENTITY: Self = Self { position: DVec3::ZERO, rotation: DQuat::IDENTITY };

    /// A pose from an origin (m) and a unit quaternion.
    pub fn new(position: DVec3, rotation: DQuat) -> Self {
        Self { position, rotation }
    }

    /// A pure translation, m.
    pub fn from_position(position: DVec3) -> Self {
        Self { position, rotation: DQuat::IDENTITY }
    }

    /// `p_A` of the point `p_B`, m.
    pub fn transform_point(&self, p: DVec3) -> DVec3 {
        self.rotation * p + self.position
    }

    /// `X_BA` from `X_AB`.
    pub fn inverse(&self) -> Self {
        let r = self.rotation.conjugate();
        Self { position: -(r * self.position), rotation: r }
    }

    /// The rotation as a matrix whose columns are B's axes in A.
    pub fn rotation_matrix(&self) -> DMat3 {
        DMat3::from_quat(self.rotation)
    }
}

/// Composition: `X_AC = X_AB * X_BC`.
impl std::ops::Mul for Pose {
    type Output = Pose;
    fn mul(self, other: Pose) -> Pose {
        Pose { position: self.transform_point(other.position), rotation: self.rotation * other.rotation }
    }
}
