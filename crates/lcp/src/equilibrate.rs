use crate::linalg::{
    add_product, add_product_doubled, add_scaled_wide, larger, largest_entries, largest_product, power_of_two,
    scale_transposed,
};
use crate::{LcpError, Matrix, Scaling};

/// Rounds of max-norm equilibration after the scaling by the diagonal.
const ROUNDS: usize = 3;
/// Matrices of at least this size are looked at for zeros …
const SPARSE_SIZE: usize = 64;
/// … which pay when at most one entry in this many is nonzero.
const SPARSE_RATIO: usize = 4;

/// A problem with rows, columns and right-hand side brought to size 1 by powers of two, hence without rounding:
/// `A' = R A C`, `b' = R b / β`, `z = β C z'`.
///
/// Positive scaling keeps complementarity; it changes only which path Lemke's method follows.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scaled {
    pub(crate) n: usize,
    /// Columns of `A'`, one after another.
    columns: Vec<f64>,
    pattern: Pattern,
    pub(crate) b: Vec<f64>,
    row_scale: Vec<f64>,
    col_scale: Vec<f64>,
    b_scale: f64,
    /// Largest entries of rows and columns, in the rounds of equilibration.
    row_size: Vec<f64>,
    col_size: Vec<f64>,
}

/// Weights for a problem whose rows and variables have unknown and very different units: those that bring rows
/// and columns of `A` to size 1, times the factor that keeps the size of `b`.
///
/// With them the residual of a point is the same in whatever units the problem is stated, up to a factor near 1.
///
/// # Errors
/// [`LcpError::NotSquare`], [`LcpError::Length`] when `b` does not have one entry per row, and
/// [`LcpError::Weight`] where the entries are too extreme for weights in `f64`.
pub fn equilibrated(A: &Matrix, b: &[f64]) -> Result<Scaling, LcpError> {
    if A.rows() != A.cols() {
        return Err(LcpError::NotSquare { rows: A.rows(), cols: A.cols() });
    }
    if A.rows() != b.len() {
        return Err(LcpError::Length { what: "b", expected: A.rows(), found: b.len() });
    }
    let mut scaled = Scaled::default();
    scaled.load(A, b, &Scaling::from_diagonal(A));
    let largest = |x: &mut dyn Iterator<Item = f64>| x.fold(0.0f64, |max, x| max.max(x.abs()));
    let weighted = largest(&mut (0..b.len()).map(|i| scaled.unscaled_y(i, b[i])));
    let factor = if weighted > 0.0 { largest(&mut b.iter().copied()) / weighted } else { 1.0 };
    let z = (0..b.len()).map(|j| factor / scaled.column_scale(j)).collect();
    let w = (0..b.len()).map(|i| scaled.unscaled_y(i, factor)).collect();
    Scaling::new(z, w)
}

impl Scaled {
    pub(crate) fn load(&mut self, A: &Matrix, b: &[f64], scaling: &Scaling) {
        self.n = b.len();
        self.choose_scales(A, scaling);
        let n = self.n;
        self.columns.clear();
        self.columns.resize(n * n, 0.0);
        scale_transposed(A.data(), &self.row_scale, &self.col_scale, &mut self.columns);
        self.pattern.load(n, &self.columns);
        self.b.clear();
        self.b.extend(b.iter().zip(&self.row_scale).map(|(b, r)| r * b));
        self.b_scale = power_of_two(self.b.iter().fold(0.0, |max, b| max.max(b.abs())));
        let b_scale = self.b_scale;
        self.b.iter_mut().for_each(|b| *b /= b_scale);
    }

    /// Column `j` of `A'`.
    pub(crate) fn column(&self, j: usize) -> &[f64] {
        &self.columns[j * self.n..(j + 1) * self.n]
    }

    /// `out += factor ·` column `j` of `A'`.
    pub(crate) fn add_column(&self, j: usize, factor: f64, out: &mut [f64]) {
        let column = self.column(j);
        match self.pattern.rows(j) {
            Some(rows) => rows.iter().for_each(|&i| out[i as usize] += factor * column[i as usize]),
            None => add_scaled_wide(out, factor, column),
        }
    }

