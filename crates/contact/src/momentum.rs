//! The balance of momentum of a claimed velocity and impulses, of each kinematic tree by its own measure (formulation §8).

use std::ops::Range;

use crate::ContactProblem;
use crate::residuals::{keep, larger};

/// Part of the numbers that a momentum balance is the difference of below which it is taken for rounding: nine digits and the margin of a
/// sum.
const DIGITS: f64 = 1e-6;

/// A momentum residual that needs no second look: the terms of the impulses would only make it smaller.
const NEGLIGIBLE: f64 = 1e-12;

/// Memory of the certificate.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    /// What the impulses add up to, then the change of the velocity that this makes.
    pub(crate) force: Vec<f64>,
    change: Vec<f64>,
    momentum: Vec<f64>,
    pub(crate) column: Vec<f64>,
    /// The velocity that the impulses give and the claimed one, of each degree of freedom.
    pub(crate) both: Vec<[f64; 2]>,
    /// How far the velocity that the impulses of the last certified solution give is from the claimed one along any row, relative
    /// to the velocity scale. The momentum residual is relative to each body's mass; this is what it means to the rows.
    pub carried: f64,
}

impl Scratch {
    /// Makes room, and the force zero.
    pub(crate) fn resize(&mut self, nv: usize) {
        self.force.clear();
        self.force.resize(nv, 0.0);
        self.change.resize(nv, 0.0);
        self.momentum.resize(nv, 0.0);
        self.both.resize(nv, [0.0; 2]);
    }

    /// `force = J_Nᵀλ_N + J_Tᵀλ_T + J_Bᵀλ_B + J_Fᵀλ_F`.
    #[inline]
    pub(crate) fn add_forces(
        &mut self,
        problem: &ContactProblem,
        of_contact: impl Fn(usize) -> [f64; 3],
        bilateral: &[f64],
        of_group: impl Fn(usize) -> [f64; 2],
    ) {
        for i in 0..problem.contact_count() {
            problem.jacobian.add_transposed(i, of_contact(i), &mut self.force);
        }
        for (k, p) in bilateral.iter().enumerate() {
            problem.bilateral_jacobian.add_transposed(k, [*p], &mut self.force);
        }
        for j in 0..problem.friction_groups.len() {
            problem.friction_groups.jacobian.add_transposed(j, of_group(j), &mut self.force);
        }
    }

    /// The sums of the magnitudes of what [`add_forces`](Self::add_forces) adds up, in `column`.
    pub(crate) fn add_terms(
        &mut self,
        problem: &ContactProblem,
        of_contact: impl Fn(usize) -> [f64; 3],
        bilateral: &[f64],
        of_group: impl Fn(usize) -> [f64; 2],
    ) {
        self.column.clear();
        self.column.resize(problem.nv(), 0.0);
        for i in 0..problem.contact_count() {
            problem.jacobian.add_terms_transposed(i, of_contact(i), &mut self.column);
        }
        for (k, p) in bilateral.iter().enumerate() {
            problem.bilateral_jacobian.add_terms_transposed(k, [*p], &mut self.column);
        }
        for j in 0..problem.friction_groups.len() {
            problem.friction_groups.jacobian.add_terms_transposed(j, of_group(j), &mut self.column);
        }
    }

    /// `M(v⁺ − v^f) − force` in `momentum`, and the largest part of `s_p` that it is, with the impulses' terms left out of `s_p`. Then the
    /// force is overwritten, and the velocity that it gives, `v^f + M⁻¹ force`, stands beside the claimed one.
    pub(crate) fn balance(&mut self, problem: &ContactProblem, velocity: &[f64], velocity_scale: f64) -> f64 {
        for ((d, v), f) in self.change.iter_mut().zip(velocity).zip(&problem.free_velocity) {
            *d = v - f;
        }
        problem.mass.multiply_into(&self.change, &mut self.momentum);
        self.momentum.iter_mut().zip(&self.force).for_each(|(p, f)| *p -= f);
        problem.mass_factor.solve_in_place(&mut self.force);
        let changes = self.force.iter().zip(&problem.free_velocity);
        for ((both, claimed), (change, free)) in self.both.iter_mut().zip(velocity).zip(changes) {
            *both = [change + free, *claimed];
        }
        self.relative_balance(problem, velocity_scale, |_| 0.0)
    }

    /// The same residual with the impulses' terms, which stand in `column`, in `s_p`.
    pub(crate) fn balance_beside_terms(&self, problem: &ContactProblem, velocity_scale: f64) -> f64 {
        self.relative_balance(problem, velocity_scale, |range| largest(&self.column[range]))
    }

    /// The residuals in `momentum`, tree by tree, in parts of `s_p`.
    fn relative_balance(
        &self,
        problem: &ContactProblem,
        velocity_scale: f64,
        terms: impl Fn(Range<usize>) -> f64,
    ) -> f64 {
        let mut worst = 0.0;
        for (index, block) in problem.mass.blocks().iter().enumerate() {
            let range = block.range();
            let residual = largest(&self.momentum[range.clone()]);
            if residual == 0.0 {
                continue;
            }
            let velocity = larger(DIGITS * largest(&problem.free_velocity[range.clone()]), velocity_scale);
            let scale = larger(DIGITS * terms(range), problem.mass.largest_in_block(index) * velocity);
            keep(&mut worst, residual / scale);
        }
        worst
    }
}

/// Whether a momentum residual that leaves the impulses' terms out of its scale is not negligible as it is.
pub(crate) fn needs_terms(momentum: f64) -> bool {
    momentum > NEGLIGIBLE
}

/// The largest magnitude; NaN where there is one.
fn largest(x: &[f64]) -> f64 {
    let mut largest = 0.0;
    x.iter().for_each(|x| keep(&mut largest, x.abs()));
    largest
}
