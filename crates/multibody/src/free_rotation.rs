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

use crate::composite::RigidInertia;
use crate::kinematics::Kinematics;
use crate::math::{Pose, cross_matrix, outer, right_jacobian, rotation_exp, scalar};
use crate::model::{BodyId, Joint, JointKind, Model};

/// Newton's method needs about three steps; after these it is given up.
const MAX_ITERATIONS: u32 = 20;

/// A body that turns freely, with all that is welded to it; inertias in its own axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FreeRotation {
    body: usize,
    /// First of its three rotational degrees of freedom.
    dof: usize,
    /// First of its three translational degrees of freedom, unless it is held at a point.
    translation: Option<usize>,
    mass: f64,
    /// Centre of mass from the point that the velocity of the translation belongs to; zero for a body that is held.
    center: DVec3,
    /// Rotational inertia about the centre of mass, or about the point where the body is held.
    inertia: DMat3,
    inverse: DMat3,
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
        let mut carries = vec![false; model.nv];
        model.dof_parent.iter().flatten().for_each(|&parent| carries[parent] = true);
        let alone = |first: usize, last: usize| model.dof_parent[first].is_none() && !carries[last];
        let mut welded = vec![Vec::new(); model.bodies.len()];
        (0..).zip(&model.body_weld).for_each(|(i, body)| welded[body.index()].push(i));
        let of_joint = |joint: &Joint| {
            let k = joint.v_index;
            match joint.kind {
                // Rotor inertia on the translations of a free joint is no mass that has a centre.
                JointKind::Free if joint.armature == 0.0 && alone(k, k + 5) => {
                    let whole = welded_inertia(model, joint.body, &welded, DVec3::ZERO);
                    let center = whole.first_moment / whole.mass;
                    let shift = scalar(center.length_squared()) - outer(center, center);
                    let about_center = whole.rotational - shift * whole.mass;
                    Some(Self::new(joint.body, k + 3, Some(k), whole.mass, center, about_center))
                }
                JointKind::Ball if alone(k, k + 2) => {
                    let whole = welded_inertia(model, joint.body, &welded, joint.anchor);
                    let inertia = whole.rotational + scalar(joint.armature);
                    Some(Self::new(joint.body, k, None, whole.mass, DVec3::ZERO, inertia))
                }
                _ => None,
            }
        };
        model.joints.iter().filter_map(of_joint).collect()
    }

    fn new(body: BodyId, dof: usize, translation: Option<usize>, mass: f64, center: DVec3, inertia: DMat3) -> Self {
        Self { body: body.index(), dof, translation, mass, center, inertia, inverse: inertia.inverse() }
    }

    /// Its degrees of freedom: the first of the translation, if it has one, and the first of the rotation.
    pub fn dofs(&self) -> (Option<usize>, usize) {
        (self.translation, self.dof)
    }

    /// The impulse that turns the explicit gyroscopic impulse into that of the variational integrator.
    /// - `v`: `[nv]`; `dt`: Δt, s
    pub fn correction(&self, kinematics: &Kinematics, v: &[f64], dt: f64) -> Correction {
        let omega = DVec3::from_slice(&v[self.dof..self.dof + 3]);
        // The two differ by the square of the angle; where that is under rounding there is nothing to do.
        if omega.length_squared() * (dt * dt) < f64::EPSILON {
            return Correction { linear: DVec3::ZERO, angular: DVec3::ZERO, resolved: true };
        }
        let spin = self.inertia * omega;
        let torque = omega.cross(spin);
        let next = self.turn(omega, spin, torque, dt);
        let turned = next.map_or(DVec3::ZERO, |next| next - omega);
        let angular = torque * dt + self.inertia * turned;
        let c = self.center;
        if c == DVec3::ZERO {
            return Correction { linear: DVec3::ZERO, angular, resolved: next.is_some() };
        }
        // By how much the velocity of the origin changes while the centre of mass goes straight on.
        let change = (swept(c, omega * -dt) + swept(c, (omega + turned) * dt)) * (-1.0 / dt);
        let linear = (omega.cross(omega.cross(c)) * dt + change + turned.cross(c)) * self.mass;
        Correction {
            linear: kinematics.rotation[self.body] * linear,
            angular: angular + c.cross(linear),
            resolved: next.is_some(),
        }
    }

    /// How the [correction](Self::correction) changes with `ω`: of its linear part in the body's axes, and of its angular part; columns
    /// by the components of `ω`. Nothing where the integrator has no solution.
    /// - `v`: `[nv]`; `dt`: Δt, s
    ///
    /// # Source
    /// The equation of the integrator is differentiated implicitly; `D(x) y` and `exp(x) c` by hand.
    pub fn correction_slope(&self, v: &[f64], dt: f64) -> Option<[DMat3; 2]> {
        let omega = DVec3::from_slice(&v[self.dof..self.dof + 3]);
        if omega.length_squared() * (dt * dt) < f64::EPSILON {
            return Some([DMat3::ZERO; 2]);
        }
        let spin = self.inertia * omega;
        let torque = omega.cross(spin);
        let next = self.turn(omega, spin, torque, dt)?;
        let by_end = transported_slope(next * dt, self.inertia * next) * dt + transport(next * dt) * self.inertia;
        let by_begin = transport(omega * -dt) * self.inertia - transported_slope(omega * -dt, spin) * dt;
        let next_slope = by_end.inverse() * by_begin;
        let torque_slope = cross_matrix(omega) * self.inertia - cross_matrix(spin);
        let turned_slope = next_slope - DMat3::IDENTITY;
        let angular = torque_slope * dt + self.inertia * turned_slope;
        let c = self.center;
        if c == DVec3::ZERO {
            return Some([DMat3::ZERO, angular]);
        }
        let across = cross_matrix(c);
        let centripetal = -(cross_matrix(omega.cross(c)) + cross_matrix(omega) * across);
        let change = swept_slope(c, next * dt) * next_slope - swept_slope(c, omega * -dt);
        let linear = (centripetal * dt - change - across * turned_slope) * self.mass;
        Some([linear, angular + across * linear])
    }

    /// The point that its inertia refers to before the centre of mass is taken: the origin of its body, or the centre of its ball joint.
    pub fn anchor(&self, model: &Model) -> DVec3 {
        match self.translation {
            Some(_) => DVec3::ZERO,
            None => model.joints[model.dof_joint[self.dof].index()].anchor,
        }
    }

    /// How the [correction](Self::correction) changes with its inertia: linear part in the body's axes, angular part. Nothing where the
    /// integrator has no solution.
    /// - `change`: about its [anchor](Self::anchor), body axes
    ///
    /// # Source
    /// `D(Δt ω⁺) I ω⁺ = D(−Δt ω) I ω` is linear in `I`.
    pub fn correction_by_inertia(&self, v: &[f64], dt: f64, change: &RigidInertia) -> Option<[DVec3; 2]> {
        let omega = DVec3::from_slice(&v[self.dof..self.dof + 3]);
        if omega.length_squared() * (dt * dt) < f64::EPSILON {
            return Some([DVec3::ZERO; 2]);
        }
        let (spin, torque) = (self.inertia * omega, omega.cross(self.inertia * omega));
        let next = self.turn(omega, spin, torque, dt)?;
        let (c, moved) = match self.translation {
            Some(_) => (self.center, (change.first_moment - self.center * change.mass) / self.mass),
            None => (DVec3::ZERO, DVec3::ZERO),
        };
        // About the centre of mass: to first order, what moves the centre changes nothing there but by the first moment.
        let shift = scalar(2.0 * c.dot(change.first_moment) - change.mass * c.length_squared())
            - outer(c, change.first_moment)
            - outer(change.first_moment, c)
            + outer(c, c) * change.mass;
        let inertia = if self.translation.is_some() { change.rotational - shift } else { change.rotational };
        let by_next = transported_slope(next * dt, self.inertia * next) * dt + transport(next * dt) * self.inertia;
        let missing = transported(omega * -dt, inertia * omega) - transported(next * dt, inertia * next);
        let next_change = by_next.inverse() * missing;
        let turned = next - omega;
        let angular = omega.cross(inertia * omega) * dt + inertia * turned + self.inertia * next_change;
        if self.translation.is_none() {
            return Some([DVec3::ZERO, angular]);
        }
        let straight = |c: DVec3| {
            let change = (swept(c, omega * -dt) + swept(c, next * dt)) * (-1.0 / dt);
            omega.cross(omega.cross(c)) * dt + change + turned.cross(c)
        };
        let linear = straight(c) * self.mass;
        let by_next = next_change.cross(c) - swept_slope(c, next * dt) * next_change;
        let linear_change = straight(c) * change.mass + (straight(moved) + by_next) * self.mass;
        Some([linear_change, angular + moved.cross(linear) + c.cross(linear_change)])
    }

    /// How the [correction](Self::correction) changes with Δt, as [by the inertia](Self::correction_by_inertia).
    pub fn correction_by_timestep(&self, v: &[f64], dt: f64) -> Option<[DVec3; 2]> {
        let omega = DVec3::from_slice(&v[self.dof..self.dof + 3]);
        if omega.length_squared() * (dt * dt) < f64::EPSILON {
            return Some([DVec3::ZERO; 2]);
        }
        let (spin, torque) = (self.inertia * omega, omega.cross(self.inertia * omega));
        let next = self.turn(omega, spin, torque, dt)?;
        let along_next = transported_slope(next * dt, self.inertia * next);
        let by_next = along_next * dt + transport(next * dt) * self.inertia;
        let missing = transported_slope(omega * -dt, spin) * -omega - along_next * next;
        let next_change = by_next.inverse() * missing;
        let angular = torque + self.inertia * next_change;
        let c = self.center;
        if c == DVec3::ZERO {
            return Some([DVec3::ZERO, angular]);
        }
        let swept_both = swept(c, omega * -dt) + swept(c, next * dt);
        let by_both = swept_slope(c, next * dt) * (next + next_change * dt) - swept_slope(c, omega * -dt) * omega;
        let change = swept_both / (dt * dt) - by_both / dt;
        let linear = (omega.cross(omega.cross(c)) + change + next_change.cross(c)) * self.mass;
        Some([linear, angular + c.cross(linear)])
    }

    /// `ω⁺` of `D(Δt ω⁺) I ω⁺ = D(−Δt ω) I ω` by Newton's method; nothing where it does not converge or the body turns by
    /// more than half a turn in the step. An angular velocity along a principal axis is returned unchanged at any speed.
    /// - `spin`: `I ω`; `torque`: `ω × I ω`
    fn turn(&self, omega: DVec3, spin: DVec3, torque: DVec3, dt: f64) -> Option<DVec3> {
        let scale = spin.length_squared();
        if torque.length_squared() <= 1e-28 * omega.length_squared() * scale {
            return Some(omega);
        }
        let resolved = |omega: DVec3| omega.length_squared() * (dt * dt) < std::f64::consts::PI.powi(2);
        if !resolved(omega) {
            return None;
        }
        let inertia = self.inertia;
        let momentum = transported(omega * -dt, spin);
        let mut next = omega - self.inverse * torque * dt;
        if !(next.is_finite() && resolved(next)) {
            next = omega;
        }
        let mut last = f64::INFINITY;
        for _ in 0..MAX_ITERATIONS {
            let (x, y) = (next * dt, inertia * next);
            let residual = transported(x, y) - momentum;
            let size = residual.length_squared();
            // Nothing but rounding is left, or rounding has stopped the descent.
            if size <= (2.0 * f64::EPSILON).powi(2) * scale || (size >= 0.25 * last && size <= 1e-26 * scale) {
                return Some(next);
            }
            last = size;
            let c = cotangent_factor(x.length_squared());
            // The change of c with x is left out: it is of fourth order in Δt ω.
            let across = crossed(x, inertia) - cross_matrix(y) * dt;
            let slope = inertia + across * 0.5 + (crossed(x, across) - cross_matrix(x.cross(y)) * dt) * c;
            next -= slope.inverse() * residual;
            if !(next.is_finite() && resolved(next)) {
                return None;
            }
        }
        None
    }
}

