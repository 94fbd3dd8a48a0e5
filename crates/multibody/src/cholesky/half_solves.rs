//! Half solves: `L⁻ᵀ` on sparse columns along the ways to the root, and the squares that they give the Delassus operator.

use super::{BlockCholesky, FEW_ROWS, LANES, SMALL};
use crate::dot::dot;
use crate::layout::Block;

impl BlockCholesky {
    /// `Y ← L⁻ᵀ Y` for `N` columns of one block, so that `YᵀY` is the product with `A_b⁻¹` between them.
    /// - `rows`: the first rows of `Y`, `[at most size, N]`; those after them are zero and stay zero
    ///
    /// # Panics
    /// If there are more rows than the block has.
    pub fn half_solve_block<const N: usize>(&self, block: usize, rows: &mut [[f64; N]]) {
        let is_diagonal = self.diagonal[block];
        match (self.layout.blocks[block].size, rows.len()) {
            (1, 1) if !is_diagonal => return self.half_solve_small::<1, N>(block, rows),
            (3, 3) if !is_diagonal => return self.half_solve_small::<3, N>(block, rows),
            (6, 6) if !is_diagonal => return self.half_solve_small::<6, N>(block, rows),
            (size, count) => assert!(count <= size, "no more rows than the block has"),
        }
        let block = &self.layout.blocks[block];
        let (u, inverse) = (&self.data[block.data_range()], &self.inverse_diagonal[block.range()]);
        if is_diagonal {
            rows.iter_mut().zip(inverse).for_each(|(row, inverse)| row.iter_mut().for_each(|y| *y *= inverse));
            return;
        }
        for k in (0..rows.len()).rev() {
            let end = (self.layout.end(block.start + k) - block.start).min(rows.len());
            let (head, tail) = rows.split_at_mut(k + 1);
            let row = &mut head[k];
            for (u, y) in u[k * block.size + k + 1..k * block.size + end].iter().zip(tail.iter()) {
                for (t, y) in row.iter_mut().zip(y) {
                    *t -= u * y;
                }
            }
            row.iter_mut().for_each(|y| *y *= inverse[k]);
        }
    }

    /// The same for a block of `K` rows and all of them.
    fn half_solve_small<const K: usize, const N: usize>(&self, block: usize, rows: &mut [[f64; N]]) {
        let block = &self.layout.blocks[block];
        let u = self.data[block.data_range()].as_chunks::<K>().0;
        let inverse = &self.inverse_diagonal[block.range()];
        let (Some(u), Some(inverse), Some(rows)) =
            (u.first_chunk::<K>(), inverse.first_chunk::<K>(), rows.first_chunk_mut::<K>())
        else {
            return;
        };
        for k in (0..K).rev() {
            let mut row = rows[k];
            for j in k + 1..K {
                for n in 0..N {
                    row[n] -= u[k][j] * rows[j][n];
                }
            }
            rows[k] = row.map(|y| y * inverse[k]);
        }
    }

    /// The diagonal of `Yᵀ A_b⁻¹ Y` for `N` sparse columns in the same rows of one block of at most [`FEW_ROWS`] rows: `xᵀ A_b⁻¹ x`
    /// of each.
    /// - `rows`: ascending, counted from the block's first; `entries`: of `Y` in them
    ///
    /// # Panics
    /// If a row is not below the block's size or the block has more rows.
    ///
    /// # Cost
    /// Half a solve on the rows' ways to the root.
    pub fn inverse_squares<const N: usize>(&self, block: usize, rows: &[usize], entries: &[[f64; N]]) -> [f64; N] {
        // Most blocks are small, and what holds all their rows is zeroed each time.
        if self.layout.blocks[block].size <= FEW_ROWS / 4 {
            return self.squares_within::<N, { FEW_ROWS / 4 }>(block, rows, entries);
        }
        self.squares_within::<N, FEW_ROWS>(block, rows, entries)
    }

    /// The same in a block of at most `MOST` rows.
    fn squares_within<const N: usize, const MOST: usize>(
        &self,
        block: usize,
        rows: &[usize],
        entries: &[[f64; N]],
    ) -> [f64; N] {
        let mut y = [[0.0; N]; MOST];
        let mut active = self.half_solve_on_ways(block, rows, entries, &mut y);
        let mut squares = [0.0; N];
        while active != 0 {
            let k = 63 - active.leading_zeros() as usize;
            active &= !(1 << k);
            (0..N).for_each(|n| squares[n] += y[k][n] * y[k][n]);
        }
        squares
    }

