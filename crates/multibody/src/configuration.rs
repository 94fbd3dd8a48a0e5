//! The configuration manifold: moving along a velocity, and the velocity between two configurations.

use glamx::glam::DVec3;

use crate::math::{read_quaternion, rotation_exp, rotation_log, write_quaternion};
use crate::model::{JointKind, Model};
use crate::standing::{Known, Nothing, StandingTrees};

/// Advances a configuration along a generalized velocity on its manifold, `q⁺ = q ⊕ Δt v` (formulation §6).
///
/// Slides and hinges add `Δt v`; a free body's position adds `Δt` times its velocity in world axes; orientations are
/// multiplied from the right by the exact exponential of the body-frame `Δt ω` and normalised.
/// - `q`: `[nq]`; `v`: `[nv]`; `dt`: Δt, s; `q_out`: out, `[nq]`
///
/// # Panics
/// If a length does not fit the model.
pub fn integrate_into(model: &Model, q: &[f64], v: &[f64], dt: f64, q_out: &mut [f64]) {
    integrate_of(model, q, v, dt, Nothing, q_out);
}

/// [`integrate_into`] where some trees have no velocity, and `q_out` has their coordinates.
///
/// # Panics
/// As there, or if `standing` is of another model.
pub fn integrate_beside(model: &Model, q: &[f64], v: &[f64], dt: f64, standing: &StandingTrees, q_out: &mut [f64]) {
    integrate_of(model, q, v, dt, standing, q_out);
}

fn integrate_of(model: &Model, q: &[f64], v: &[f64], dt: f64, known: impl Known, q_out: &mut [f64]) {
    assert!(q.len() == model.nq && v.len() == model.nv && q_out.len() == model.nq, "lengths must be nq, nv, nq");
    let turn = |q: &[f64], v: &[f64], out: &mut [f64]| {
        let step = rotation_exp(DVec3::new(v[0], v[1], v[2]) * dt);
        write_quaternion((read_quaternion(q) * step).normalize(), out);
    };
    for joint in model.joints.iter().filter(|joint| !known.has_dof(joint.v_index)) {
        let (i, k) = (joint.q_index, joint.v_index);
        match joint.kind {
            JointKind::Free => {
                for a in 0..3 {
                    q_out[i + a] = q[i + a] + dt * v[k + a];
                }
                turn(&q[i + 3..], &v[k + 3..], &mut q_out[i + 3..]);
            }
            JointKind::Ball => turn(&q[i..], &v[k..], &mut q_out[i..]),
            JointKind::Hinge { .. } | JointKind::Slide { .. } => q_out[i] = q[i] + dt * v[k],
        }
    }
}

/// The velocity that leads from one configuration to another in unit time, `v = q1 ⊖ q0`: `q0 ⊕ v = q1`.
///
/// Rotations go the short way (an angle of at most π).
/// - `q1`, `q0`: `[nq]`; `v_out`: out, `[nv]`
///
/// # Panics
/// If a length does not fit the model.
pub fn difference_into(model: &Model, q1: &[f64], q0: &[f64], v_out: &mut [f64]) {
    assert!(q1.len() == model.nq && q0.len() == model.nq && v_out.len() == model.nv, "lengths must be nq, nq, nv");
    let turn = |q1: &[f64], q0: &[f64], out: &mut [f64]| {
        let w = rotation_log(read_quaternion(q0).conjugate() * read_quaternion(q1));
        out[..3].copy_from_slice(&w.to_array());
    };
    for joint in &model.joints {
        let (i, k) = (joint.q_index, joint.v_index);
        match joint.kind {
            JointKind::Free => {
                for a in 0..3 {
                    v_out[k + a] = q1[i + a] - q0[i + a];
                }
                turn(&q1[i + 3..], &q0[i + 3..], &mut v_out[k + 3..]);
            }
            JointKind::Ball => turn(&q1[i..], &q0[i..], &mut v_out[k..]),
            JointKind::Hinge { .. } | JointKind::Slide { .. } => v_out[k] = q1[i] - q0[i],
        }
    }
}
