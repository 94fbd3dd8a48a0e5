//! LU factorisation of small dense matrices.

use pulp::Simd;

use super::kernels::{factor_block, solve_block};
use super::vectors::{Vectorised, run_widest};

/// A small square matrix and, after [`factor`](Self::factor), its factors with partial pivoting.
#[derive(Clone, Debug, Default)]
pub struct DenseLu {
    /// `[n, n]`, row by row.
    pub entries: Vec<f64>,
    swaps: Vec<u32>,
}

impl DenseLu {
    /// Makes it a matrix of `n` rows whose entries are yet to be written.
    pub fn resize(&mut self, n: usize) {
        self.entries.resize(n * n, 0.0);
        self.swaps.resize(n, 0);
    }

    /// Factorises in place; whether the matrix is regular.
    pub fn factor(&mut self) -> bool {
        self.swaps.is_empty() || run_widest(Factorisation(self)) > 0.0
    }

    /// Overwrites `x` with `A⁻¹ x`.
    pub fn solve(&self, x: &mut [f64]) {
        run_widest(Solution(self, x));
    }
}

struct Factorisation<'a>(&'a mut DenseLu);

impl Vectorised for Factorisation<'_> {
    type Output = f64;

    #[inline(always)]
    fn run<S: Simd>(self, _simd: S) -> f64 {
        factor_block(&mut self.0.entries, &mut self.0.swaps)
    }
}

struct Solution<'a>(&'a DenseLu, &'a mut [f64]);

impl Vectorised for Solution<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _simd: S) {
        solve_block(&self.0.entries, &self.0.swaps, self.1);
    }
}