    /// `high + low += factor ·` column `j` of `A'` in doubled precision.
    pub(crate) fn add_column_doubled(&self, j: usize, factor: f64, high: &mut [f64], low: &mut [f64]) {
        let column = self.column(j);
        match self.pattern.rows(j) {
            Some(rows) => rows.iter().for_each(|&i| {
                let i = i as usize;
                add_product(&mut high[i], &mut low[i], column[i], factor);
            }),
            None => add_product_doubled(high, low, column, factor),
        }
    }

    /// Calls `visit(i, A'_ij)` for the entries of column `j`, but for zeros where the pattern knows them.
    pub(crate) fn for_each_in_column(&self, j: usize, mut visit: impl FnMut(usize, f64)) {
        let column = self.column(j);
        match self.pattern.rows(j) {
            Some(rows) => rows.iter().for_each(|&i| visit(i as usize, column[i as usize])),
            None => column.iter().enumerate().for_each(|(i, &a)| visit(i, a)),
        }
    }

    /// Place of pair `i` in an order that keeps coupled pairs together.
    pub(crate) fn rank(&self, i: usize) -> usize {
        self.pattern.rank.get(i).map_or(i, |&rank| rank as usize)
    }

    /// Adds `epsilon` to the diagonal of `A'`.
    pub(crate) fn add_diagonal(&mut self, epsilon: f64) {
        for j in 0..self.n {
            self.columns[j * self.n + j] += epsilon;
        }
        self.pattern.load(self.n, &self.columns);
    }

    /// `z_j` in the units of the problem.
    pub(crate) fn unscaled_z(&self, j: usize, z: f64) -> f64 {
        z * self.b_scale * self.col_scale[j]
    }

    /// The factor `C_j` by which column `j` of `A` was multiplied.
    pub(crate) fn column_scale(&self, j: usize) -> f64 {
        self.col_scale[j]
    }

    /// The factor `R_i` by which row `i` of `A` was multiplied.
    pub(crate) fn row_scale(&self, i: usize) -> f64 {
        self.row_scale[i]
    }

    /// The multiplier of row `i` in the units of the problem, up to a common factor.
    pub(crate) fn unscaled_y(&self, i: usize, y: f64) -> f64 {
        y * self.row_scale[i]
    }

    /// `w_i` in the units of the problem.
    pub(crate) fn unscaled_w(&self, i: usize, w: f64) -> f64 {
        w * self.b_scale / self.row_scale[i]
    }

    /// Unit diagonal where there is one, as for `D W D` of a Delassus matrix, then unit rows and columns.
    fn choose_scales(&mut self, A: &Matrix, scaling: &Scaling) {
        let n = self.n;
        let (s, t) = (scaling.z(), scaling.w());
        let in_one_unit = |i: usize, j: usize| (t[i] / s[j] * A[(i, j)]).abs();
        let mut largest = 0.0f64;
        self.col_size.clear();
        self.col_size.extend(s.iter().map(|s| 1.0 / s));
        for (i, t) in t.iter().enumerate() {
            largest = larger(largest, t * largest_product(A.row(i), &self.col_size));
        }
        self.row_scale.clear();
        self.col_scale.clear();
        for i in 0..n {
            let diagonal = in_one_unit(i, i);
            let root = if diagonal > 1e-12 * largest { diagonal.sqrt() } else { 0.0 };
            self.row_scale.push(root);
            self.col_scale.push(root);
        }
        self.scale_rows_without_diagonal(n, in_one_unit);
        for i in 0..n {
            self.row_scale[i] *= t[i];
            self.col_scale[i] /= s[i];
        }
        for _ in 0..ROUNDS {
            self.equilibrate(A);
        }
        for scale in self.row_scale.iter_mut().chain(&mut self.col_scale) {
            *scale = power_of_two(*scale);
        }
    }

