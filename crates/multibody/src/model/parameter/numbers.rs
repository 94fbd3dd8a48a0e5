//! Fields of parts as rows of numbers.

use glamx::glam::{DMat3, DQuat, DVec3};

use crate::math::unit_rotation;
use crate::model::{ActuatorKind, Geometry};

/// What a row of numbers cannot be written to, and why.
pub(super) type Written = Result<(), &'static str>;

/// A field that is so many numbers.
pub(super) trait Numbers {
    fn read(&self, out: &mut [f64]);
    fn write(&mut self, values: &[f64]) -> Written;
}

impl Numbers for f64 {
    fn read(&self, out: &mut [f64]) {
        out[0] = *self;
    }

    fn write(&mut self, values: &[f64]) -> Written {
        *self = values[0];
        Ok(())
    }
}

impl Numbers for DVec3 {
    fn read(&self, out: &mut [f64]) {
        out.copy_from_slice(&self.to_array());
    }

    fn write(&mut self, values: &[f64]) -> Written {
        *self = Self::from_slice(values);
        Ok(())
    }
}

impl Numbers for [f64; 2] {
    fn read(&self, out: &mut [f64]) {
        out.copy_from_slice(self);
    }

    fn write(&mut self, values: &[f64]) -> Written {
        self.copy_from_slice(values);
        Ok(())
    }
}

/// (w, x, y, z).
impl Numbers for DQuat {
    fn read(&self, out: &mut [f64]) {
        out.copy_from_slice(&[self.w, self.x, self.y, self.z]);
    }

    fn write(&mut self, values: &[f64]) -> Written {
        let rotation = Self::from_xyzw(values[1], values[2], values[3], values[0]);
        if !rotation.is_finite() || rotation.length_squared() < f64::MIN_POSITIVE {
            return Err("a quaternion must be finite and not zero");
        }
        *self = unit_rotation(rotation);
        Ok(())
    }
}

/// Row after row.
impl Numbers for DMat3 {
    fn read(&self, out: &mut [f64]) {
        out.copy_from_slice(&self.transpose().to_cols_array());
    }

    fn write(&mut self, values: &[f64]) -> Written {
        let given = Self::from_cols_slice(values).transpose();
        let (largest, skew) = (given.to_cols_array(), (given - given.transpose()).to_cols_array());
        let size = |numbers: [f64; 9]| numbers.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
        if size(skew) > 1e-12 * size(largest) {
            return Err("a rotational inertia must be symmetric");
        }
        *self = if skew == [0.0; 9] { given } else { (given + given.transpose()) * 0.5 };
        Ok(())
    }
}

/// A range; none is (−∞, ∞).
impl Numbers for Option<[f64; 2]> {
    fn read(&self, out: &mut [f64]) {
        out.copy_from_slice(&self.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]));
    }

    fn write(&mut self, values: &[f64]) -> Written {
        let range = [values[0], values[1]];
        *self = (range != [f64::NEG_INFINITY, f64::INFINITY]).then_some(range);
        Ok(())
    }
}

/// Half-extents, or radius and half the length; zeros behind them.
impl Numbers for Geometry {
    fn read(&self, out: &mut [f64]) {
        out.fill(0.0);
        match self {
            Self::Sphere { radius } => out[0] = *radius,
            Self::Box { half_extents: e } | Self::Ellipsoid { semi_axes: e } => out.copy_from_slice(&e.to_array()),
            Self::Capsule { radius, half_length }
            | Self::Cylinder { radius, half_length }
            | Self::Cone { radius, half_length } => (out[0], out[1]) = (*radius, *half_length),
            Self::Plane | Self::ConvexMesh(_) | Self::TriangleMesh(_) | Self::HeightField(_) => {}
        }
    }

    fn write(&mut self, values: &[f64]) -> Written {
        let used = match self {
            Self::Plane => return Err("a plane has no size"),
            Self::ConvexMesh(_) | Self::TriangleMesh(_) | Self::HeightField(_) => {
                return Err("its size is that of its mesh or height field, which comes with the model");
            }
            Self::Sphere { radius } => {
                *radius = values[0];
                1
            }
            Self::Box { half_extents: e } | Self::Ellipsoid { semi_axes: e } => {
                *e = DVec3::from_slice(values);
                3
            }
            Self::Capsule { radius, half_length }
            | Self::Cylinder { radius, half_length }
            | Self::Cone { radius, half_length } => {
                (*radius, *half_length) = (values[0], values[1]);
                2
            }
        };
        if values[used..].iter().all(|x| *x == 0.0) { Ok(()) } else { Err("this shape has fewer sizes than that") }
    }
}

/// `kp` (0) or `kv` (1) of a servo, zero for other actuators.
pub(super) fn read_servo(kind: &ActuatorKind, which: usize, out: &mut [f64]) {
    out[0] = match kind {
        ActuatorKind::Position { kp, kv } => [*kp, *kv][which],
        ActuatorKind::Velocity { kv } => [0.0, *kv][which],
        ActuatorKind::Motor | ActuatorKind::Speed | ActuatorKind::Affine { .. } | ActuatorKind::Muscle(_) => 0.0,
    };
}

/// The same, written.
pub(super) fn write_servo(kind: &mut ActuatorKind, which: usize, values: &[f64]) -> Written {
    match kind {
        ActuatorKind::Position { kp, kv } => *[kp, kv][which] = values[0],
        ActuatorKind::Velocity { kv } if which == 1 => *kv = values[0],
        ActuatorKind::Velocity { .. } => return Err("a velocity servo has no kp"),
        ActuatorKind::Affine { .. } => {
            return Err("an affine actuator has actuator_gain and actuator_bias in place of kp and kv");
        }
        ActuatorKind::Motor | ActuatorKind::Speed | ActuatorKind::Muscle(_) => {
            return Err("only servos have kp and kv");
        }
    }
    Ok(())
}

/// `g` of an affine actuator's law, zeros for others.
pub(super) fn read_affine(kind: &ActuatorKind, which: usize, out: &mut [f64]) {
    match kind {
        ActuatorKind::Affine { gain, bias } => out.copy_from_slice([gain, bias][which]),
        _ => out.fill(0.0),
    }
}

/// The same, written; `which` is 0 for the gain and 1 for the bias.
pub(super) fn write_affine(kind: &mut ActuatorKind, which: usize, values: &[f64]) -> Written {
    match kind {
        ActuatorKind::Affine { gain, bias } => {
            [gain, bias][which].copy_from_slice(values);
            Ok(())
        }
        _ => Err("only an affine actuator (MJCF general) has these; a servo has actuator_kp and actuator_kv"),
    }
}
