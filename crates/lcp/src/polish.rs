//! The last step of every pivoting method: the linear system of a complementary basis, solved afresh.

use crate::linalg::{DoubleSum, Lu, power_of_two};
use crate::{Matrix, Scaling};

/// Refinement steps at most; two suffice unless the system is nearly singular.
const REFINEMENTS: usize = 8;
/// Below this relative pivot the system counts as singular.
const NEARLY_SINGULAR: f64 = 1e-13;
/// The proximal term for a singular system, whose rows have size 1.
const PROXIMAL: f64 = 1e-7;

/// Memory for [`solve_active`], kept between calls.
#[derive(Clone, Debug, Default)]
pub(crate) struct Polish {
    lu: Lu,
    row_scale: Vec<f64>,
    col_scale: Vec<f64>,
    x: Vec<f64>,
    correction: Vec<f64>,
    /// Smallest relative pivot of the last system, before any proximal term.
    pub(crate) smallest_pivot: f64,
}

impl Polish {
    /// Solves `A_RC z_C = −b_R`, `z = 0` elsewhere, with iterative refinement in doubled precision.
    ///
    /// - `rows`, `cols`: the index sets R and C, of equal size; equal but for mixed problems
    /// - `z`: out, `[n]`
    ///
    /// A singular system, as redundant contacts make it, is solved by the proximal iteration
    /// `x ← x + (K + εI)⁻¹(rhs − K x)` from 0, which tends to a solution near the least-norm one where the system
    /// is consistent. Whether it did is for the caller's residual to say. Returns false when no finite point came out.
    ///
    /// Source: Higham, *Accuracy and Stability of Numerical Algorithms* (2002), ch. 12.
    pub(crate) fn solve_active(
        &mut self,
        A: &Matrix,
        b: &[f64],
        scaling: &Scaling,
        rows: &[usize],
        cols: &[usize],
        z: &mut [f64],
    ) -> bool {
        z.fill(0.0);
        self.smallest_pivot = 1.0;
        if cols.is_empty() {
            return true;
        }
        // Powers of two: the scaled system has exactly the solution of the original one.
        self.col_scale.clear();
        self.col_scale.extend(cols.iter().map(|&j| 1.0 / power_of_two(scaling.z()[j])));
        self.load(A, rows, cols, 0.0);
        self.smallest_pivot = self.lu.factorize();
        if self.smallest_pivot < NEARLY_SINGULAR {
            self.load(A, rows, cols, PROXIMAL);
            if self.lu.factorize() == 0.0 {
                return false;
            }
        }
        self.refine(A, b, rows, cols);
        for ((x, scale), &j) in self.x.iter().zip(&self.col_scale).zip(cols) {
            z[j] = x * scale;
        }
        self.x.iter().all(|x| x.is_finite())
    }

    /// Fills the matrix to factorise: rows and columns scaled, `epsilon` added to the diagonal.
    fn load(&mut self, A: &Matrix, rows: &[usize], cols: &[usize], epsilon: f64) {
        let k = cols.len();
        self.row_scale.clear();
        let data = self.lu.start(k);
        for (r, (row, &i)) in data.chunks_exact_mut(k).zip(rows).enumerate() {
            let A_row = A.row(i);
            let mut largest = 0.0f64;
            for ((x, &j), scale) in row.iter_mut().zip(cols).zip(&self.col_scale) {
                *x = A_row[j] * scale;
                largest = largest.max(x.abs());
            }
            let scale = 1.0 / power_of_two(largest);
            row.iter_mut().for_each(|x| *x *= scale);
            row[r] += epsilon;
            self.row_scale.push(scale);
        }
    }

    /// Adds corrections to the scaled unknowns `x`, from 0, until they stop shrinking.
    fn refine(&mut self, A: &Matrix, b: &[f64], rows: &[usize], cols: &[usize]) {
        self.x.clear();
        self.x.resize(cols.len(), 0.0);
        let mut last_step = f64::INFINITY;
        for _ in 0..REFINEMENTS {
            self.correction.clear();
            for (&i, row_scale) in rows.iter().zip(&self.row_scale) {
                let A_row = A.row(i);
                let mut sum = DoubleSum::new(-b[i]);
                for ((x, &j), scale) in self.x.iter().zip(cols).zip(&self.col_scale) {
                    if *x != 0.0 && A_row[j] != 0.0 {
                        sum.add_product(-A_row[j], x * scale);
                    }
                }
                self.correction.push(sum.value() * row_scale);
            }
            self.lu.solve(&mut self.correction);
            let step = self.correction.iter().fold(0.0f64, |max, x| max.max(x.abs()));
            if step >= 0.5 * last_step || step.is_nan() {
                break;
            }
            let mut size = 0.0f64;
            for (x, dx) in self.x.iter_mut().zip(&self.correction) {
                *x += dx;
                size = size.max(x.abs());
            }
            last_step = step;
            if step <= f64::EPSILON * size {
                break;
            }
        }
    }
}
