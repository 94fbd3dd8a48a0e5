//! LU factorisation of a block-sparse matrix with a symmetric pattern, pivoting inside the diagonal blocks.

use super::Symbolic;
use super::kernels::{factor_block, solve_block, subtract_multiply, subtract_multiply_transposed, subtract_product};

/// A matrix in the panels of a [`Symbolic`] structure and, after [`factor`](Self::factor), its factors.
///
/// `A = L̃ D⁻¹ Ũ` in the order of elimination: `D` has the diagonal blocks, the panel of position `k` in `lower` the blocks
/// `L̃_ik`, that in `upper` the transposed blocks of `D_k⁻¹ Ũ_ki`.
#[derive(Clone, Debug, Default)]
pub(crate) struct BlockLu {
    pub diagonal: Vec<f64>,
    pub lower: Vec<f64>,
    pub upper: Vec<f64>,
    swaps: Vec<u32>,
    /// Panel row of each block in the panel at hand.
    place: Vec<usize>,
    scratch: Vec<f64>,
}

impl BlockLu {
    /// Makes the matrix zero.
    pub fn clear(&mut self, symbolic: &Symbolic) {
        let zero = |x: &mut Vec<f64>, n: usize| {
            x.clear();
            x.resize(n, 0.0);
        };
        zero(&mut self.diagonal, symbolic.diagonal.last().copied().unwrap_or(0));
        zero(&mut self.lower, symbolic.panel.last().copied().unwrap_or(0));
        zero(&mut self.upper, symbolic.panel.last().copied().unwrap_or(0));
    }

    /// Copies a matrix.
    pub fn copy_from(&mut self, other: &Self) {
        self.diagonal.clone_from(&other.diagonal);
        self.lower.clone_from(&other.lower);
        self.upper.clone_from(&other.upper);
    }

    /// Factorises in place. Returns the smallest pivot relative to its diagonal block; 0 means that a block is singular, and
    /// then no solve may follow.
    pub fn factor(&mut self, symbolic: &Symbolic) -> f64 {
        let s = symbolic;
        self.swaps.clear();
        self.swaps.resize(s.size.iter().sum(), 0);
        self.place.clear();
        self.place.resize(s.count(), 0);
        let mut smallest = f64::INFINITY;
        for j in 0..s.count() {
            let size = s.size[j];
            for entry in s.offsets[j]..s.offsets[j + 1] {
                self.place[s.rows[entry] as usize] = s.row_start[entry] * size;
            }
            self.apply_updates(s, j);
            let block = &mut self.diagonal[s.diagonal[j]..s.diagonal[j + 1]];
            let swaps = &mut self.swaps[s.first_dof[j]..s.first_dof[j] + size];
            smallest = smallest.min(factor_block(block, swaps));
            if smallest == 0.0 {
                return 0.0;
            }
            for row in self.upper[s.panel[j]..s.panel[j + 1]].chunks_exact_mut(size) {
                solve_block(block, swaps, row);
            }
        }
        if s.count() == 0 { 1.0 } else { smallest }
    }

    /// Subtracts from block column and block row `j` what the earlier positions contribute.
    fn apply_updates(&mut self, s: &Symbolic, j: usize) {
        let size = s.size[j];
        for &(k, entry) in &s.updates[s.update_offsets[j]..s.update_offsets[j + 1]] {
            let k = k as usize;
            let inner = s.size[k];
            let first = s.panel[k] + s.row_start[entry] * inner;
            let (lower_done, lower_rest) = self.lower.split_at_mut(s.panel[j]);
            let (upper_done, upper_rest) = self.upper.split_at_mut(s.panel[j]);
            let (l, u) = (&lower_done[first..first + size * inner], &upper_done[first..first + size * inner]);
            subtract_product(&mut self.diagonal[s.diagonal[j]..s.diagonal[j + 1]], l, u, inner, size);
            for other in entry + 1..s.offsets[k + 1] {
                let row = s.rows[other] as usize;
                let (from, height) = (s.panel[k] + s.row_start[other] * inner, s.size[row]);
                let to = self.place[row];
                let target = to..to + height * size;
                let source = from..from + height * inner;
                subtract_product(&mut lower_rest[target.clone()], &lower_done[source.clone()], u, inner, size);
                subtract_product(&mut upper_rest[target], &upper_done[source], l, inner, size);
            }
        }
    }