    /// `xᵀ A_b⁻¹ x` for a sparse column of one block of any size.
    /// - `first`: before this row the column is zero
    /// - `x`: its rows up to the last one that is not zero, `[at most size]`; they are changed
    ///
    /// # Panics
    /// If there are more rows than the block has.
    ///
    /// # Cost
    /// The rows on the ways to the root, each times the length of the column.
    pub fn inverse_square(&self, block: usize, first: usize, x: &mut [f64]) -> f64 {
        let is_diagonal = self.diagonal[block];
        let block = &self.layout.blocks[block];
        let (u, inverse) = (&self.data[block.data_range()], &self.inverse_diagonal[block.range()]);
        if is_diagonal {
            return x.iter().zip(inverse).map(|(x, inverse)| (x * inverse).powi(2)).sum();
        }
        let mut square = 0.0;
        for k in (0..x.len()).rev() {
            let end = (self.layout.end(block.start + k) - block.start).min(x.len());
            // What hangs on this row has no part in the column.
            if end <= first {
                continue;
            }
            let (head, tail) = x.split_at_mut(k + 1);
            let carried = end - k - 1;
            head[k] = (head[k] - dot(&tail[..carried], &u[k * block.size + k + 1..][..carried])) * inverse[k];
            square += head[k] * head[k];
        }
        square
    }

    /// `Y ← L⁻ᵀ Y` for `N` sparse columns in the same rows of one block of at most [`FEW_ROWS`] rows, so that `YᵀY` is the product
    /// with `A_b⁻¹` between them.
    /// - `rows`: ascending, counted from the block's first; `entries`: of `Y` in them
    /// - `y`: out, `[at least size, N]`; written in the rows on the ways to the root, which are returned as bits
    fn half_solve_on_ways<const N: usize>(
        &self,
        block: usize,
        rows: &[usize],
        entries: &[[f64; N]],
        y: &mut [[f64; N]],
    ) -> u64 {
        let is_diagonal = self.diagonal[block];
        let block = &self.layout.blocks[block];
        let (u, inverse) = (&self.data[block.data_range()], &self.inverse_diagonal[block.range()]);
        let y = &mut y[..block.size];
        if is_diagonal {
            rows.iter().zip(entries).for_each(|(&k, entry)| y[k] = entry.map(|x| x * inverse[k]));
            return rows.iter().fold(0, |active, k| active | 1 << k);
        }
        if self.is_way(block, rows) {
            return half_solve_on_way(u, inverse, rows, entries, y);
        }
        // All rows on the ways to the root: a bit and, from the last one on, what the solve gives each.
        let mut active = 0_u64;
        for (&k, entry) in rows.iter().zip(entries) {
            let mut next = Some(block.start + k);
            while let Some(row) = next.filter(|row| active & (1 << (row - block.start)) == 0) {
                active |= 1 << (row - block.start);
                y[row - block.start] = [0.0; N];
                next = self.layout.previous(row);
            }
            y[k] = *entry;
        }
        let mut to_do = active;
        while to_do != 0 {
            let k = 63 - to_do.leading_zeros() as usize;
            to_do &= !(1 << k);
            let (own, mut row) = (&u[k * block.size..][..block.size], y[k]);
            // The rows that this one carries, in runs of neighbours.
            let below = |end: usize| u64::MAX >> (FEW_ROWS - end);
            let mut rest = active & below(self.layout.end(block.start + k) - block.start) & !below(k + 1);
            while rest != 0 {
                let first = rest.trailing_zeros() as usize;
                let run = first..first + (rest >> first).trailing_ones() as usize;
                rest &= !below(run.end);
                for (u, y) in own[run.clone()].iter().zip(&y[run]) {
                    (0..N).for_each(|n| row[n] -= u * y[n]);
                }
            }
            y[k] = row.map(|x| x * inverse[k]);
        }
        active
    }

    /// `Y ← L⁻ᵀ Y` for many columns of one block at once, so that `YᵀY` is the product with `A_b⁻¹` between them; they have the bits that each
    /// has by itself. To be inlined into what is compiled for wide vectors.
    /// - `y`: `[size, stride]`, row by row, of which `width` columns count, whole lanes of [`LANES`]
    ///
    /// # Panics
    /// If the length is another one, lanes are not whole, or the width is more than the stride.
    #[inline(always)]
    pub fn half_solve_rows(&self, block: usize, y: &mut [f64], stride: usize, width: usize) {
        let is_diagonal = self.diagonal[block];
        let block = &self.layout.blocks[block];
        let (n, u) = (block.size, &self.data[block.data_range()]);
        assert!(y.len() == n * stride && width <= stride && width.is_multiple_of(LANES), "rows of whole lanes");
        let (ends, inverse) = (&self.layout.end[block.range()], &self.inverse_diagonal[block.range()]);
        for k in (0..n).rev() {
            let (head, tail) = y.split_at_mut((k + 1) * stride);
            let own = &mut head[k * stride..];
            let carried = if is_diagonal { &[][..] } else { &u[k * n + k + 1..k * n + ends[k] - block.start] };
            let mut first = 0;
            while first < width {
                first += match (width - first) / LANES {
                    1 => half_solve_lanes::<1>(own, tail, carried, first, inverse[k]),
                    2 | 3 => half_solve_lanes::<2>(own, tail, carried, first, inverse[k]),
                    _ => half_solve_lanes::<4>(own, tail, carried, first, inverse[k]),
                };
            }
        }
    }

    /// Whether rows of a block are all those on one way to the root.
    fn is_way(&self, block: &Block, rows: &[usize]) -> bool {
        let mut before = None;
        rows.iter().all(|k| self.layout.previous(block.start + k) == before.replace(block.start + k))
    }

