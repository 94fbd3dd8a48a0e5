//! A proof that gaps and bilateral rows contradict each other.

use crate::ContactProblem;

/// Multipliers of a problem's gap rows and bilateral rows that prove that no velocity satisfies them all (Farkas' lemma).
///
/// With `y ≥ 0` for the gap rows `J_N v + φ/Δt ≥ 0` and `z` of any sign for the bilateral rows `J_B v + Θ/Δt = 0`,
///
/// ```text
/// J_Nᵀ y + J_Bᵀ z = 0   and   s = −(yᵀ φ + zᵀ Θ)/Δt > 0
/// ```
///
/// leave no `v`: the rows of any velocity, times the multipliers, would add up to `−s < 0`, and to something that is not negative.
/// Friction has no part in it: whatever the friction impulses are, the rows ask for a velocity that there is not.
#[derive(Clone, Debug, PartialEq)]
pub struct GapContradiction {
    /// `y`, `[nc]`, ≥ 0, without unit.
    pub normal: Vec<f64>,
    /// `z`, `[nb]`, without unit.
    pub bilateral: Vec<f64>,
}

impl GapContradiction {
    /// How far the multipliers are from a proof, from the data alone; 0 for a proof without rounding, infinite for none at all.
    ///
    /// Rounding leaves a remainder `r` of `J_Nᵀ y + J_Bᵀ z`, which excludes velocities up to a certain speed alone: no `v` satisfies the
    /// rows whose terms `|J_ik v_k|` all are below `s / Σ_k ε_k Y_k`, with `ε_k` the part of the terms of `r_k` that did not cancel
    /// and `Y_k` the sum of the multipliers of the rows that have column k. The residual is the problem's
    /// [velocity scale](ContactProblem::velocity_scale) over that speed.
    pub fn residual(&self, problem: &ContactProblem) -> f64 {
        let fits =
            self.normal.len() == problem.contact_count() && self.bilateral.len() == problem.bilateral_violation.len();
        if !fits
            || self.normal.iter().any(|y| *y < 0.0 || !y.is_finite())
            || !self.bilateral.iter().all(|z| z.is_finite())
        {
            return f64::INFINITY;
        }
        let distances = dot(&self.normal, &problem.gap) + dot(&self.bilateral, &problem.bilateral_violation);
        let shortfall = -distances / problem.timestep;
        if shortfall <= 0.0 || !shortfall.is_finite() {
            return f64::INFINITY;
        }
        let mut columns = vec![Column::default(); problem.nv()];
        for (i, y) in self.normal.iter().enumerate().filter(|(_, y)| **y != 0.0) {
            let (indices, entries) = problem.jacobian.group(i);
            indices.iter().zip(entries).for_each(|(&k, e)| columns[k as usize].add(*y, e[0]));
        }
        for (k, z) in self.bilateral.iter().enumerate().filter(|(_, z)| **z != 0.0) {
            let (indices, entries) = problem.bilateral_jacobian.group(k);
            indices.iter().zip(entries).for_each(|(&k, e)| columns[k as usize].add(*z, e[0]));
        }
        problem.velocity_scale() * columns.iter().map(Column::left).sum::<f64>() / shortfall
    }

    /// Contacts whose rows take part, ascending.
    pub fn contacts(&self) -> Vec<usize> {
        (0..self.normal.len()).filter(|&i| self.normal[i] > 0.0).collect()
    }
}

/// What the rows' multiples add up to in a column.
#[derive(Clone, Copy, Debug, Default)]
struct Column {
    sum: f64,
    terms: f64,
    multipliers: f64,
}

impl Column {
    fn add(&mut self, multiplier: f64, entry: f64) {
        if entry != 0.0 {
            self.sum += multiplier * entry;
            self.terms += (multiplier * entry).abs();
            self.multipliers += multiplier.abs();
        }
    }

    /// The part of the terms that did not cancel, times the multipliers.
    fn left(&self) -> f64 {
        if self.terms > 0.0 { self.sum.abs() / self.terms * self.multipliers } else { 0.0 }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
