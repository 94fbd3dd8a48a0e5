//! LU factorisation of a block-sparse matrix with a symmetric pattern, pivoting inside the diagonal blocks.

use pulp::{Arch, Simd, WithSimd};

use super::Symbolic;
use super::kernels::{copy_few, factor_block, solve_block, solve_panel, subtract_few};
use super::panels::{Panel, PanelMut, SUMS};
use super::products::{multiply_transposed, subtract_multiply, subtract_product};

/// A matrix in the panels of a [`Symbolic`] structure and, after [`factor`](Self::factor), its factors.
///
/// `A = L̃ D⁻¹ Ũ` in the order of elimination: the panel of position `k` in `lower` has the transposed blocks `L̃_ik`, that in
/// `upper` the diagonal block and, after it, the blocks `D_k⁻¹ Ũ_ki`.
#[derive(Clone, Debug, Default)]
pub struct BlockLu {
    /// The panels below the diagonal, transposed.
    pub lower: Vec<f64>,
    /// The diagonal blocks and the panels beside them.
    pub upper: Vec<f64>,
    /// The factorised diagonal blocks.
    diagonal: Vec<f64>,
    swaps: Vec<u32>,
    /// Column of each block in the panel of `U` at hand.
    place: Vec<usize>,
    /// Part of a vector below the diagonal.
    scratch: Vec<[f64; SUMS]>,
}

impl BlockLu {
    /// Makes the matrix zero, with a little room behind it: solves read rows to a multiple of their sums.
    pub fn clear(&mut self, symbolic: &Symbolic) {
        let zero = |x: &mut Vec<f64>, n: usize| {
            x.clear();
            x.resize(n, 0.0);
        };
        zero(&mut self.lower, symbolic.panel[symbolic.count()] + SUMS);
        zero(&mut self.upper, symbolic.upper_panel(symbolic.count()) + SUMS);
    }

    /// Copies a matrix.
    pub fn copy_from(&mut self, other: &Self) {
        self.lower.clone_from(&other.lower);
        self.upper.clone_from(&other.upper);
    }

    /// Factorises in place. Returns the smallest pivot relative to its diagonal block; 0 means that a block is singular, and
    /// then no solve may follow.
    pub fn factor(&mut self, symbolic: &Symbolic) -> f64 {
        Arch::new().dispatch(Factorisation { matrix: self, symbolic })
    }

    /// The sign of the determinant of the matrix that is factorised.
    pub fn determinant_sign(&self, symbolic: &Symbolic) -> f64 {
        let mut sign = 1.0;
        for k in 0..symbolic.count() {
            let (size, first) = (symbolic.size[k], symbolic.first_dof[k]);
            let block = &self.diagonal[symbolic.diagonal[k]..symbolic.diagonal[k + 1]];
            for r in 0..size {
                let is_swapped = self.swaps[first + r] as usize != r;
                if is_swapped != (block[r * size + r] < 0.0) {
                    sign = -sign;
                }
            }
        }
        sign
    }

    /// Subtracts from block column and block row `j` what the earlier positions contribute.
    #[inline(always)]
    fn apply_updates<S: Simd>(&mut self, simd: S, s: &Symbolic, j: usize) {
        let size = s.size[j];
        let (lower_done, lower_own) = self.lower.split_at_mut(s.panel[j]);
        let (upper_done, upper_own) = self.upper.split_at_mut(s.upper_panel(j));
        let place = &self.place[..];
        for &(k, entry) in &s.updates[s.update_offsets[j]..s.update_offsets[j + 1]] {
            let k = k as usize;
            let lower = Panel { data: &lower_done[s.panel[k]..], stride: s.height[k] };
            let upper = Panel { data: &upper_done[s.upper_panel(k) + s.size[k]..], stride: s.width(k) };
            for is_upper in [false, true] {
                let (factors, source) = if is_upper { (lower, upper) } else { (upper, lower) };
                let factors = factors.from(s.row_start[entry]);
                // The diagonal block is the first of the upper panel.
                let mut other = entry + usize::from(!is_upper);
                while other < s.offsets[k + 1] {
                    let (from, to) = (s.row_start[other], place[s.rows[other] as usize]);
                    let mut columns = 0;
                    // Blocks that are neighbours in both panels are done together.
                    while other < s.offsets[k + 1] && place[s.rows[other] as usize] == to + columns {
                        columns += s.size[s.rows[other] as usize];
                        other += 1;
                    }
                    let target = if is_upper {
                        PanelMut { data: &mut upper_own[to..], stride: s.width(j) }
                    } else {
                        PanelMut { data: &mut lower_own[to - size..], stride: s.height[j] }
                    };
                    subtract_product(simd, target, factors, source.from(from), (s.size[k], size, columns));
                }
            }
        }
    }

