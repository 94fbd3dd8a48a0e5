//! Rows of dense numbers.

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

    pub fn row(&self, i: usize) -> &[f64] {
        &self.data[i * self.width..(i + 1) * self.width]
    }

    pub fn row_mut(&mut self, i: usize) -> &mut [f64] {
        &mut self.data[i * self.width..(i + 1) * self.width]
    }
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `y += s x`.
pub(crate) fn add_scaled(y: &mut [f64], s: f64, x: &[f64]) {
    if s != 0.0 {
        y.iter_mut().zip(x).for_each(|(y, x)| *y += s * x);
    }
}

pub(crate) fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |a: f64, x| a.max(x.abs()))
}

/// `L` of `A = L Lᵀ` in the lower half of a dense matrix, in place; `false` where it is not positive definite.
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
