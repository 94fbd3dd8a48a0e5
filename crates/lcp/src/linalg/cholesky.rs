use super::vectors::{LANES, widest};
use super::{add_scaled, dot};

/// Rows up to this length are two of the widest vectors, and done before these have begun.
pub const SHORT: usize = 2 * LANES;

/// Factorisation of a symmetric positive definite matrix, `K = L Lᵀ`, row-major, in place.
#[derive(Clone, Debug, Default)]
pub struct Cholesky {
    n: usize,
    /// Rows of a length that whole lanes fill; zero beyond the diagonal.
    data: Vec<f64>,
    stride: usize,
    /// The row that is at work, before elimination.
    row: Vec<f64>,
    inverse_diagonal: Vec<f64>,
}

impl Cholesky {
    /// Allocates what matrices of up to `n`×`n` need.
    pub fn reserve(&mut self, n: usize) {
        self.data.reserve((n * whole_lanes(n)).saturating_sub(self.data.len()));
        for list in [&mut self.row, &mut self.inverse_diagonal] {
            list.reserve(n.saturating_sub(list.len()));
        }
    }

    /// Makes room for an `n`×`n` matrix and returns it, zeroed, to be filled up to the diagonal: what stands beyond is not read. The second
    /// number is where the next row begins.
    pub fn start(&mut self, n: usize) -> (&mut [f64], usize) {
        (self.n, self.stride) = (n, whole_lanes(n));
        self.data.clear();
        self.data.resize(n * self.stride, 0.0);
        (&mut self.data, self.stride)
    }

    /// Factorises what [`Cholesky::start`] returned; whether it is positive definite. Otherwise no solve may follow.
    pub fn factorize(&mut self) -> bool {
        // Short rows are done before wide vectors have begun.
        if self.n <= SHORT { self.factorize_inlined() } else { factorize_widely(self) }
    }

    #[inline(always)]
    fn factorize_inlined(&mut self) -> bool {
        let Self { n, data, stride, row, inverse_diagonal } = self;
        inverse_diagonal.clear();
        for i in 0..*n {
            let (above, own) = data.split_at_mut(i * *stride);
            let own = &mut own[..*stride];
            row.clear();
            row.extend_from_slice(&own[..=i]);
            own.fill(0.0);
            for (j, other) in above.chunks_exact(*stride).enumerate() {
                // Beyond column j one of the two rows is zero.
                let known = whole_lanes(j);
                own[j] = (row[j] - dot(&own[..known], &other[..known])) * inverse_diagonal[j];
            }
            let known = whole_lanes(i);
            let pivot = row[i] - dot(&own[..known], &own[..known]);
            // Not a number is not positive either.
            if !(pivot > 0.0 && pivot.is_finite()) {
                return false;
            }
            own[i] = pivot.sqrt();
            inverse_diagonal.push(1.0 / own[i]);
        }
        true
    }

    /// Solves `K x = rhs` in place.
    ///
    /// # Panics
    /// If `x` is shorter than the matrix.
    pub fn solve(&self, x: &mut [f64]) {
        if self.n <= SHORT { self.solve_inlined(x) } else { solve_widely(self, x) }
    }

    #[inline(always)]
    fn solve_inlined(&self, x: &mut [f64]) {
        for i in 0..self.n {
            let row = &self.data[i * self.stride..][..i];
            let sum: f64 = dot(row, &x[..i]);
            x[i] = (x[i] - sum) * self.inverse_diagonal[i];
        }
        for i in (0..self.n).rev() {
            let (before, own) = x.split_at_mut(i);
            own[0] *= self.inverse_diagonal[i];
            add_scaled(before, -own[0], &self.data[i * self.stride..][..i]);
        }
    }
}

/// The least number of whole lanes that holds so many numbers: rows of that length have no rest.
pub fn whole_lanes(n: usize) -> usize {
    n.next_multiple_of(LANES)
}

widest! {
    fn factorize_widely(cholesky: &'a mut Cholesky) -> bool {
        cholesky.factorize_inlined()
    }
}

widest! {
    fn solve_widely(cholesky: &'a Cholesky, x: &'a mut [f64]) -> () {
        cholesky.solve_inlined(x);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `BᵀB + 1` of a matrix without pattern.
    fn entry(n: usize, i: usize, j: usize) -> f64 {
        let b = |i: usize, j: usize| (((i * n + j + 1) as f64).sin() * 43758.5453).fract();
        (0..n).map(|k| b(k, i) * b(k, j)).sum::<f64>() + f64::from(i == j)
    }

    #[test]
    fn solves_with_rows_of_any_length() {
        for n in [1, 2, 7, 8, 9, 31, 40] {
            let mut factor = Cholesky::default();
            let (data, stride) = factor.start(n);
            for (i, row) in data.chunks_exact_mut(stride).enumerate() {
                (0..=i).for_each(|j| row[j] = entry(n, i, j));
                row[i + 1..].fill(f64::NAN);
            }
            let wanted: Vec<f64> = (0..n).map(|i| i as f64 - 3.0).collect();
            let mut x: Vec<f64> = (0..n).map(|i| (0..n).map(|j| entry(n, i, j) * wanted[j]).sum()).collect();
            assert!(factor.factorize());
            factor.solve(&mut x);
            for i in 0..n {
                assert!((x[i] - wanted[i]).abs() < 1e-10, "n {n}: x[{i}] = {}", x[i]);
            }
        }
    }

    #[test]
    fn what_is_not_positive_definite_is_reported() {
        for matrix in [[1.0, 2.0, 1.0], [0.0, 0.0, 1.0], [f64::NAN, 0.0, 1.0]] {
            let mut factor = Cholesky::default();
            let (data, stride) = factor.start(2);
            (data[0], data[stride], data[stride + 1]) = (matrix[0], matrix[1], matrix[2]);
            assert!(!factor.factorize(), "{matrix:?}");
        }
    }
}