/// The inertia of a body and all that is welded to it, about `point` (body axes).
/// - `welded`: of each body those that are welded to it, itself among them
fn welded_inertia(model: &Model, body: BodyId, welded: &[Vec<usize>], point: DVec3) -> RigidInertia {
    let mut whole = RigidInertia::ZERO;
    for &i in &welded[body.index()] {
        let (mut pose, mut b) = (Pose::IDENTITY, i);
        while b != body.index() {
            pose = model.bodies[b].placement * pose;
            b = model.bodies[b].parent.index();
        }
        let part = RigidInertia::in_body_axes(&model.bodies[i].inertia).turned(pose.rotation_matrix());
        whole.add_at(&part, pose.position - point);
    }
    whole
}

/// `[x]× m`.
fn crossed(x: DVec3, m: DMat3) -> DMat3 {
    DMat3::from_cols(x.cross(m.x_axis), x.cross(m.y_axis), x.cross(m.z_axis))
}

/// `(exp(x) − 1) c`: how far the point `c` moves when it is turned by the rotation vector `x`.
fn swept(c: DVec3, x: DVec3) -> DVec3 {
    let square = x.length_squared();
    // sin θ/θ and (1 − cos θ)/θ²; below 0.1 the next terms of the series are under rounding.
    let (sine, cosine) = if square < 0.01 {
        let sine = 1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0)));
        let cosine = 0.5 - square / 24.0 * (1.0 - square / 30.0 * (1.0 - square / 56.0 * (1.0 - square / 90.0)));
        (sine, cosine)
    } else {
        let angle = square.sqrt();
        let half = (0.5 * angle).sin();
        (angle.sin() / angle, 2.0 * half * half / square)
    };
    let across = x.cross(c);
    across * sine + x.cross(across) * cosine
}

