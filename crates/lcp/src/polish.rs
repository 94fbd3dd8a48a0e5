//! The last step of every pivoting method: the linear system of a complementary basis, solved afresh.

use crate::linalg::{DoubleSum, Lu, power_of_two};
use crate::{Matrix, Scaling};

/// Refinement steps at most; two suffice unless the system is nearly singular.
const REFINEMENTS: usize = 6;

/// Memory for [`solve_active`], kept between calls.
#[derive(Clone, Debug, Default)]
pub(crate) struct Polish {
    lu: Lu,
    row_scale: Vec<f64>,
    x: Vec<f64>,
    correction: Vec<f64>,
}

impl Polish {
    /// Solves `A_SS z_S = −b_S`, `z = 0` elsewhere, with iterative refinement in doubled precision.
    ///
    /// - `active`: the indices S
    /// - `z`: out, `[n]`
    ///
    /// Returns false, with `z` undefined, when `A_SS` is exactly singular.
    ///
    /// Source: Higham, *Accuracy and Stability of Numerical Algorithms* (2002), ch. 12.
    pub(crate) fn solve_active(&mut self, A: &Matrix, b: &[f64], scaling: &Scaling, active: &[usize], z: &mut [f64]) -> bool {
        let k = active.len();
        z.fill(0.0);
        if k == 0 {
            return true;
        }
        // Powers of two: the scaled system has exactly the solution of the original one.
        let col_scale = |j: usize| 1.0 / power_of_two(scaling.z()[j]);
        self.row_scale.clear();
        let data = self.lu.start(k);
        for (row, &i) in data.chunks_exact_mut(k).zip(active) {
            let A_row = A.row(i);
            let mut largest = 0.0f64;
            for (x, &j) in row.iter_mut().zip(active) {
                *x = A_row[j] * col_scale(j);
                largest = largest.max(x.abs());
            }
            let scale = 1.0 / power_of_two(largest);
            row.iter_mut().for_each(|x| *x *= scale);
            self.row_scale.push(scale);
        }
        if self.lu.factorize() == 0.0 {
            return false;
        }
        self.refine(A, b, active, col_scale);
        for (x, &j) in self.x.iter().zip(active) {
            z[j] = *x;
        }
        self.x.iter().all(|x| x.is_finite())
    }

    fn refine(&mut self, A: &Matrix, b: &[f64], active: &[usize], col_scale: impl Fn(usize) -> f64) {
        let k = active.len();
        self.x.clear();
        self.x.resize(k, 0.0);
        let mut last_step = f64::INFINITY;
        for _ in 0..REFINEMENTS {
            self.correction.clear();
            for (&i, scale) in active.iter().zip(&self.row_scale) {
                let A_row = A.row(i);
                let mut sum = DoubleSum::new(-b[i]);
                for (x, &j) in self.x.iter().zip(active) {
                    if *x != 0.0 {
                        sum.add_product(-A_row[j], *x);
                    }
                }
                self.correction.push(sum.value() * scale);
            }
            self.lu.solve(&mut self.correction);
            let step = self.correction.iter().fold(0.0f64, |max, x| max.max(x.abs()));
            if !(step < 0.5 * last_step) {
                break;
            }
            let mut size = 0.0f64;
            for ((x, dx), &j) in self.x.iter_mut().zip(&self.correction).zip(active) {
                *x += dx * col_scale(j);
                size = size.max((*x / col_scale(j)).abs());
            }
            last_step = step;
            if step <= f64::EPSILON * size {
                break;
            }
        }
    }
}
