use crate::equilibrate::Scaled;
use crate::factored_basis::FactoredBasis;
use crate::linalg::{add_scaled, dot};
use crate::{Farkas, Ray};

/// Violations of a ray's sign conditions up to this, in the equilibrated problem with the ray of size 1, are
/// rounding.
const ROUNDING: f64 = 1e-8;
/// A certificate of infeasibility must be this sharp, relative to the sum of its multipliers …
const CERTIFICATE: f64 = 1e-13;
/// … and its right-hand side must be negative by at least this much.
const MARGIN: f64 = 1e-7;

/// The direction in which a walk left to infinity, in the equilibrated problem.
#[derive(Clone, Debug)]
pub(crate) struct Direction {
    z: Vec<f64>,
    w: Vec<f64>,
    z0: f64,
}

impl Direction {
    /// The direction in which `entering` grows without bound; `None` if recomputing it from the data contradicts its
    /// signs.
    ///
    /// - `a`: `B⁻¹` times the column of `entering`, by position
    pub(crate) fn of(problem: &Scaled, basis: &FactoredBasis, a: &[f64], entering: usize) -> Option<Self> {
        let n = problem.n;
        let (mut z, mut w_pivoted, mut z0) = (vec![0.0; n], vec![0.0; n], 0.0);
        let mut set = |variable: usize, value: f64| match variable {
            v if v == 2 * n => z0 = value,
            v if v >= n => z[v - n] = value,
            v => w_pivoted[v] = value,
        };
        set(entering, 1.0);
        for (&variable, &a) in basis.head.iter().zip(a) {
            set(variable, (-a).max(0.0));
        }
        let size = z.iter().fold(z0, |max, z| max.max(*z));
        if size == 0.0 {
            return None;
        }
        z.iter_mut().for_each(|z| *z /= size);
        z0 /= size;
        let mut w = vec![0.0; n];
        add_scaled(&mut w, z0, &basis.d);
        for (j, &z) in z.iter().enumerate().filter(|(_, z)| **z != 0.0) {
            add_scaled(&mut w, z, problem.column(j));
        }
        let holds = (0..n).all(|i| w[i] >= -ROUNDING && z[i].min(w[i]) <= ROUNDING);
        w.iter_mut().zip(&w_pivoted).for_each(|(w, pivoted)| *w = if *pivoted == 0.0 { 0.0 } else { w.max(0.0) });
        holds.then_some(Self { z, w, z0 })
    }

    /// The proof of infeasibility that the direction gives, where it gives one: `y = z`, in the units of the problem or in
    /// those of the equilibrated one.
    ///
    /// For copositive-plus `A` it always does (Cottle, Pang, Stone 2009, theorem 4.4.9), in the units in which `A` is.
    pub(crate) fn certificate(&self, problem: &Scaled) -> Option<Farkas> {
        let unscaled = |(i, z): (usize, &f64)| z * problem.column_scale(i) / problem.row_scale(i);
        certificate(problem, &self.z)
            .or_else(|| certificate(problem, &self.z.iter().enumerate().map(unscaled).collect::<Vec<f64>>()))
    }

    /// The direction in the units of the problem, its largest `z` (or else `z0`) being 1 in one unit.
    pub(crate) fn unscaled(&self, problem: &Scaled, unit: &[f64]) -> Ray {
        let mut z: Vec<f64> = self.z.iter().enumerate().map(|(j, &z)| problem.unscaled_z(j, z)).collect();
        let mut w: Vec<f64> = self.w.iter().enumerate().map(|(i, &w)| problem.unscaled_w(i, w)).collect();
        let mut size = z.iter().zip(unit).fold(0.0f64, |max, (z, s)| max.max(z * s));
        if size == 0.0 {
            size = self.z0;
        }
        z.iter_mut().chain(&mut w).for_each(|x| *x /= size);
        let support = (0..z.len()).filter(|&i| z[i] > 0.0).collect();
        Ray { z, w, z0: self.z0 / size, support }
    }
}

/// The proof of infeasibility with these multipliers `y ≥ 0` of the equilibrated rows, if they are one.
pub(crate) fn certificate(problem: &Scaled, y: &[f64]) -> Option<Farkas> {
    let sum: f64 = y.iter().sum();
    // The last columns are the bounds on friction, where a jam that is no proof shows.
    let holds = sum > 0.0
        && sum.is_finite()
        && dot(&problem.b, y) <= -MARGIN * sum
        && (0..problem.n).rev().all(|j| dot(problem.column(j), y) <= CERTIFICATE * sum);
    holds.then(|| Farkas { y: (0..problem.n).map(|i| problem.unscaled_y(i, y[i])).collect() })
}
