//! What Coriolis forces at both ends of a step add to the derivatives of its balance.
//!
//! They act as `T = Δt C(q, v) (w − v)` beside those of the beginning, where `w` is the velocity at the end of the motion without contact. With
//! `E` the balance without `T`, `w` is the solution of `E(w; x) + T(x, w) = 0` for whatever `x` the step depends on, so that
//!
//! ```text
//! dw/dx = −N⁻¹ ∂(E + T)/∂x at w,   d(E + T)/dx at v⁺ = ∂(E + T)/∂x at v⁺ − K ∂(E + T)/∂x at w,   K = Δt C(q, v) N⁻¹,
//! ```
//!
//! with `N = M̂ + Δt C(q, v)` and both derivatives at fixed `w`. As `C(q, v) δ` is the half of what `h` differs by at `v + δ` and `v − δ`,
//! `T = Δt (h(q, (v + δ)/2) − h(q, (v − δ)/2))` with `δ = w − v`, and all its derivatives are those of `h`.

use super::balance::BalanceDerivatives;
use super::inverse_dynamics::{InverseDynamicsDerivatives, inverse_dynamics_derivatives_into};
use crate::free_motion::FreeMotion;
use crate::kinematics::Kinematics;
use crate::model::Model;
use crate::spatial::SpatialVector;

/// `T`, and the balance of the motion without contact.
#[derive(Clone, Debug)]
pub struct CoriolisBalance {
    /// Inverse dynamics at `(v + δ)/2` and `(v − δ)/2`, without acceleration.
    pub(super) halves: [InverseDynamicsDerivatives; 2],
    /// `T`, `[nv]`.
    pub(super) impulse: Vec<f64>,
    /// The balance at `w` with nothing from outside.
    pub(super) at_end: BalanceDerivatives,
    /// No impulses.
    pub(super) nothing: Vec<SpatialVector>,
    velocity: Vec<f64>,
    zero: Vec<f64>,
    columns: [Vec<f64>; 2],
    dt: f64,
}

impl CoriolisBalance {
    pub fn new(model: &Model) -> Self {
        let half = InverseDynamicsDerivatives::new(model);
        let zero = vec![0.0; model.nv];
        Self {
            halves: [half.clone(), half],
            impulse: zero.clone(),
            at_end: BalanceDerivatives::new(model),
            nothing: vec![SpatialVector::ZERO; model.bodies.len()],
            velocity: zero.clone(),
            columns: [zero.clone(), zero.clone()],
            zero,
            dt: 0.0,
        }
    }

    /// `T` with its derivatives.
    pub fn set(&mut self, model: &Model, kinematics: &Kinematics, v: &[f64], dt: f64, free: &FreeMotion) {
        self.dt = dt;
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

    /// Adds `T` to the balance at hand, which has no part of it, and to that of the motion without contact, and what the velocity at the end of that does.
    pub fn finish(&mut self, nv: usize, free: &FreeMotion, out: &mut BalanceDerivatives) {
        let Self { halves: [ahead, behind], impulse, at_end, columns: [end, own], dt, .. } = self;
        for balance in [&mut *at_end, &mut *out] {
            for k in free.coriolis.turning() {
                balance.impulse[k] += impulse[k];
                for entry in k * nv..(k + 1) * nv {
                    balance.by_configuration[entry] +=
                        *dt * (ahead.by_configuration[entry] - behind.by_configuration[entry]);
                    // ∂h/∂v at both is C(v) ± C(δ), and ∂T/∂v at fixed w is Δt (C(δ) − C(v)).
                    balance.by_velocity[entry] -= *dt * behind.by_velocity[entry];
                }
            }
        }
        for (matrix, of_end) in [
            (&mut out.by_configuration, &at_end.by_configuration),
            (&mut out.by_velocity, &at_end.by_velocity),
            (&mut out.by_control, &at_end.by_control),
            (&mut out.by_force, &at_end.by_force),
        ] {
            let width = matrix.len().checked_div(nv).unwrap_or(0);
            for column in 0..width {
                let entries = || (0..nv).map(|row| row * width + column);
                entries().zip(end.iter_mut()).for_each(|(entry, x)| *x = of_end[entry]);
                entries().zip(own.iter_mut()).for_each(|(entry, x)| *x = matrix[entry]);
                free.coriolis.subtract_carried(end, own);
                entries().zip(&*own).for_each(|(entry, x)| matrix[entry] = *x);
            }
        }
    }
}
