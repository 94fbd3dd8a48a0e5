//! Contact frames.

use signorini_multibody::glam::DVec3;

/// An orthonormal right-handed frame at a contact (formulation §1): `t1 × t2 = n`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactFrame {
    /// Unit normal from body A to body B, in world.
    pub normal: DVec3,
    /// First tangent.
    pub tangent_1: DVec3,
    /// Second tangent.
    pub tangent_2: DVec3,
}

impl ContactFrame {
    /// The frame of a unit normal. The first tangent is the projection of the world axis X, or of Y where the normal is
    /// within about 25° of X: a fixed rule, so that the same contact has the same polygon in every step.
    pub fn from_normal(normal: DVec3) -> Self {
        let reference = if normal.x.abs() < 0.9 { DVec3::X } else { DVec3::Y };
        let tangent_1 = (reference - normal * reference.dot(normal)).normalize();
        Self { normal, tangent_1, tangent_2: normal.cross(tangent_1) }
    }

    /// A vector given by its components (normal, first tangent, second tangent), in world.
    pub fn to_world(&self, components: [f64; 3]) -> DVec3 {
        self.normal * components[0] + self.tangent_1 * components[1] + self.tangent_2 * components[2]
    }
}
