//! The rows and columns of a mode's system that are independent, and their factor.

use crate::matrix::Rows;

/// A pivot below this part of the largest is the rounding of a dependent row.
const DEPENDENT: f64 = 1e-11;
/// A pivot between the two is neither: the mode is all but singular, and its derivative has lost its digits.
const INDEPENDENT: f64 = 1e-4;

/// `L U` of the largest part of a square matrix that is regular, by complete pivoting.
#[derive(Clone, Debug, Default)]
pub(crate) struct Reduced {
    size: usize,
    /// Rows and columns in the order of their pivots; the independent ones first.
    pub rows: Vec<usize>,
    pub columns: Vec<usize>,
    pub rank: usize,
    lu: Vec<f64>,
}

/// The matrix is all but singular: this is the pivot that is neither zero nor not, relative to the largest.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NearlySingular(pub f64);

impl Reduced {
    /// Factors a square matrix, with its rows and columns scaled to comparable size.
    pub fn factor(&mut self, matrix: &Rows) -> Result<(), NearlySingular> {
        let n = matrix.len();
        (self.size, self.rank) = (n, 0);
        self.lu.clear();
        self.lu.extend_from_slice(&matrix.data);
        self.rows.clear();
        self.rows.extend(0..n);
        self.columns.clear();
        self.columns.extend(0..n);
        let mut first = 0.0;
        for k in 0..n {
            let (mut best, mut at) = (0.0, (k, k));
            for i in k..n {
                for j in k..n {
                    let size = self.lu[i * n + j].abs();
                    if size > best {
                        (best, at) = (size, (i, j));
                    }
                }
            }
            if k == 0 {
                first = best;
            }
            if best <= DEPENDENT * first || best == 0.0 {
                break;
            }
            if best < INDEPENDENT * first {
                return Err(NearlySingular(best / first));
            }
            self.exchange(k, at);
            let pivot = self.lu[k * n + k];
            for i in k + 1..n {
                let factor = self.lu[i * n + k] / pivot;
                self.lu[i * n + k] = factor;
                if factor != 0.0 {
                    let (head, tail) = self.lu.split_at_mut(i * n);
                    let (above, row) = (&head[k * n + k + 1..k * n + n], &mut tail[k + 1..n]);
                    row.iter_mut().zip(above).for_each(|(x, u)| *x -= factor * u);
                }
            }
            self.rank = k + 1;
        }
        Ok(())
    }

    fn exchange(&mut self, k: usize, (i, j): (usize, usize)) {
        let n = self.size;
        if i != k {
            (0..n).for_each(|c| self.lu.swap(k * n + c, i * n + c));
            self.rows.swap(k, i);
        }
        if j != k {
            (0..n).for_each(|r| self.lu.swap(r * n + k, r * n + j));
            self.columns.swap(k, j);
        }
    }

    /// Solves for the independent columns from the independent rows; the others are zero. `x`: in by rows, out by columns.
    pub fn solve_in_place(&self, x: &mut [f64], scratch: &mut Vec<f64>) {
        let (n, r) = (self.size, self.rank);
        scratch.clear();
        scratch.extend(self.rows[..r].iter().map(|&i| x[i]));
        for i in 0..r {
            let sum: f64 = (0..i).map(|j| self.lu[i * n + j] * scratch[j]).sum();
            scratch[i] -= sum;
        }
        for i in (0..r).rev() {
            let sum: f64 = (i + 1..r).map(|j| self.lu[i * n + j] * scratch[j]).sum();
            scratch[i] = (scratch[i] - sum) / self.lu[i * n + i];
        }
        x.fill(0.0);
        self.columns[..r].iter().zip(scratch.iter()).for_each(|(&j, value)| x[j] = *value);
    }

    /// The same for the transposed matrix: `x` in by columns, out by rows.
    pub fn solve_transposed_in_place(&self, x: &mut [f64], scratch: &mut Vec<f64>) {
        let (n, r) = (self.size, self.rank);
        scratch.clear();
        scratch.extend(self.columns[..r].iter().map(|&j| x[j]));
        for i in 0..r {
            let sum: f64 = (0..i).map(|j| self.lu[j * n + i] * scratch[j]).sum();
            scratch[i] = (scratch[i] - sum) / self.lu[i * n + i];
        }
        for i in (0..r).rev() {
            let sum: f64 = (i + 1..r).map(|j| self.lu[j * n + i] * scratch[j]).sum();
            scratch[i] -= sum;
        }
        x.fill(0.0);
        self.rows[..r].iter().zip(scratch.iter()).for_each(|(&i, value)| x[i] = *value);
    }

    /// The same for many right-hand sides at once, in place: rows in the order of [`rows`](Self::rows) in, of [`columns`](Self::columns) out,
    /// `rank` of them.
    #[inline(always)]
    pub fn solve_rows_in_place(&self, x: &mut Rows) {
        let (n, r) = (self.size, self.rank);
        for i in 0..r {
            for j in 0..i {
                let (own, other) = x.pair(i, j);
                subtract(own, self.lu[i * n + j], other);
            }
        }
        self.substitute_back(x);
    }

    #[inline(always)]
    fn substitute_back(&self, x: &mut Rows) {
        let (n, r) = (self.size, self.rank);
        for i in (0..r).rev() {
            for j in i + 1..r {
                let (own, other) = x.pair(i, j);
                subtract(own, self.lu[i * n + j], other);
            }
            let inverse = 1.0 / self.lu[i * n + i];
            x.row_mut(i).iter_mut().for_each(|x| *x *= inverse);
        }
    }

    /// Vectors that the matrix takes to zero, one for each dependent column: their entries at the independent columns, `[rank, size − rank]`.
    /// Each has 1 at its own dependent column and zeros at the others.
    #[inline(always)]
    pub fn null_vectors_into(&self, out: &mut Rows) {
        let (n, r) = (self.size, self.rank);
        out.clear(n - r);
        for i in 0..r {
            let row = out.push();
            row.iter_mut().zip(&self.lu[i * n + r..(i + 1) * n]).for_each(|(x, u)| *x = -u);
        }
        self.substitute_back(out);
    }
}

/// `y −= s x`.
#[inline(always)]
fn subtract(y: &mut [f64], s: f64, x: &[f64]) {
    y.iter_mut().zip(x).for_each(|(y, x)| *y -= s * x);
}
