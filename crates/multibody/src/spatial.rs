//! Motions, forces and momenta of rigid bodies.

use std::ops::{Add, AddAssign, Sub, SubAssign};

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

impl Add for SpatialVector {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self { angular: self.angular + other.angular, linear: self.linear + other.linear }
    }
}

impl Sub for SpatialVector {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Self { angular: self.angular - other.angular, linear: self.linear - other.linear }
    }
}

impl AddAssign for SpatialVector {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for SpatialVector {
    #[inline]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl SpatialVector {
    /// `s` times this one.
    #[inline]
    pub(crate) fn scaled(self, s: f64) -> Self {
        Self { angular: self.angular * s, linear: self.linear * s }
    }

    /// How another motion changes while it is carried by this one, `self × other`.
    #[inline]
    pub(crate) fn carry_motion(self, other: Self) -> Self {
        Self {
            angular: self.angular.cross(other.angular),
            linear: self.angular.cross(other.linear) + self.linear.cross(other.angular),
        }
    }

    /// How a wrench (moment, force) changes while it is carried by this motion, `self ×* wrench`.
    #[inline]
    pub(crate) fn carry_wrench(self, wrench: Self) -> Self {
        Self {
            angular: self.angular.cross(wrench.angular) + self.linear.cross(wrench.linear),
            linear: self.angular.cross(wrench.linear),
        }
    }

    /// Power of a wrench (moment, force) on this motion.
    #[inline]
    pub(crate) fn dot(self, wrench: Self) -> f64 {
        self.angular.dot(wrench.angular) + self.linear.dot(wrench.linear)
    }

    /// The same motion, told of the point that lies by `r` from the present one.
    #[inline]
    pub(crate) fn at(self, r: DVec3) -> Self {
        Self { angular: self.angular, linear: self.linear + self.angular.cross(r) }
    }
}
