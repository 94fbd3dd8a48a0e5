//! What is applied from outside, as one generalized force.

use glamx::glam::DVec3;

use crate::jacobian::add_wrench;
use crate::kinematics::Kinematics;
use crate::model::{BodyId, Model};
use crate::state::Input;

/// The generalized force of an input: its [`generalized_force`](Input::generalized_force) and what its
/// [`wrench`](Input::wrench)es give, `τ + Σ Jᵢᵀ wᵢ`.
///
/// - `kinematics`: from [`forward_kinematics_into`](crate::forward_kinematics_into)
/// - `input`: as [`Input::check`] wants it
/// - `out`: `[nv]`, N, N·m
///
/// # Panics
/// If a length does not fit the model.
///
/// # Cost
/// O(depth) for every body with a wrench that is not zero, no allocation.
pub fn applied_force_into(model: &Model, kinematics: &Kinematics, input: &Input, out: &mut [f64]) {
    assert_eq!(out.len(), model.nv, "length must be nv");
    match &input.generalized_force[..] {
        [] => out.fill(0.0),
        force => out.copy_from_slice(force),
    }
    for (i, wrench) in input.wrench.iter().enumerate() {
        let [force, moment] = [wrench.linear, wrench.angular];
        if force != DVec3::ZERO || moment != DVec3::ZERO {
            add_wrench(model, kinematics, BodyId(i as u32), kinematics.center_of_mass[i], force, moment, out);
        }
    }
}