/// `∂/∂x exp(x) c = −exp(x) [c]× J_r(x)`, with the right Jacobian of the rotation group.
fn swept_slope(c: DVec3, x: DVec3) -> DMat3 {
    DMat3::from_quat(rotation_exp(x)) * cross_matrix(c) * right_jacobian(x) * -1.0
}

/// `c(θ) = (1 − θ/2 cot θ/2) / θ²` from θ².
fn cotangent_factor(square: f64) -> f64 {
    if square < 0.01 {
        return 1.0 / 12.0 + square * (1.0 / 720.0 + square * (1.0 / 30240.0 + square / 1_209_600.0));
    }
    let half = 0.5 * square.sqrt();
    (1.0 - half / half.tan()) / square
}

/// `∂c/∂(θ²)`.
fn cotangent_factor_slope(square: f64) -> f64 {
    if square < 0.01 {
        return 1.0 / 720.0 + square * (2.0 / 30240.0 + square * (3.0 / 1_209_600.0));
    }
    // With h = θ/2: θ² c = 1 − h cot h, whose slope by θ² is (h/sin² h − cot h)/(8 h).
    let half = 0.5 * square.sqrt();
    let sine = half.sin();
    let product_slope = (half / (sine * sine) - 1.0 / half.tan()) / (8.0 * half);
    (product_slope - cotangent_factor(square)) / square
}

/// `D(x)` as a matrix.
fn transport(x: DVec3) -> DMat3 {
    let across = cross_matrix(x);
    DMat3::IDENTITY + across * 0.5 + across * across * cotangent_factor(x.length_squared())
}

/// `∂/∂x D(x) y`.
fn transported_slope(x: DVec3, y: DVec3) -> DMat3 {
    let square = x.length_squared();
    let twice = (cross_matrix(x.cross(y)) + cross_matrix(x) * cross_matrix(y)) * -cotangent_factor(square);
    cross_matrix(y) * -0.5 + twice + outer(x.cross(x.cross(y)), x) * (2.0 * cotangent_factor_slope(square))
}

/// `D(x) y`.
fn transported(x: DVec3, y: DVec3) -> DVec3 {
    let across = x.cross(y);
    y + across * 0.5 + x.cross(across) * cotangent_factor(x.length_squared())
}
