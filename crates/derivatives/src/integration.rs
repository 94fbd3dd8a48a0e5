//! Derivatives of `q⁺ = q ⊕ Δt v⁺` in tangent coordinates: rotations are varied from the right at both ends.

use signorini_multibody::glam::{DMat3, DVec3};
use signorini_multibody::{JointKind, Model, right_jacobian, rotation_exp};

/// The blocks of three degrees of freedom that turn, each with how the end moves with the beginning and with `v⁺`.
#[derive(Clone, Debug, Default)]
pub(crate) struct Integration {
    dt: f64,
    turns: Vec<(usize, DMat3, DMat3)>,
}

impl Integration {
    /// - `velocity`: `v⁺`, `[nv]`
    pub fn set(&mut self, model: &Model, velocity: &[f64], dt: f64) {
        self.dt = dt;
        self.turns.clear();
        for joint in &model.joints {
            let first = match joint.kind {
                JointKind::Free => joint.v_index + 3,
                JointKind::Ball => joint.v_index,
                JointKind::Hinge { .. } | JointKind::Slide { .. } => continue,
            };
            let turn = DVec3::from_slice(&velocity[first..]) * dt;
            let back = DMat3::from_quat(rotation_exp(-turn));
            self.turns.push((first, back, right_jacobian(turn) * dt));
        }
    }

    /// `δq⁺` from `δq` and `δv⁺`, all `[nv]`.
    pub fn forward(&self, dq: &[f64], dv: &[f64], out: &mut [f64]) {
        for (k, out) in out.iter_mut().enumerate() {
            *out = dq[k] + self.dt * dv[k];
        }
        for (first, by_begin, by_velocity) in &self.turns {
            let end = *by_begin * DVec3::from_slice(&dq[*first..]) + *by_velocity * DVec3::from_slice(&dv[*first..]);
            out[*first..first + 3].copy_from_slice(&end.to_array());
        }
    }

    /// `∂q⁺` from `∂v⁺` for many columns, row by row; `by_configuration`: whether the first columns are those by `q`.
    pub fn forward_rows(&self, velocity: &[f64], width: usize, by_configuration: bool, out: &mut [f64]) {
        out.iter_mut().zip(velocity).for_each(|(place, velocity)| *place = self.dt * velocity);
        let nv = out.len().checked_div(width).unwrap_or(0);
        if by_configuration {
            (0..nv).for_each(|k| out[k * width + k] += 1.0);
        }
        for (first, by_begin, by_velocity) in &self.turns {
            for c in 0..width {
                let at = |a: usize| (first + a) * width + c;
                let dv = DVec3::new(velocity[at(0)], velocity[at(1)], velocity[at(2)]);
                let end = *by_velocity * dv;
                (0..3).for_each(|a| out[at(a)] = end[a]);
            }
            for (a, b) in (0..9).map(|k| (k / 3, k % 3)).filter(|_| by_configuration) {
                out[(first + a) * width + first + b] += by_begin.col(b)[a];
            }
        }
    }

    /// The adjoint: from that of `q⁺` what it adds to those of `q` and `v⁺`.
    pub fn backward(&self, end: &[f64], dq: &mut [f64], dv: &mut [f64]) {
        let mut turns = self.turns.iter().peekable();
        let mut k = 0;
        while k < end.len() {
            match turns.peek() {
                Some((first, by_begin, by_velocity)) if *first == k => {
                    let x = DVec3::from_slice(&end[k..]);
                    let (begin, velocity) = (by_begin.mul_transpose_vec3(x), by_velocity.mul_transpose_vec3(x));
                    for a in 0..3 {
                        dq[k + a] += begin[a];
                        dv[k + a] += velocity[a];
                    }
                    turns.next();
                    k += 3;
                }
                _ => {
                    dq[k] += end[k];
                    dv[k] += self.dt * end[k];
                    k += 1;
                }
            }
        }
    }
}