    /// Overwrites `x` (degrees of freedom in their own order) with `A⁻¹ x`.
    pub fn solve(&mut self, symbolic: &Symbolic, x: &mut [f64]) {
        Arch::new().dispatch(Solution { matrix: self, symbolic, x });
    }
}

struct Factorisation<'a> {
    matrix: &'a mut BlockLu,
    symbolic: &'a Symbolic,
}

impl WithSimd for Factorisation<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let Self { matrix, symbolic: s } = self;
        matrix.swaps.resize(s.size.iter().sum(), 0);
        matrix.place.resize(s.count(), 0);
        matrix.diagonal.resize(s.diagonal[s.count()], 0.0);
        let mut smallest = f64::INFINITY;
        for j in 0..s.count() {
            let (size, width) = (s.size[j], s.width(j));
            matrix.place[j] = 0;
            for entry in s.offsets[j]..s.offsets[j + 1] {
                matrix.place[s.rows[entry] as usize] = size + s.row_start[entry];
            }
            matrix.apply_updates(simd, s, j);
            let upper = &mut matrix.upper[s.upper_panel(j)..s.upper_panel(j + 1)];
            let block = &mut matrix.diagonal[s.diagonal[j]..s.diagonal[j + 1]];
            for (own, row) in block.chunks_exact_mut(size).zip(upper.chunks_exact(width)) {
                copy_few(own, &row[..size]);
            }
            let swaps = &mut matrix.swaps[s.first_dof[j]..s.first_dof[j] + size];
            smallest = smallest.min(factor_block(block, swaps));
            if smallest == 0.0 {
                return 0.0;
            }
            solve_panel(block, swaps, upper, width);
        }
        if s.count() == 0 { 1.0 } else { smallest }
    }
}

struct Solution<'a> {
    matrix: &'a mut BlockLu,
    symbolic: &'a Symbolic,
    x: &'a mut [f64],
}