    /// Turns the roots of the diagonal into scales and gives the other rows and columns the size of what they meet.
    fn scale_rows_without_diagonal(&mut self, n: usize, entry: impl Fn(usize, usize) -> f64) {
        let invert = |x: f64| if x > 0.0 { 1.0 / x } else { 0.0 };
        for i in 0..n {
            self.row_scale[i] = invert(self.row_scale[i]);
            self.col_scale[i] = invert(self.col_scale[i]);
        }
        for i in 0..n {
            if self.row_scale[i] != 0.0 {
                continue;
            }
            let row = (0..n).fold(0.0, |max, j| larger(max, entry(i, j) * self.col_scale[j]));
            let col = (0..n).fold(0.0, |max, j| larger(max, entry(j, i) * self.row_scale[j]));
            // Written negative first: later rows must not see the scales of earlier ones.
            self.row_scale[i] = -invert(row);
            self.col_scale[i] = -invert(col);
        }
        for scale in self.row_scale.iter_mut().chain(&mut self.col_scale) {
            *scale = if *scale == 0.0 { 1.0 } else { scale.abs() };
        }
    }

    /// One round of Ruiz's equilibration (2001).
    fn equilibrate(&mut self, A: &Matrix) {
        let n = self.n;
        for sizes in [&mut self.row_size, &mut self.col_size] {
            sizes.clear();
            sizes.resize(n, 0.0);
        }
        largest_entries(A.data(), &self.row_scale, &self.col_scale, &mut self.row_size, &mut self.col_size);
        let apply = |scales: &mut [f64], sizes: &[f64]| {
            for (scale, size) in scales.iter_mut().zip(sizes) {
                if *size > 0.0 {
                    *scale /= size.sqrt();
                }
            }
        };
        apply(&mut self.row_scale, &self.row_size);
        apply(&mut self.col_scale, &self.col_size);
    }
}

/// Where the nonzeros of a sparse matrix are; empty for a dense one.
#[derive(Clone, Debug, Default)]
struct Pattern {
    starts: Vec<usize>,
    rows: Vec<u32>,
    rank: Vec<u32>,
}

impl Pattern {
    fn load(&mut self, n: usize, columns: &[f64]) {
        self.starts.clear();
        self.rows.clear();
        self.rank.clear();
        let nonzeros = || columns.iter().filter(|a| **a != 0.0).count();
        if n < SPARSE_SIZE || nonzeros() * SPARSE_RATIO > n * n {
            return;
        }
        self.starts.push(0);
        for column in columns.chunks_exact(n) {
            self.rows.extend((0..n).filter(|&i| column[i] != 0.0).map(|i| i as u32));
            self.starts.push(self.rows.len());
        }
        self.order(n);
    }

    fn rows(&self, j: usize) -> Option<&[u32]> {
        let end = *self.starts.get(j + 1)?;
        Some(&self.rows[self.starts[j]..end])
    }

    /// Breadth first from a pair with few neighbours, neighbours in the order of their degree.
    ///
    /// Source: Cuthill, McKee (1969).
    fn order(&mut self, n: usize) {
        let degree = |j: usize| self.starts[j + 1] - self.starts[j];
        let mut by_degree: Vec<usize> = (0..n).collect();
        by_degree.sort_by_key(|&j| degree(j));
        let mut rank = vec![u32::MAX; n];
        let mut queue: Vec<usize> = Vec::with_capacity(n);
        let mut next = 0;
        for start in by_degree {
            if rank[start] != u32::MAX {
                continue;
            }
            rank[start] = queue.len() as u32;
            queue.push(start);
            while next < queue.len() {
                let first = queue.len();
                for &i in &self.rows[self.starts[queue[next]]..self.starts[queue[next] + 1]] {
                    if rank[i as usize] == u32::MAX {
                        rank[i as usize] = 0;
                        queue.push(i as usize);
                    }
                }
                queue[first..].sort_by_key(|&j| degree(j));
                for (place, &j) in queue.iter().enumerate().skip(first) {
                    rank[j] = place as u32;
                }
                next += 1;
            }
        }
        self.rank = rank;
    }
}
