//! Factorisation of block-diagonal matrices along kinematic trees.

mod half_solves;

use std::ops::Range;
use std::sync::Arc;

use crate::dot::dot;
use crate::layout::{Block, Layout};
use crate::mass::{BlockDiagonal, MassError};
use crate::standing::{Known, Nothing};

/// The factor `L` of `A = Lᵀ L` of a [`BlockDiagonal`], lower triangular.
///
/// Factorised from the last degree of freedom to the first, `L` has no entries where two degrees of freedom are not on one
/// path to the root, so branches do not fill in and a right-hand side that lives on paths to the root stays there.
///
/// # Source
/// Featherstone (2008), Rigid Body Dynamics Algorithms, ch. 6.5 (`LTL` factorisation), with the loops in the order in which
/// each entry is finished at once: all sums then run along a row of `Lᵀ` over the degrees of freedom that a joint carries.
#[derive(Debug)]
pub struct BlockCholesky {
    layout: Arc<Layout>,
    /// `Lᵀ`: upper triangles in dense row-major blocks.
    data: Vec<f64>,
    inverse_diagonal: Vec<f64>,
    /// For small blocks what was factorised last: those of bodies that fly freely do not change while these turn about their
    /// origin.
    source: Vec<f64>,
    /// Whether the factor of a block is that of its `source`.
    known: Vec<bool>,
    /// Whether a small block's factor has nothing beside its diagonal: that of a body that flies freely, where its origin is its
    /// centre of mass and its axes are those of its inertia.
    diagonal: Vec<bool>,
    /// Whether no block's factor has anything beside its diagonal.
    all_diagonal: bool,
}

/// Rows up to which a block's sparse columns are solved on the stack: free bodies and robots.
pub const FEW_ROWS: usize = 64;

/// Columns that are half solved side by side: the numbers of the widest vector.
pub const LANES: usize = 8;

/// Comparing a block with the last one is cheap beside factorising it up to this many rows.
const SMALL: usize = 6;

impl BlockCholesky {
    /// Storage for the factor of a matrix with the same blocks; holds the identity's factor until
    /// [`refactor`](Self::refactor) is called.
    pub fn new(matrix: &BlockDiagonal) -> Self {
        let mut data = vec![0.0; matrix.data().len()];
        for block in matrix.blocks() {
            for i in 0..block.size {
                data[block.offset + i * (block.size + 1)] = 1.0;
            }
        }
        Self {
            layout: matrix.layout().clone(),
            data,
            inverse_diagonal: vec![1.0; matrix.dimension()],
            source: vec![0.0; matrix.data().len()],
            known: vec![false; matrix.blocks().len()],
            diagonal: vec![false; matrix.blocks().len()],
            all_diagonal: false,
        }
    }

    /// Factorises a matrix with the same blocks.
    ///
    /// # Errors
    /// [`MassError::NotPositiveDefinite`] with the degree of freedom; the factor is then not to be used.
    ///
    /// # Panics
    /// If the matrix has other blocks or couples other rows.
    pub fn refactor(&mut self, matrix: &BlockDiagonal) -> Result<(), MassError> {
        self.refactor_of(matrix, Nothing)
    }

    /// [`refactor`](Self::refactor) of the blocks that are not known.
    pub(crate) fn refactor_of(&mut self, matrix: &BlockDiagonal, skipped: impl Known) -> Result<(), MassError> {
        assert!(self.layout == *matrix.layout(), "the factor was made for another matrix");
        let Self { layout, data, inverse_diagonal, source, known, diagonal, all_diagonal } = self;
        *all_diagonal = false;
        for (b, ((block, known), diagonal)) in layout.blocks.iter().zip(known).zip(&mut *diagonal).enumerate() {
            if skipped.has_block(b) {
                continue;
            }
            let (a, source) = (matrix.data_of(block), &mut source[block.data_range()]);
            if *known && same_bits(a, source) {
                continue;
            }
            (*known, *diagonal) = (false, false);
            let (u, inverse) = (&mut data[block.data_range()], &mut inverse_diagonal[block.range()]);
            factor_block(a, block, layout, u, inverse)?;
            if block.size <= SMALL {
                source.copy_from_slice(a);
                *known = true;
                let beside = |k: usize| &u[k * block.size..(k + 1) * block.size][k + 1..];
                *diagonal = (0..block.size).all(|k| beside(k).iter().all(|x| *x == 0.0));
            }
        }
        *all_diagonal = diagonal.iter().all(|is_diagonal| *is_diagonal);
        Ok(())
    }

