//! Gyroscopic torque of bodies that turn freely, so that a fast one tumbles as it should.
//!
//! With `h` taken at the beginning of a step a tumbling body gains energy in every step. A body on a free or ball joint
//! that carries no other joint gets instead the velocity of the variational integrator on the rotation group that
//! belongs to the step `R⁺ = R exp(Δt ω⁺)`: with `I` the inertia about the centre of mass (or the ball's centre) and
//! `ω`, `ω⁺` in body axes,
//!
//! ```text
//! D(Δt ω⁺) I ω⁺ = D(−Δt ω) I ω,   D(x) y = y + ½ x × y + c(|x|) x × (x × y),   c(θ) = (1 − θ/2 cot θ/2) / θ²,
//! ```
//!
//! where `D(x)` is the transpose of `dexp⁻¹(x)`. Both sides are the body's angular momentum in its axes at the beginning
//! of the step, so that `R D(−Δt ω) I ω` stays to rounding; `ω⁺` is the mean angular velocity of the step, which is why
//! the energy `½ ω·Iω` stays within O(Δt²) and does not drift, and `R I ω` within O(Δt) of the momentum. A centre of
//! mass off the origin moves on a straight line in the same sense.
//!
//! # Source
//! Marsden, Pekarsky, Shkoller (1999), Discrete Euler–Poincaré and Lie–Poisson equations, Nonlinearity 12; Bou-Rabee,
//! Marsden (2009), Hamilton–Pontryagin integrators on Lie groups, Foundations of Computational Mathematics 9 (the
//! symplectic Euler method, here with the exponential map).

use glamx::glam::{DMat3, DVec3};

use crate::kinematics::Kinematics;
use crate::mass::BlockDiagonal;
use crate::math::{cross_matrix, outer, scalar};
use crate::model::{JointKind, Model};

/// Newton's method needs about three steps; after these it is given up.
const MAX_ITERATIONS: u32 = 20;

/// A body that turns freely.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FreeRotation {
    body: usize,
    /// First of its three rotational degrees of freedom.
    dof: usize,
    /// First of its three translational degrees of freedom, unless it is held at a point.
    translation: Option<usize>,
}

/// What is to be added to the impulse `Δt (τ − h)` of the degrees of freedom of one body.
pub(crate) struct Correction {
    /// On the translation, world axes, N·s.
    pub linear: DVec3,
    /// On the rotation, body axes, N·m·s.
    pub angular: DVec3,
    /// Whether the integrator has a solution; otherwise the gyroscopic torque is left out.
    pub resolved: bool,
}

impl FreeRotation {
    /// All of a model's: bodies whose free or ball joint has a tree of its own.
    pub fn all(model: &Model) -> Vec<Self> {
        let alone = |first: usize, last: usize| {
            model.dof_parent[first].is_none() && !model.dof_parent[last + 1..].contains(&Some(last))
        };
        let of_joint = |joint: &crate::Joint| {
            let (k, body) = (joint.v_index, joint.body.index());
            match joint.kind {
                // Rotor inertia on the translations of a free joint is no mass that has a centre.
                JointKind::Free if joint.armature == 0.0 && alone(k, k + 5) => {
                    Some(Self { body, dof: k + 3, translation: Some(k) })
                }
                JointKind::Ball if alone(k, k + 2) => Some(Self { body, dof: k, translation: None }),
                _ => None,
            }
        };
        model.joints.iter().filter_map(of_joint).collect()
    }

    /// Its degrees of freedom: the first of the translation, if it has one, and the first of the rotation.
    pub fn dofs(&self) -> (Option<usize>, usize) {
        (self.translation, self.dof)
    }

