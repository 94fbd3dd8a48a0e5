//! Rigid poses and rotations.

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

/// Squares of lengths this near to 1 are those of unit vectors and quaternions, rounded.
const UNIT: f64 = 1e-15;

/// The quaternion made unit; one that is unit to rounding stays as it is, so that what is written and read again has the same bits.
pub fn unit_rotation(r: DQuat) -> DQuat {
    if (r.length_squared() - 1.0).abs() <= UNIT { r } else { r.normalize() }
}

/// The vector made unit; one that is unit to rounding stays as it is.
pub fn unit_vector(v: DVec3) -> DVec3 {
    if (v.length_squared() - 1.0).abs() <= UNIT { v } else { v.normalize() }
}

/// The rotation by a rotation vector (axis times angle, rad): `exp` of the rotation group as a unit quaternion.
pub fn rotation_exp(w: DVec3) -> DQuat {
    let angle = w.length();
    // sin(x/2)/x = 1/2 − x²/48 + …; below 1e-4 the next term is under the rounding of 1/2.
    let scale = if angle < 1e-4 { 0.5 - angle * angle / 48.0 } else { (0.5 * angle).sin() / angle };
    let v = w * scale;
    DQuat::from_xyzw(v.x, v.y, v.z, (0.5 * angle).cos())
}

/// The rotation vector (rad, length at most π) of a unit quaternion: inverse of [`rotation_exp`].
pub fn rotation_log(r: DQuat) -> DVec3 {
    let sign = if r.w < 0.0 { -1.0 } else { 1.0 };
    let (v, w) = (DVec3::new(r.x, r.y, r.z) * sign, r.w * sign);
    let sine = v.length();
    // atan(x)/x = 1 − x²/3 + …; below 1e-5 the next term is under the rounding of 1.
    let half_over_sine = if sine < 1e-5 * w { (1.0 - sine * sine / (3.0 * w * w)) / w } else { sine.atan2(w) / sine };
    v * (2.0 * half_over_sine)
}

/// The quaternion stored as (w, x, y, z) at the front of a slice of `q`, normalised.
pub(crate) fn read_quaternion(q: &[f64]) -> DQuat {
    DQuat::from_xyzw(q[1], q[2], q[3], q[0]).normalize()
}

/// Stores a quaternion as (w, x, y, z).
pub(crate) fn write_quaternion(r: DQuat, q: &mut [f64]) {
    q[..4].copy_from_slice(&[r.w, r.x, r.y, r.z]);
}

/// The outer product `a bᵀ`.
pub(crate) fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// `s` times the identity.
pub(crate) fn scalar(s: f64) -> DMat3 {
    DMat3::from_diagonal(DVec3::splat(s))
}

/// `[a]×`, with `[a]× b = a × b`.
pub(crate) fn cross_matrix(a: DVec3) -> DMat3 {
    DMat3::from_cols(DVec3::new(0.0, a.z, -a.y), DVec3::new(-a.z, 0.0, a.x), DVec3::new(a.y, -a.x, 0.0))
}

/// The right Jacobian of the rotation group: `exp(x + δ) = exp(x) exp(J_r(x) δ)` to first order.
///
/// # Source
/// J. Solà, J. Deray, D. Atchuthan, *A micro Lie theory for state estimation in robotics* (2018), eq. 143.
pub fn right_jacobian(x: DVec3) -> DMat3 {
    let square = x.length_squared();
    // (1 − cos θ)/θ² and (θ − sin θ)/θ³; below 0.1 the next terms of the series are under rounding.
    let (first, second) = if square < 0.01 {
        let first = 0.5 - square / 24.0 * (1.0 - square / 30.0 * (1.0 - square / 56.0 * (1.0 - square / 90.0)));
        let second =
            1.0 / 6.0 - square / 120.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0 * (1.0 - square / 110.0)));
        (first, second)
    } else {
        let angle = square.sqrt();
        let half = (0.5 * angle).sin();
        (2.0 * half * half / square, (angle - angle.sin()) / (square * angle))
    };
    let across = cross_matrix(x);
    DMat3::IDENTITY - across * first + across * across * second
}
