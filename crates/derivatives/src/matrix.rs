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
