//! What Coriolis forces at both ends of a step add to the derivatives of its balance.
//!
//! They act as `T = Δt C(q, v) (w − v)` beside those of the beginning, where `w` is the velocity at the end of the motion without contact. With
//! `E` the balance without `T`, `w` is the solution of `E(w; x) + T(x, w) = 0` for whatever `x` the step depends on, so that
//!
//! ```text
//! dw/dx = −N⁻¹ ∂(E + T)/∂x at w,   d(E + T)/dx at v⁺ = ∂(E + T)/∂x at v⁺ − K ∂(E + T)/∂x at w,   K = Δt C(q, v) N⁻¹,
//! ```
//!
//! with `N = M̂ + Δt C(q, v)` and both derivatives at fixed `w`. As `C(q, v) δ` is a quarter of what `h` differs by at `v + δ` and `v − δ`,
//! `T = Δt (h(q, (v + δ)/2) − h(q, (v − δ)/2))` with `δ = w − v`, and all its derivatives are those of `h`.

use super::inverse_dynamics::{InverseDynamicsDerivatives, inverse_dynamics_derivatives_into};
use crate::free_motion::FreeMotion;
use crate::kinematics::Kinematics;
use crate::model::Model;
use crate::spatial::SpatialVector;

/// `T` with its derivatives.
#[derive(Clone, Debug)]
pub struct CoriolisTerms {
    /// Inverse dynamics at `(v + δ)/2` and `(v − δ)/2`, without acceleration.
    pub(super) halves: [InverseDynamicsDerivatives; 2],
    /// `T`, `[nv]`.
    pub(super) impulse: Vec<f64>,
    /// No impulses.
    pub(super) nothing: Vec<SpatialVector>,
    velocity: Vec<f64>,
    zero: Vec<f64>,
    pub(super) columns: [Vec<f64>; 2],
}

impl CoriolisTerms {
    pub fn new(model: &Model) -> Self {
        let half = InverseDynamicsDerivatives::new(model);
        let zero = vec![0.0; model.nv];
        Self {
            halves: [half.clone(), half],
            impulse: zero.clone(),
            nothing: vec![SpatialVector::ZERO; model.bodies.len()],
            velocity: zero.clone(),
            columns: [zero.clone(), zero.clone()],
            zero,
        }
    }

    /// `T` with its derivatives.
    pub fn set(&mut self, model: &Model, kinematics: &Kinematics, v: &[f64], dt: f64, free: &FreeMotion) {
        for (half, sign) in self.halves.iter_mut().zip([1.0, -1.0]) {
            for ((u, v), w) in self.velocity.iter_mut().zip(v).zip(&free.free_velocity) {
                *u = 0.5 * (v + sign * (w - v));
            }
            inverse_dynamics_derivatives_into(model, kinematics, &self.velocity, &self.zero, &[], half);
        }
        self.impulse.fill(0.0);
        for k in free.coriolis.turning() {
            self.impulse[k] = dt * (self.halves[0].force[k] - self.halves[1].force[k]);
        }
    }
}