    /// [`inverse_squares`](Self::inverse_squares) for columns in all rows of a block of at most six: a free body or a part of it.
    ///
    /// # Panics
    /// If there is not one row of entries for each of the block.
    pub fn inverse_squares_of_block<const N: usize>(&self, block: usize, entries: &[[f64; N]]) -> [f64; N] {
        assert_eq!(entries.len(), self.layout.blocks[block].size, "one row of entries for each of the block");
        let mut squares = [0.0; N];
        let mut add = |y: &[f64; N]| (0..N).for_each(|n| squares[n] += y[n] * y[n]);
        if self.diagonal[block] {
            let inverse = &self.inverse_diagonal[self.layout.blocks[block].range()];
            entries.iter().zip(inverse).for_each(|(entry, inverse)| add(&entry.map(|x| x * inverse)));
            return squares;
        }
        let mut rows = [[0.0; N]; SMALL];
        let rows = &mut rows[..entries.len()];
        rows.copy_from_slice(entries);
        self.half_solve_block(block, rows);
        rows.iter().for_each(add);
        squares
    }

    /// The diagonal of `Yᵀ A⁻¹ Y` for `N` sparse columns in the same rows, where the factor is diagonal.
    /// - `rows`: of the whole matrix; `entries`: of `Y` in them
    ///
    /// # Panics
    /// If a row is not below the dimension.
    pub fn inverse_squares_if_diagonal<const N: usize>(&self, rows: &[u32], entries: &[[f64; N]]) -> Option<[f64; N]> {
        if !self.all_diagonal {
            return None;
        }
        let mut squares = [0.0; N];
        for (&row, entry) in rows.iter().zip(entries) {
            let inverse = self.inverse_diagonal[row as usize];
            for n in 0..N {
                let y = entry[n] * inverse;
                squares[n] += y * y;
            }
        }
        Some(squares)
    }

    /// `Y ← L⁻ᵀ Y` for `N` sparse columns on the same rows, so that `YᵀY` is the product with `A⁻¹` between them
    /// (the Delassus operator is `J M⁻¹ Jᵀ = (L⁻ᵀJᵀ)ᵀ(L⁻ᵀJᵀ)`).
    /// - `dofs`: sorted, and with every degree of freedom all those before it on its way to the root
    /// - `rows`: the rows of `Y` at `dofs`, `[dofs, N]`
    ///
    /// # Panics
    /// If the two lengths differ.
    pub fn half_solve_sparse<const N: usize>(&self, dofs: &[usize], rows: &mut [[f64; N]]) {
        assert_eq!(dofs.len(), rows.len(), "one row for every degree of freedom");
        for (i, &k) in dofs.iter().enumerate().rev() {
            let block = &self.layout.blocks[self.layout.block_of[k]];
            let u = &self.data[block.offset + (k - block.start) * block.size..][..block.size];
            let (head, tail) = rows.split_at_mut(i + 1);
            let row = &mut head[i];
            let end = self.layout.end(k);
            for (&j, y) in dofs[i + 1..].iter().zip(tail.iter()).take_while(|(j, _)| **j < end) {
                let factor = u[j - block.start];
                for (x, y) in row.iter_mut().zip(y) {
                    *x -= factor * y;
                }
            }
            row.iter_mut().for_each(|y| *y *= self.inverse_diagonal[k]);
        }
    }
}

/// `COUNT` lanes of one row, from column `first` on; how many numbers these are.
#[inline(always)]
fn half_solve_lanes<const COUNT: usize>(
    own: &mut [f64],
    below: &[f64],
    carried: &[f64],
    first: usize,
    inverse: f64,
) -> usize {
    let stride = own.len();
    let own = &mut own[first..][..COUNT * LANES];
    let mut sums = [[0.0; LANES]; COUNT];
    sums.as_flattened_mut().copy_from_slice(own);
    for (factor, row) in carried.iter().zip(below.chunks_exact(stride)) {
        for (sums, row) in sums.iter_mut().zip(row[first..][..COUNT * LANES].as_chunks::<LANES>().0) {
            for lane in 0..LANES {
                sums[lane] -= factor * row[lane];
            }
        }
    }
    sums.as_flattened_mut().iter_mut().for_each(|x| *x *= inverse);
    own.copy_from_slice(sums.as_flattened());
    COUNT * LANES
}

/// `Y ← L⁻ᵀ Y` for the rows of one way to the root, each of which carries all that follow; returns them as bits.
fn half_solve_on_way<const N: usize>(
    u: &[f64],
    inverse: &[f64],
    rows: &[usize],
    entries: &[[f64; N]],
    y: &mut [[f64; N]],
) -> u64 {
    let n = y.len();
    let mut active = 0;
    for (i, (&k, entry)) in rows.iter().zip(entries).enumerate().rev() {
        let (own, mut row) = (&u[k * n..][..n], *entry);
        for &j in &rows[i + 1..] {
            let (u, y) = (own[j], &y[j]);
            (0..N).for_each(|n| row[n] -= u * y[n]);
        }
        y[k] = row.map(|x| x * inverse[k]);
        active |= 1 << k;
    }
    active
}