impl WithSimd for Solution<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Self { matrix: BlockLu { diagonal, lower, upper, swaps, scratch, .. }, symbolic: s, x } = self;
        scratch.resize(s.height.iter().copied().max().unwrap_or(0).div_ceil(SUMS), [0.0; SUMS]);
        for k in 0..s.count() {
            let own = s.first_dof[k]..s.first_dof[k] + s.size[k];
            if x[own.clone()].iter().all(|x| *x == 0.0) {
                continue;
            }
            solve_block(&diagonal[s.diagonal[k]..s.diagonal[k + 1]], &swaps[own.clone()], &mut x[own.clone()]);
            let products = &mut scratch[..s.height[k].div_ceil(SUMS)];
            let panel = Panel { data: &lower[s.panel[k]..], stride: s.height[k] };
            multiply_transposed(simd, products, panel, &x[own]);
            let products = products.as_flattened();
            for entry in s.offsets[k]..s.offsets[k + 1] {
                let (row, first) = (s.rows[entry] as usize, s.row_start[entry]);
                subtract_few(&mut x[s.first_dof[row]..][..s.size[row]], &products[first..first + s.size[row]]);
            }
        }
        for k in (0..s.count()).rev() {
            let padded = &mut scratch[..s.height[k].div_ceil(SUMS)];
            let below = padded.as_flattened_mut();
            for entry in s.offsets[k]..s.offsets[k + 1] {
                let (row, first) = (s.rows[entry] as usize, s.row_start[entry]);
                copy_few(&mut below[first..first + s.size[row]], &x[s.first_dof[row]..][..s.size[row]]);
            }
            below[s.height[k]..].fill(0.0);
            let upper = Panel { data: &upper[s.upper_panel(k) + s.size[k]..], stride: s.width(k) };
            subtract_multiply(simd, &mut x[s.first_dof[k]..][..s.size[k]], upper, padded);
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

    fn check_with<S: Simd>(simd: S, matrix: (BlockLu, Vec<f64>), symbolic: &Symbolic, wanted: (&BlockLu, &[f64])) {
        let (mut matrix, mut x) = matrix;
        Factorisation { matrix: &mut matrix, symbolic }.with_simd(simd);
        let (lu, wanted) = wanted;
        assert!(matrix.lower == lu.lower && matrix.upper == lu.upper && matrix.diagonal == lu.diagonal);
        Solution { matrix: &mut matrix, symbolic, x: &mut x }.with_simd(simd);
        assert_eq!(x, wanted);
    }

    #[test]
    fn solves_graphs_of_unequal_blocks() {
        let sizes = [6, 6, 3, 6, 1, 6, 6, 70, 6, 6, 6, 6, 6, 6, 3, 3, 3, 6];
        let mut edges = vec![(0, 1), (1, 2), (2, 3), (0, 3), (3, 4), (4, 7), (5, 6), (5, 7), (1, 6)];
        // All coupled with all, for panels of many widths; and legs on a trunk.
        edges.extend((8..14).flat_map(|b| (8..b).map(move |a| (a, b))));
        edges.extend([(13, 17), (14, 15), (14, 16), (15, 16), (14, 17), (15, 17), (16, 17)]);
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
            let position = symbolic.position[a] as usize;
            let (place, stride) = (symbolic.upper_panel(position), symbolic.width(position));
            for k in 0..size * size {
                let (i, j) = (k / size, k % size);
                let x = noise(k + 31 * a) + if i == (j + 1) % size { 8.0 } else { 0.0 };
                lu.upper[place + i * stride + j] = x;
                dense[(starts[a] + i) * n + starts[a] + j] = x;
            }
        }
        for &(a, b) in &edges {
            let (a, b) = if symbolic.position[a as usize] < symbolic.position[b as usize] { (a, b) } else { (b, a) };
            let (a, b) = (a as usize, b as usize);
            let place = symbolic.place(a, b);
            for k in 0..sizes[a] * sizes[b] {
                let (i, j) = (k / sizes[a], k % sizes[a]);
                lu.lower[place.lower + j * place.lower_stride + i] = noise(7 * k + a);
                lu.upper[place.upper + j * place.upper_stride + i] = noise(5 * k + b);
                dense[(starts[b] + i) * n + starts[a] + j] = noise(7 * k + a);
                dense[(starts[a] + j) * n + starts[b] + i] = noise(5 * k + b);
            }
        }
        let wanted: Vec<f64> = (0..n).map(|i| 1.0 + noise(i)).collect();
        let mut x: Vec<f64> = dense.chunks(n).map(|row| row.iter().zip(&wanted).map(|(a, x)| a * x).sum()).collect();
        let matrix = (lu.clone(), x.clone());
        assert!(lu.factor(&symbolic) > 0.0);
        lu.solve(&symbolic, &mut x);
        // Without vectors the bits are the same, and with narrower ones.
        check_with(pulp::Scalar::new(), matrix.clone(), &symbolic, (&lu, &x));
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = pulp::x86::V3::try_new() {
            check_with(simd, matrix.clone(), &symbolic, (&lu, &x));
        }
        for i in 0..n {
            assert!((x[i] - wanted[i]).abs() < 1e-9, "x[{i}] = {}, not {}", x[i], wanted[i]);
        }
        assert_eq!(lu.determinant_sign(&symbolic), sign_by_elimination(dense, n));
    }

    /// The sign of the determinant of a matrix of `n` rows.
    fn sign_by_elimination(mut a: Vec<f64>, n: usize) -> f64 {
        let mut sign = 1.0;
        for k in 0..n {
            let pivot = (k..n).max_by(|&i, &j| a[i * n + k].abs().total_cmp(&a[j * n + k].abs())).expect("a row");
            if pivot != k {
                (0..n).for_each(|c| a.swap(k * n + c, pivot * n + c));
                sign = -sign;
            }
            sign *= a[k * n + k].signum();
            for i in k + 1..n {
                let factor = a[i * n + k] / a[k * n + k];
                (k..n).for_each(|c| a[i * n + c] -= factor * a[k * n + c]);
            }
        }
        sign
    }

    /// Every exchange of two rows of a block turns the sign, and so does every negative diagonal.
    #[test]
    fn signs_of_determinants_follow_exchanges() {
        let mut symbolic = Symbolic::default();
        symbolic.analyse(&[0, 3, 6], &[]);
        for (diagonal, exchanged, sign) in
            [(1.0, false, 1.0), (-1.0, false, -1.0), (1.0, true, -1.0), (-1.0, true, 1.0)]
        {
            let mut lu = BlockLu::default();
            lu.clear(&symbolic);
            for k in 0..6 {
                let (block, r) = (k / 3, k % 3);
                let column = if exchanged && block == 0 { [1, 0, 2][r] } else { r };
                lu.upper[symbolic.upper_panel(block) + r * symbolic.width(block) + column] =
                    if k == 5 { diagonal } else { 1.0 };
            }
            assert!(lu.factor(&symbolic) > 0.0);
            assert_eq!(lu.determinant_sign(&symbolic), sign);
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