    /// `X ← A⁻¹ X`, for many right-hand sides at once: `[nv, width]` row by row. To be inlined into what is compiled for wide vectors.
    ///
    /// # Panics
    /// If the length is another one.
    #[inline(always)]
    pub fn solve_rows_in_place(&self, x: &mut [f64], width: usize) {
        assert_eq!(x.len(), self.layout.block_of.len() * width, "length must be the dimension times the width");
        for block in &self.layout.blocks {
            let rows = &mut x[block.start * width..(block.start + block.size) * width];
            let (n, u) = (block.size, &self.data[block.data_range()]);
            let (ends, inverse) = (&self.layout.end[block.range()], &self.inverse_diagonal[block.range()]);
            for k in (0..n).rev() {
                let (head, tail) = rows.split_at_mut((k + 1) * width);
                let own = &mut head[k * width..];
                for (j, other) in (k + 1..ends[k] - block.start).zip(tail.chunks_exact(width.max(1))) {
                    let factor = u[k * n + j];
                    own.iter_mut().zip(other).for_each(|(x, y)| *x -= factor * y);
                }
                own.iter_mut().for_each(|x| *x *= inverse[k]);
            }
            for k in 0..n {
                let (head, tail) = rows.split_at_mut((k + 1) * width);
                let own = &mut head[k * width..];
                own.iter_mut().for_each(|x| *x *= inverse[k]);
                for (j, other) in (k + 1..ends[k] - block.start).zip(tail.chunks_exact_mut(width.max(1))) {
                    let factor = u[k * n + j];
                    other.iter_mut().zip(&*own).for_each(|(x, y)| *x -= factor * y);
                }
            }
        }
    }

    /// One over the pivot of a row in the elimination from the last row to the first.
    pub(crate) fn inverse_pivot(&self, row: usize) -> f64 {
        self.inverse_diagonal[row] * self.inverse_diagonal[row]
    }

    /// The blocks of the factorised matrix.
    pub fn blocks(&self) -> &[Block] {
        &self.layout.blocks
    }

    /// The blocks that ascending columns lie in: each by its index, with the places of its columns among all of these.
    pub fn blocks_touched<'a>(&'a self, columns: &'a [u32]) -> impl Iterator<Item = (usize, Range<usize>)> + 'a {
        self.layout.blocks_touched(columns)
    }

    /// Entries of a block of the factor, `Lᵀ` row by row, `[size, size]`.
    pub fn block_data(&self, block: usize) -> &[f64] {
        &self.data[self.layout.blocks[block].data_range()]
    }

    /// `x ← A⁻¹ x`, `[nv]`.
    ///
    /// # Panics
    /// If the length is not the dimension.
    pub fn solve_in_place(&self, x: &mut [f64]) {
        assert_eq!(x.len(), self.layout.block_of.len(), "length must be the dimension");
        if self.all_diagonal {
            return x.iter_mut().zip(&self.inverse_diagonal).for_each(|(x, inverse)| *x = *x * inverse * inverse);
        }
        for (b, block) in self.layout.blocks.iter().enumerate() {
            if block.size == 1 {
                let inverse = self.inverse_diagonal[block.start];
                x[block.start] = x[block.start] * inverse * inverse;
            } else {
                self.solve_block_in_place(b, &mut x[block.range()]);
            }
        }
    }

    /// `x ← A⁻¹ right + y` in the blocks that are not known, but for those that come `from_elsewhere`, in which anything may be left.
    pub(crate) fn solve_and_add_of<K: Known>(
        &self,
        known: K,
        from_elsewhere: impl Fn(usize) -> bool,
        right: &[f64],
        y: &[f64],
        x: &mut [f64],
    ) {
        if self.all_diagonal && !K::IS_SOME {
            let entries = x.iter_mut().zip(&self.inverse_diagonal).zip(right).zip(y);
            return entries.for_each(|(((x, inverse), right), y)| *x = right * inverse * inverse + y);
        }
        let asked = |b: &usize| !known.has_block(*b) && !from_elsewhere(*b);
        for (b, block) in self.layout.blocks.iter().enumerate().filter(|(b, _)| asked(b)) {
            let own = &mut x[block.range()];
            own.copy_from_slice(&right[block.range()]);
            self.solve_block_in_place(b, own);
            own.iter_mut().zip(&y[block.range()]).for_each(|(x, y)| *x += y);
        }
    }

    /// `x ← A_b⁻¹ x` for one block, `[size]`.
    ///
    /// # Panics
    /// If the length is not the block's size.
    pub fn solve_block_in_place(&self, block: usize, x: &mut [f64]) {
        if self.diagonal[block] {
            let inverse = &self.inverse_diagonal[self.layout.blocks[block].range()];
            assert_eq!(x.len(), inverse.len(), "length must be the block's size");
            return x.iter_mut().zip(inverse).for_each(|(x, inverse)| *x = *x * inverse * inverse);
        }
        match self.layout.blocks[block].size {
            1 => return self.solve_small::<1>(block, x),
            3 => return self.solve_small::<3>(block, x),
            6 => return self.solve_small::<6>(block, x),
            _ => self.half_solve_block_in_place(block, x),
        }
        self.other_half_solve_block_in_place(block, x);
    }

