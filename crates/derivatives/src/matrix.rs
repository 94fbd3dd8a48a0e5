//! Rows of dense numbers.

use pulp::{Arch, Simd, WithSimd};

/// A dense matrix, row by row, whose number of rows grows.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rows {
    pub width: usize,
    pub data: Vec<f64>,
}

impl Rows {
    pub fn clear(&mut self, width: usize) {
        self.width = width;
        self.data.clear();
    }

    pub fn len(&self) -> usize {
        self.data.len().checked_div(self.width).unwrap_or(0)
    }

    /// Adds a row of zeros.
    pub fn push(&mut self) -> &mut [f64] {
        let start = self.data.len();
        self.data.resize(start + self.width, 0.0);
        &mut self.data[start..]
    }

    /// Holds `rows` rows of zeros.
    pub fn reset(&mut self, rows: usize, width: usize) {
        self.clear(width);
        self.data.resize(rows * width, 0.0);
    }

    /// Holds so many rows of whatever is there, to be written.
    pub fn shape(&mut self, rows: usize, width: usize) {
        self.width = width;
        self.data.resize(rows * width, 0.0);
    }

    /// Adds multiples of the rows of another matrix to one of this.
    #[inline(always)]
    pub fn add_rows(&mut self, i: usize, others: impl Iterator<Item = (f64, usize)>, of: &Self) {
        let row = &mut self.data[i * self.width..(i + 1) * self.width];
        for (s, j) in others {
            let other = &of.data[j * self.width..(j + 1) * self.width];
            row.iter_mut().zip(other).for_each(|(y, x)| *y += s * x);
        }
    }

    /// Two different rows, the first to be changed.
    #[inline(always)]
    pub fn pair(&mut self, i: usize, j: usize) -> (&mut [f64], &[f64]) {
        let w = self.width;
        if i < j {
            let (head, tail) = self.data.split_at_mut(j * w);
            (&mut head[i * w..(i + 1) * w], &tail[..w])
        } else {
            let (head, tail) = self.data.split_at_mut(i * w);
            (&mut tail[..w], &head[j * w..(j + 1) * w])
        }
    }

    pub fn row(&self, i: usize) -> &[f64] {
        &self.data[i * self.width..(i + 1) * self.width]
    }

    pub fn row_mut(&mut self, i: usize) -> &mut [f64] {
        &mut self.data[i * self.width..(i + 1) * self.width]
    }
}

#[inline(always)]
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len());
    let ((fours, rest), (other_fours, other_rest)) = (a[..n].as_chunks::<4>(), b[..n].as_chunks::<4>());
    let mut sums = [0.0; 4];
    for (a, b) in fours.iter().zip(other_fours) {
        (0..4).for_each(|l| sums[l] += a[l] * b[l]);
    }
    let rest: f64 = rest.iter().zip(other_rest).map(|(a, b)| a * b).sum();
    sums[0] + sums[1] + (sums[2] + sums[3]) + rest
}

/// `y += s x`.
#[inline(always)]
pub(crate) fn add_scaled(y: &mut [f64], s: f64, x: &[f64]) {
    if s != 0.0 {
        y.iter_mut().zip(x).for_each(|(y, x)| *y += s * x);
    }
}

pub(crate) fn largest(x: &[f64]) -> f64 {
    let (eights, rest) = x.as_chunks::<8>();
    let larger = |a: f64, x: &f64| if x.abs() > a { x.abs() } else { a };
    let mut found = [0.0; 8];
    for eight in eights {
        (0..8).for_each(|l| found[l] = larger(found[l], &eight[l]));
    }
    found.iter().chain(rest).fold(0.0, larger)
}

/// `L` of `A = L Lᵀ` in the lower half of a dense matrix, in place; `false` where it is not positive definite.
#[inline(always)]
pub(crate) fn cholesky(a: &mut [f64], n: usize) -> bool {
    for i in 0..n {
        let (above, row) = a.split_at_mut(i * n);
        for j in 0..i {
            let other = &above[j * n..j * n + j + 1];
            row[j] = (row[j] - dot(&row[..j], &other[..j])) / other[j];
        }
        let pivot = row[i] - dot(&row[..i], &row[..i]);
        if pivot.is_nan() || pivot <= 0.0 {
            return false;
        }
        row[i] = pivot.sqrt();
    }
    true
}

/// Solves with the factor of [`cholesky`].
#[inline(always)]
pub(crate) fn cholesky_solve(factor: &[f64], n: usize, x: &mut [f64]) {
    for i in 0..n {
        x[i] = (x[i] - dot(&factor[i * n..i * n + i], &x[..i])) / factor[i * n + i];
    }
    for i in (0..n).rev() {
        let value = x[i] / factor[i * n + i];
        let (head, tail) = x.split_at_mut(i);
        tail[0] = value;
        add_scaled(head, -value, &factor[i * n..i * n + i]);
    }
}

/// Work on rows. What it calls has to be inlined, or is compiled for the narrowest vectors.
pub(crate) trait Work {
    type Output;
    fn run(self) -> Self::Output;
}

struct Wide<W>(W);

impl<W: Work> WithSimd for Wide<W> {
    type Output = W::Output;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> W::Output {
        self.0.run()
    }
}

/// Does work on rows with the widest vectors that the machine has.
pub(crate) fn wide<W: Work>(work: W) -> W::Output {
    Arch::new().dispatch(Wide(work))
}