    /// The impulse that turns the explicit gyroscopic impulse into that of the variational integrator.
    /// - `mass`: `M`, without implicit terms; `v`: `[nv]`; `dt`: Δt, s
    pub fn correction(&self, kinematics: &Kinematics, mass: &BlockDiagonal, v: &[f64], dt: f64) -> Correction {
        let k = self.dof;
        let omega = DVec3::new(v[k], v[k + 1], v[k + 2]);
        if omega == DVec3::ZERO {
            return Correction { linear: DVec3::ZERO, angular: DVec3::ZERO, resolved: true };
        }
        let row = |a: usize, first: usize| DVec3::from([0, 1, 2].map(|b| mass.get(k + a, first + b)));
        let about_origin = DMat3::from_cols(row(0, k), row(1, k), row(2, k));
        let Some(t) = self.translation else {
            let next = turn(about_origin, omega, dt);
            let turned = next.map_or(DVec3::ZERO, |next| next - omega);
            let angular = omega.cross(about_origin * omega) * dt + about_origin * turned;
            return Correction { linear: DVec3::ZERO, angular, resolved: next.is_some() };
        };
        let rotation = kinematics.rotation[self.body];
        let m = mass.get(t, t);
        // Row a of the coupling is `axis_a × s`, s the first moment, and Σ axis × (axis × s) = −2 s.
        let moments = (0..3).map(|a| kinematics.dof_angular[k + a].cross(row(a, t)));
        let c = rotation.mul_transpose_vec3(moments.sum::<DVec3>() * (-0.5 / m));
        let about_com = about_origin - (scalar(c.length_squared()) - outer(c, c)) * m;
        let next = turn(about_com, omega, dt);
        let turned = next.map_or(DVec3::ZERO, |next| next - omega);
        // By how much the velocity of the origin changes while the centre of mass goes straight on.
        let change = (swept(c, omega * -dt) + swept(c, (omega + turned) * dt)) * (-1.0 / dt);
        let linear = (omega.cross(omega.cross(c)) * dt + change + turned.cross(c)) * m;
        let angular = omega.cross(about_origin * omega) * dt + about_origin * turned + c.cross(change) * m;
        Correction { linear: rotation * linear, angular, resolved: next.is_some() }
    }
}

/// `(exp(x) − 1) c`: how far the point `c` moves when it is turned by the rotation vector `x`.
fn swept(c: DVec3, x: DVec3) -> DVec3 {
    let square = x.length_squared();
    // sin θ/θ and (1 − cos θ)/θ²; below 1e-4 the next terms are under rounding.
    let (sine, cosine) = if square < 1e-8 {
        (1.0 - square / 6.0, 0.5 - square / 24.0)
    } else {
        let angle = square.sqrt();
        let half = (0.5 * angle).sin();
        (angle.sin() / angle, 2.0 * half * half / square)
    };
    let across = x.cross(c);
    across * sine + x.cross(across) * cosine
}

/// `c(θ) = (1 − θ/2 cot θ/2) / θ²` from θ².
fn cotangent_factor(square: f64) -> f64 {
    if square < 0.01 {
        return 1.0 / 12.0 + square * (1.0 / 720.0 + square * (1.0 / 30240.0 + square / 1_209_600.0));
    }
    let half = 0.5 * square.sqrt();
    (1.0 - half / half.tan()) / square
}

/// `D(x) y`.
fn transported(x: DVec3, y: DVec3) -> DVec3 {
    let across = x.cross(y);
    y + across * 0.5 + x.cross(across) * cotangent_factor(x.length_squared())
}

/// `ω⁺` of `D(Δt ω⁺) I ω⁺ = D(−Δt ω) I ω` by Newton's method; nothing where it does not converge or the body turns by more
/// than half a turn in the step. An angular velocity along a principal axis is returned unchanged at any speed.
fn turn(inertia: DMat3, omega: DVec3, dt: f64) -> Option<DVec3> {
    let spin = inertia * omega;
    if omega.cross(spin).length() <= 1e-14 * omega.length() * spin.length() {
        return Some(omega);
    }
    let resolved = |omega: DVec3| omega.length() * dt < std::f64::consts::PI;
    if !resolved(omega) {
        return None;
    }
    let momentum = transported(omega * -dt, spin);
    let scale = spin.length();
    let (mut next, mut last) = (omega, f64::INFINITY);
    for _ in 0..MAX_ITERATIONS {
        let (x, y) = (next * dt, inertia * next);
        let residual = transported(x, y) - momentum;
        let size = residual.length();
        // Nothing but rounding is left, or rounding has stopped the descent.
        if size <= 2.0 * f64::EPSILON * scale || (size >= 0.5 * last && size <= 1e-13 * scale) {
            return Some(next);
        }
        last = size;
        let (x_cross, y_cross) = (cross_matrix(x), cross_matrix(y));
        let c = cotangent_factor(x.length_squared());
        // The change of c with x is left out: it is of fourth order in Δt ω.
        let slope = inertia
            + (x_cross * inertia - y_cross * dt) * 0.5
            + (x_cross * x_cross * inertia - (cross_matrix(x.cross(y)) + x_cross * y_cross) * dt) * c;
        next -= slope.inverse() * residual;
        if !(next.is_finite() && resolved(next)) {
            return None;
        }
    }
    None
}