    /// The first half of [`solve_block_in_place`](Self::solve_block_in_place), `x ← L⁻ᵀ x` within one block, so that `xᵀx` is
    /// `xᵀA⁻¹x` of before.
    ///
    /// # Panics
    /// If the length is not the block's size.
    pub fn half_solve_block_in_place(&self, block: usize, x: &mut [f64]) {
        let is_diagonal = self.diagonal[block];
        let block = &self.layout.blocks[block];
        let (n, end) = (block.size, &self.layout.end[block.range()]);
        assert_eq!(x.len(), n, "length must be the block's size");
        if is_diagonal {
            return scale_rows(x, &self.inverse_diagonal[block.range()]);
        }
        let rows = self.data[block.data_range()].chunks_exact(n);
        let inverse = &self.inverse_diagonal[block.range()];
        for (k, (row, (&inverse, &end))) in rows.zip(inverse.iter().zip(end)).enumerate().rev() {
            let (head, tail) = x.split_at_mut(k + 1);
            let carried = end - block.start - k - 1;
            head[k] = (head[k] - dot(&tail[..carried], &row[k + 1..][..carried])) * inverse;
        }
    }

    /// The second half of [`solve_block_in_place`](Self::solve_block_in_place), `x ← L⁻¹ x` within one block.
    ///
    /// # Panics
    /// If the length is not the block's size.
    pub fn other_half_solve_block_in_place(&self, block: usize, x: &mut [f64]) {
        let is_diagonal = self.diagonal[block];
        let block = &self.layout.blocks[block];
        let (n, end) = (block.size, &self.layout.end[block.range()]);
        assert_eq!(x.len(), n, "length must be the block's size");
        let inverse = &self.inverse_diagonal[block.range()];
        if is_diagonal {
            return scale_rows(x, inverse);
        }
        let rows = self.data[block.data_range()].chunks_exact(n);
        for (k, (row, (&inverse, &end))) in rows.zip(inverse.iter().zip(end)).enumerate() {
            let (head, tail) = x.split_at_mut(k + 1);
            head[k] *= inverse;
            let carried = end - block.start - k - 1;
            subtract_multiple(&mut tail[..carried], head[k], &row[k + 1..][..carried]);
        }
    }

    /// The same for a block of `N` rows: a part of a free body or all of it. Entries that its coupling lacks are zero.
    fn solve_small<const N: usize>(&self, block: usize, x: &mut [f64]) {
        let block = &self.layout.blocks[block];
        let x: &mut [f64; N] = x.try_into().expect("length must be the block's size");
        let rows = self.data[block.data_range()].as_chunks::<N>().0;
        let inverse = &self.inverse_diagonal[block.range()];
        let (Some(u), Some(inverse)) = (rows.first_chunk::<N>(), inverse.first_chunk::<N>()) else { return };
        for k in (0..N).rev() {
            let mut sum = x[k];
            for j in k + 1..N {
                sum -= u[k][j] * x[j];
            }
            x[k] = sum * inverse[k];
        }
        for k in 0..N {
            x[k] *= inverse[k];
            for j in k + 1..N {
                x[j] -= u[k][j] * x[k];
            }
        }
    }
}

impl Clone for BlockCholesky {
    fn clone(&self) -> Self {
        Self {
            layout: self.layout.clone(),
            data: self.data.clone(),
            inverse_diagonal: self.inverse_diagonal.clone(),
            source: self.source.clone(),
            known: self.known.clone(),
            diagonal: self.diagonal.clone(),
            all_diagonal: self.all_diagonal,
        }
    }

    /// Keeps the memory at hand.
    fn clone_from(&mut self, other: &Self) {
        self.layout.clone_from(&other.layout);
        self.data.clone_from(&other.data);
        self.inverse_diagonal.clone_from(&other.inverse_diagonal);
        self.source.clone_from(&other.source);
        self.known.clone_from(&other.known);
        self.diagonal.clone_from(&other.diagonal);
        self.all_diagonal = other.all_diagonal;
    }
}

impl BlockDiagonal {
    /// Factorises the matrix; [`BlockCholesky::refactor`] does the same without allocation.
    ///
    /// # Errors
    /// [`MassError::NotPositiveDefinite`].
    pub fn factor(&self) -> Result<BlockCholesky, MassError> {
        let mut factor = BlockCholesky::new(self);
        factor.refactor(self)?;
        Ok(factor)
    }
}

