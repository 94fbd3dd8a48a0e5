use super::vectors::{LANES, widest};
use super::{add_scaled, dot};

/// Rows up to this length are two of the widest vectors, and done before these have begun.
pub const SHORT: usize = 2 * LANES;

/// Factorisation of a symmetric positive definite matrix, `K = Uᵀ U`, row-major, in place.
#[derive(Clone, Debug, Default)]
pub struct Cholesky {
    n: usize,
    /// Rows of a length that whole lanes fill; zero beyond the matrix, of no meaning before the diagonal.
    data: Vec<f64>,
    stride: usize,
    inverse_diagonal: Vec<f64>,
}

impl Cholesky {
    /// Allocates what matrices of up to `n`×`n` need.
    pub fn reserve(&mut self, n: usize) {
        self.data.reserve((n * whole_lanes(n)).saturating_sub(self.data.len()));
        self.inverse_diagonal.reserve(n.saturating_sub(self.inverse_diagonal.len()));
    }

    /// Makes room for an `n`×`n` matrix and returns it, to be filled from the diagonal on: what stands before it is not read. The second
    /// number is where the next row begins.
    pub fn start(&mut self, n: usize) -> (&mut [f64], usize) {
        (self.n, self.stride) = (n, whole_lanes(n));
        self.data.resize(n * self.stride, 0.0);
        self.data.chunks_exact_mut(self.stride.max(1)).for_each(|row| row[n..].fill(0.0));
        (&mut self.data, self.stride)
    }

    /// Factorises what [`Cholesky::start`] returned; whether it is positive definite. Otherwise no solve may follow.
    pub fn factorize(&mut self) -> bool {
        // Short rows are done before wide vectors have begun.
        if self.n <= SHORT { self.factorize_inlined() } else { factorize_widely(self) }
    }

    #[inline(always)]
    fn factorize_inlined(&mut self) -> bool {
        let Self { n, data, stride, inverse_diagonal } = self;
        inverse_diagonal.clear();
        for k in 0..*n {
            let (above, own) = data.split_at_mut(k * *stride);
            let own = &mut own[..*stride];
            // Lanes, and several of them at a time, so that sums stay in registers. What is summed before the diagonal is not used.
            let mut first = k - k % LANES;
            while first < *stride {
                first += match (*stride - first) / LANES {
                    1 => eliminate::<1>(above, k, first, own),
                    2 => eliminate::<2>(above, k, first, own),
                    3 => eliminate::<3>(above, k, first, own),
                    _ => eliminate::<4>(above, k, first, own),
                };
            }
            let pivot = own[k];
            // Not a number is not positive either.
            if !(pivot > 0.0 && pivot.is_finite()) {
                return false;
            }
            own[k] = pivot.sqrt();
            let inverse = 1.0 / own[k];
            own[k + 1..].iter_mut().for_each(|x| *x *= inverse);
            inverse_diagonal.push(inverse);
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
        let x = &mut x[..self.n];
        for k in 0..self.n {
            let (before, after) = x.split_at_mut(k + 1);
            before[k] *= self.inverse_diagonal[k];
            add_scaled(after, -before[k], &self.data[k * self.stride..][k + 1..]);
        }
        for k in (0..self.n).rev() {
            let (before, after) = x.split_at_mut(k + 1);
            let sum: f64 = dot(&self.data[k * self.stride..][k + 1..self.n], after);
            before[k] = (before[k] - sum) * self.inverse_diagonal[k];
        }
    }
}

/// Takes the part of the rows above off `COUNT` lanes of row `k`, from place `first` on; how many numbers these are.
#[inline(always)]
fn eliminate<const COUNT: usize>(above: &[f64], k: usize, first: usize, own: &mut [f64]) -> usize {
    let stride = own.len();
    let own = &mut own[first..][..COUNT * LANES];
    let mut sums = [[0.0; LANES]; COUNT];
    sums.as_flattened_mut().copy_from_slice(own);
    for row in above.chunks_exact(stride) {
        let (factor, row) = (row[k], &row[first..][..COUNT * LANES]);
        for (sums, row) in sums.iter_mut().zip(row.as_chunks::<LANES>().0) {
            for lane in 0..LANES {
                sums[lane] -= factor * row[lane];
            }
        }
    }
    own.copy_from_slice(sums.as_flattened());
    COUNT * LANES
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
                (i..n).for_each(|j| row[j] = entry(n, i, j));
                row[..i].fill(f64::NAN);
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
            (data[0], data[1], data[stride + 1]) = (matrix[0], matrix[1], matrix[2]);
            assert!(!factor.factorize(), "{matrix:?}");
        }
    }
}
