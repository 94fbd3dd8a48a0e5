//! Spatial vectors about one point of the world.

use std::ops::{Add, AddAssign, Sub, SubAssign};

use glamx::glam::DVec3;

use crate::composite::RigidInertia;
use crate::spatial::SpatialVector;

impl Add for SpatialVector {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { angular: self.angular + other.angular, linear: self.linear + other.linear }
    }
}

impl Sub for SpatialVector {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self { angular: self.angular - other.angular, linear: self.linear - other.linear }
    }
}

impl AddAssign for SpatialVector {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for SpatialVector {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl SpatialVector {
    /// `s` times this one.
    pub(super) fn scaled(self, s: f64) -> Self {
        Self { angular: self.angular * s, linear: self.linear * s }
    }

    /// How another motion changes while it is carried by this one, `self × other`.
    pub(super) fn carry_motion(self, other: Self) -> Self {
        Self {
            angular: self.angular.cross(other.angular),
            linear: self.angular.cross(other.linear) + self.linear.cross(other.angular),
        }
    }

    /// How a wrench (moment, force) changes while it is carried by this motion, `self ×* wrench`.
    pub(super) fn carry_wrench(self, wrench: Self) -> Self {
        Self {
            angular: self.angular.cross(wrench.angular) + self.linear.cross(wrench.linear),
            linear: self.angular.cross(wrench.linear),
        }
    }

    /// Power of a wrench (moment, force) on this motion.
    pub(super) fn dot(self, wrench: Self) -> f64 {
        self.angular.dot(wrench.angular) + self.linear.dot(wrench.linear)
    }

    /// The same motion, told of the point that lies by `r` from the present one.
    pub(super) fn at(self, r: DVec3) -> Self {
        Self { angular: self.angular, linear: self.linear + self.angular.cross(r) }
    }

    pub(super) fn from_array(x: [f64; 6]) -> Self {
        Self { angular: DVec3::new(x[0], x[1], x[2]), linear: DVec3::new(x[3], x[4], x[5]) }
    }
}

/// Momentum of a rigid body about the point that its inertia refers to.
pub(super) fn momentum(inertia: &RigidInertia, motion: SpatialVector) -> SpatialVector {
    let (angular, linear) = inertia.times(motion.angular, motion.linear);
    SpatialVector { angular, linear }
}

/// A linear map from motions to wrenches, by its columns.
pub(super) type Map = [[f64; 6]; 6];

/// The wrench of a motion.
pub(super) fn apply(map: &Map, motion: SpatialVector) -> SpatialVector {
    let x = motion.to_array();
    let mut sum = [0.0; 6];
    for (column, x) in map.iter().zip(x) {
        for (sum, entry) in sum.iter_mut().zip(column) {
            *sum += entry * x;
        }
    }
    SpatialVector::from_array(sum)
}