/// `U` with `A = U Uᵀ` of one dense row-major block; below the diagonal of `U` nothing is read or written.
fn factor_block(
    a: &[f64],
    block: &Block,
    layout: &Layout,
    u: &mut [f64],
    inverse: &mut [f64],
) -> Result<(), MassError> {
    let (n, start) = (block.size, block.start);
    for k in (0..n).rev() {
        let carried = k + 1..layout.end(start + k) - start;
        let (above, row) = u.split_at_mut(k * n);
        let carried_row = &row[carried.clone()];
        let diagonal = a[k * (n + 1)];
        let pivot = diagonal - dot(carried_row, carried_row);
        // What is left of the diagonal after elimination has an error of some roundings of the original entry.
        if !(pivot > 4.0 * n as f64 * f64::EPSILON * diagonal && pivot.is_finite()) {
            return Err(MassError::NotPositiveDefinite { dof: start + k, pivot });
        }
        let root = pivot.sqrt();
        inverse[k] = 1.0 / root;
        let mut next = layout.previous(start + k);
        while let Some(last) = next {
            let first = layout.run_start(last);
            let run = (first - start) * n..(last + 1 - start) * n;
            eliminate(&mut above[run.clone()], &a[run], n, k, carried_row, inverse[k]);
            next = layout.previous(first);
        }
        row[k] = root;
    }
    Ok(())
}

fn scale_rows(x: &mut [f64], factors: &[f64]) {
    x.iter_mut().zip(factors).for_each(|(x, factor)| *x *= factor);
}

fn same_bits(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).fold(0, |difference, (a, b)| difference | (a.to_bits() ^ b.to_bits())) == 0
}

/// Finishes column `k` of neighbouring rows on the way to the root, four of which share the loads of the carried part of row `k`.
fn eliminate(targets: &mut [f64], sources: &[f64], n: usize, k: usize, carried_row: &[f64], inverse: f64) {
    let carried = k + 1..k + 1 + carried_row.len();
    if carried_row.len() <= 2 {
        for (row, source) in targets.chunks_exact_mut(n).zip(sources.chunks_exact(n)) {
            row[k] = (source[k] - dot(&row[carried.clone()], carried_row)) * inverse;
        }
        return;
    }
    let (fours, mut rest) = (targets.len() / (4 * n), sources);
    let (head, tail) = targets.split_at_mut(4 * n * fours);
    for rows in head.chunks_exact_mut(4 * n) {
        let sums = four_dots(std::array::from_fn(|r| &rows[r * n..][carried.clone()]), carried_row);
        for (r, [even, odd]) in sums.into_iter().enumerate() {
            rows[r * n + k] = (rest[r * n + k] - (even + odd)) * inverse;
        }
        rest = &rest[4 * n..];
    }
    for (row, source) in tail.chunks_exact_mut(n).zip(rest.chunks_exact(n)) {
        row[k] = (source[k] - dot(&row[carried.clone()], carried_row)) * inverse;
    }
}

/// `x −= f y`. Near the leaves of a tree rows are short.
#[inline]
fn subtract_multiple(x: &mut [f64], f: f64, y: &[f64]) {
    match (x, y) {
        ([], []) => {}
        ([a], [p]) => *a -= p * f,
        ([a, b], [p, q]) => (*a, *b) = (*a - p * f, *b - q * f),
        (x, y) => x.iter_mut().zip(y).for_each(|(x, y)| *x -= y * f),
    }
}

/// The scalar products of four rows with one, each as two sums: of the products at even and at odd places.
#[inline]
fn four_dots(rows: [&[f64]; 4], x: &[f64]) -> [[f64; 2]; 4] {
    let (pairs, rest) = x.as_chunks::<2>();
    let [a, b, c, d] = rows.map(|row| &row.as_chunks::<2>().0[..pairs.len()]);
    let mut sums = [[0.0; 2]; 4];
    for ((((x, a), b), c), d) in pairs.iter().zip(a).zip(b).zip(c).zip(d) {
        for (sums, row) in sums.iter_mut().zip([a, b, c, d]) {
            for l in 0..2 {
                sums[l] += row[l] * x[l];
            }
        }
    }
    // What becomes of the sums is hidden, lest the compiler multiplies one entry of each of two rows at a time, which it has to
    // gather, instead of two of each.
    let mut sums = sums.map(std::hint::black_box);
    if let [x] = rest {
        let last = 2 * pairs.len();
        (0..4).for_each(|r| sums[r][0] += rows[r][last] * x);
    }
    sums
}
