//! Plain dense matrices.

use std::ops::{Index, IndexMut};

/// A dense matrix, row-major, with textbook algorithms.
#[derive(Clone, Debug, PartialEq)]
pub struct Dense {
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub columns: usize,
    /// Entries, row after row.
    pub data: Vec<f64>,
}

impl Dense {
    /// Zeros.
    pub fn zeros(rows: usize, columns: usize) -> Self {
        Self { rows, columns, data: vec![0.0; rows * columns] }
    }

    /// The matrix with entry `(i, j)` equal to `entry(i, j)`.
    pub fn from_fn(rows: usize, columns: usize, entry: impl Fn(usize, usize) -> f64) -> Self {
        let mut out = Self::zeros(rows, columns);
        for i in 0..rows {
            for j in 0..columns {
                out[(i, j)] = entry(i, j);
            }
        }
        out
    }

    /// The transposed matrix.
    pub fn transposed(&self) -> Self {
        Self::from_fn(self.columns, self.rows, |i, j| self[(j, i)])
    }

    /// The product with another matrix.
    pub fn times(&self, other: &Self) -> Self {
        Self::from_fn(self.rows, other.columns, |i, j| (0..self.columns).map(|k| self[(i, k)] * other[(k, j)]).sum())
    }

    /// The product with a vector.
    pub fn apply(&self, x: &[f64]) -> Vec<f64> {
        (0..self.rows).map(|i| (0..self.columns).map(|j| self[(i, j)] * x[j]).sum()).collect()
    }

    /// The inverse, by Gauss–Jordan elimination with full pivoting.
    ///
    /// # Panics
    /// If the matrix is singular.
    pub fn inverse(&self) -> Self {
        let n = self.rows;
        let mut a = self.clone();
        let mut pivoted = vec![false; n];
        let mut swaps = Vec::new();
        for _ in 0..n {
            let mut pivot = (0.0, 0, 0);
            for i in (0..n).filter(|&i| !pivoted[i]) {
                for j in (0..n).filter(|&j| !pivoted[j]) {
                    if a[(i, j)].abs() > pivot.0 {
                        pivot = (a[(i, j)].abs(), i, j);
                    }
                }
            }
            let (size, row, column) = pivot;
            assert!(size > 0.0, "singular matrix");
            a.swap_rows(row, column);
            swaps.push((row, column));
            pivoted[column] = true;
            a.eliminate(column);
        }
        for (row, column) in swaps.into_iter().rev() {
            for i in 0..n {
                a.data.swap(i * n + row, i * n + column);
            }
        }
        a
    }

    fn swap_rows(&mut self, a: usize, b: usize) {
        for j in 0..self.columns {
            self.data.swap(a * self.columns + j, b * self.columns + j);
        }
    }

    /// One Gauss–Jordan step about the diagonal entry `k`, in place.
    fn eliminate(&mut self, k: usize) {
        let pivot = self[(k, k)];
        self[(k, k)] = 1.0;
        for j in 0..self.columns {
            self[(k, j)] /= pivot;
        }
        for i in (0..self.rows).filter(|&i| i != k) {
            let factor = self[(i, k)];
            self[(i, k)] = 0.0;
            for j in 0..self.columns {
                self[(i, j)] -= factor * self[(k, j)];
            }
        }
    }
}

impl Index<(usize, usize)> for Dense {
    type Output = f64;

    fn index(&self, (i, j): (usize, usize)) -> &f64 {
        &self.data[i * self.columns + j]
    }
}

impl IndexMut<(usize, usize)> for Dense {
    fn index_mut(&mut self, (i, j): (usize, usize)) -> &mut f64 {
        &mut self.data[i * self.columns + j]
    }
}

/// `‖x − y‖_∞`; infinite where the lengths differ or an entry is not a number.
pub fn largest_difference(x: &[f64], y: &[f64]) -> f64 {
    if x.len() != y.len() {
        return f64::INFINITY;
    }
    x.iter().zip(y).map(|(x, y)| (x - y).abs()).fold(0.0, |a, d| if d.is_nan() { f64::INFINITY } else { a.max(d) })
}