    /// Overwrites `x` (degrees of freedom in their own order) with `A⁻¹ x`.
    pub fn solve(&mut self, symbolic: &Symbolic, x: &mut [f64]) {
        let s = symbolic;
        let Self { diagonal, lower, upper, swaps, scratch, .. } = self;
        for k in 0..s.count() {
            let own = s.first_dof[k]..s.first_dof[k] + s.size[k];
            if x[own.clone()].iter().all(|x| *x == 0.0) {
                continue;
            }
            solve_block(&diagonal[s.diagonal[k]..s.diagonal[k + 1]], &swaps[own.clone()], &mut x[own.clone()]);
            scratch.clear();
            scratch.extend_from_slice(&x[own]);
            for entry in s.offsets[k]..s.offsets[k + 1] {
                let row = s.rows[entry] as usize;
                let from = s.panel[k] + s.row_start[entry] * s.size[k];
                let block = &lower[from..from + s.size[row] * s.size[k]];
                subtract_multiply(&mut x[s.first_dof[row]..s.first_dof[row] + s.size[row]], block, scratch);
            }
        }
        for k in (0..s.count()).rev() {
            let own = s.first_dof[k]..s.first_dof[k] + s.size[k];
            scratch.clear();
            scratch.extend_from_slice(&x[own.clone()]);
            for entry in s.offsets[k]..s.offsets[k + 1] {
                let row = s.rows[entry] as usize;
                let from = s.panel[k] + s.row_start[entry] * s.size[k];
                let block = &upper[from..from + s.size[row] * s.size[k]];
                subtract_multiply_transposed(scratch, block, &x[s.first_dof[row]..s.first_dof[row] + s.size[row]]);
            }
            x[own].copy_from_slice(scratch);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pseudo-random number between −1 and 1.
    fn noise(k: usize) -> f64 {
        ((k as f64 + 1.0).sin() * 43758.5453).fract()
    }

    #[test]
    fn solves_graphs_of_unequal_blocks() {
        let sizes = [6, 6, 3, 6, 1, 6, 6, 70, 6];
        let edges = [(0, 1), (1, 2), (2, 3), (0, 3), (3, 4), (4, 7), (5, 6), (5, 7), (1, 6)];
        let starts: Vec<usize> = std::iter::once(0)
            .chain(sizes.iter().scan(0, |sum, s| {
                Some({
                    *sum += s;
                    *sum
                })
            }))
            .collect();
        let n = starts[sizes.len()];
        let mut symbolic = Symbolic::default();
        symbolic.analyse(&starts, &edges);
        let mut lu = BlockLu::default();
        lu.clear(&symbolic);
        let mut dense = vec![0.0; n * n];
        for (a, &size) in sizes.iter().enumerate() {
            let place = symbolic.diagonal[symbolic.position[a] as usize];
            for k in 0..size * size {
                let (i, j) = (k / size, k % size);
                let x = noise(k + 31 * a) + if i == (j + 1) % size { 8.0 } else { 0.0 };
                lu.diagonal[place + k] = x;
                dense[(starts[a] + i) * n + starts[a] + j] = x;
            }
        }
        for &(a, b) in &edges {
            let (a, b) = if symbolic.position[a as usize] < symbolic.position[b as usize] { (a, b) } else { (b, a) };
            let (a, b) = (a as usize, b as usize);
            let place = symbolic.block_in_panel(a, b);
            for k in 0..sizes[a] * sizes[b] {
                let (i, j) = (k / sizes[a], k % sizes[a]);
                lu.lower[place + k] = noise(7 * k + a);
                lu.upper[place + k] = noise(5 * k + b);
                dense[(starts[b] + i) * n + starts[a] + j] = noise(7 * k + a);
                dense[(starts[a] + j) * n + starts[b] + i] = noise(5 * k + b);
            }
        }
        let wanted: Vec<f64> = (0..n).map(|i| 1.0 + noise(i)).collect();
        let mut x: Vec<f64> = dense.chunks(n).map(|row| row.iter().zip(&wanted).map(|(a, x)| a * x).sum()).collect();
        assert!(lu.factor(&symbolic) > 0.0);
        lu.solve(&symbolic, &mut x);
        for i in 0..n {
            assert!((x[i] - wanted[i]).abs() < 1e-9, "x[{i}] = {}, not {}", x[i], wanted[i]);
        }
    }

    #[test]
    fn a_singular_block_is_reported() {
        let mut symbolic = Symbolic::default();
        symbolic.analyse(&[0, 2, 4], &[(0, 1)]);
        let mut lu = BlockLu::default();
        lu.clear(&symbolic);
        assert_eq!(lu.factor(&symbolic), 0.0);
    }
}
