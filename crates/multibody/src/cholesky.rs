//! Factorisation of block-diagonal matrices along kinematic trees.

use crate::mass::{Block, BlockDiagonal, Coupling, MassError};

/// The factor `L` of `A = Lᵀ L` of a [`BlockDiagonal`], lower triangular.
///
/// Factorised from the last degree of freedom to the first, `L` has no entries where two degrees of freedom are not on one
/// path to the root, so branches do not fill in and a right-hand side that lives on paths to the root stays there.
///
/// # Source
/// Featherstone (2008), Rigid Body Dynamics Algorithms, ch. 6.5 (`LTL` factorisation), with the loops in the order in which
/// each entry is finished at once: all sums then run along a row of `Lᵀ` over the degrees of freedom that a joint carries.
#[derive(Clone, Debug)]
pub struct BlockCholesky {
    blocks: Vec<Block>,
    block_of: Vec<usize>,
    coupling: Coupling,
    /// `Lᵀ`: upper triangles in dense row-major blocks.
    data: Vec<f64>,
    inverse_diagonal: Vec<f64>,
}

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
            blocks: matrix.blocks().to_vec(),
            block_of: (0..matrix.dimension()).map(|k| matrix.block_of(k)).collect(),
            coupling: matrix.coupling().clone(),
            data,
            inverse_diagonal: vec![1.0; matrix.dimension()],
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
        let same = self.blocks == matrix.blocks() && self.coupling == *matrix.coupling();
        assert!(same, "the factor was made for another matrix");
        for block in &self.blocks {
            let u = &mut self.data[block.data_range()];
            let inverse = &mut self.inverse_diagonal[block.range()];
            factor_block(matrix.data_of(block), block, &self.coupling, u, inverse)?;
        }
        Ok(())
    }

    /// The blocks of the factorised matrix.
    pub fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// `x ← A⁻¹ x`, `[nv]`.
    ///
    /// # Panics
    /// If the length is not the dimension.
    pub fn solve_in_place(&self, x: &mut [f64]) {
        assert_eq!(x.len(), self.block_of.len(), "length must be the dimension");
        for b in 0..self.blocks.len() {
            self.solve_block_in_place(b, &mut x[self.blocks[b].range()]);
        }
    }

    /// `x ← A_b⁻¹ x` for one block, `[size]`.
    ///
    /// # Panics
    /// If the length is not the block's size.
    pub fn solve_block_in_place(&self, block: usize, x: &mut [f64]) {
        match self.blocks[block].size {
            1 => return self.solve_small::<1>(block, x),
            3 => return self.solve_small::<3>(block, x),
            6 => return self.solve_small::<6>(block, x),
            _ => self.half_solve_block_in_place(block, x),
        }
        let (block, n) = (&self.blocks[block], self.blocks[block].size);
        let u = &self.data[block.data_range()];
        let inverse = &self.inverse_diagonal[block.range()];
        let carried = |k: usize| k + 1..self.coupling.end(block.start + k) - block.start;
        for k in 0..n {
            let row = &u[k * n..(k + 1) * n];
            x[k] *= inverse[k];
            let factor = x[k];
            for (x, u) in x[carried(k)].iter_mut().zip(&row[carried(k)]) {
                *x -= u * factor;
            }
        }
    }

    /// The same for a block of `N` rows: a part of a free body or all of it. Entries that its coupling lacks are zero.
    fn solve_small<const N: usize>(&self, block: usize, x: &mut [f64]) {
        let block = &self.blocks[block];
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

    /// The first half of [`solve_block_in_place`](Self::solve_block_in_place), `x ← L⁻ᵀ x` within one block, so that `xᵀx` is
    /// `xᵀA⁻¹x` of before.
    ///
    /// # Panics
    /// If the length is not the block's size.
    pub fn half_solve_block_in_place(&self, block: usize, x: &mut [f64]) {
        let (block, n) = (&self.blocks[block], self.blocks[block].size);
        assert_eq!(x.len(), n, "length must be the block's size");
        let u = &self.data[block.data_range()];
        let inverse = &self.inverse_diagonal[block.range()];
        for k in (0..n).rev() {
            let carried = k + 1..self.coupling.end(block.start + k) - block.start;
            x[k] = (x[k] - dot(&u[k * n..(k + 1) * n][carried.clone()], &x[carried])) * inverse[k];
        }
    }

    /// `Y ← L⁻ᵀ Y` for `N` columns of one block, so that `YᵀY` is the product with `A_b⁻¹` between them.
    /// - `rows`: the first rows of `Y`, `[at most size, N]`; those after them are zero and stay zero
    ///
    /// # Panics
    /// If there are more rows than the block has.
    pub fn half_solve_block<const N: usize>(&self, block: usize, rows: &mut [[f64; N]]) {
        match (self.blocks[block].size, rows.len()) {
            (1, 1) => return self.half_solve_small::<1, N>(block, rows),
            (3, 3) => return self.half_solve_small::<3, N>(block, rows),
            (6, 6) => return self.half_solve_small::<6, N>(block, rows),
            (size, count) => assert!(count <= size, "no more rows than the block has"),
        }
        let block = &self.blocks[block];
        let (u, inverse) = (&self.data[block.data_range()], &self.inverse_diagonal[block.range()]);
        for k in (0..rows.len()).rev() {
            let end = (self.coupling.end(block.start + k) - block.start).min(rows.len());
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
        let block = &self.blocks[block];
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
            let block = &self.blocks[self.block_of[k]];
            let u = &self.data[block.offset + (k - block.start) * block.size..][..block.size];
            let (head, tail) = rows.split_at_mut(i + 1);
            let row = &mut head[i];
            let end = self.coupling.end(k);
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

/// `U` with `A = U Uᵀ` of one dense row-major block; below the diagonal of `U` nothing is read or written.
fn factor_block(
    a: &[f64],
    block: &Block,
    coupling: &Coupling,
    u: &mut [f64],
    inverse: &mut [f64],
) -> Result<(), MassError> {
    let n = block.size;
    for k in (0..n).rev() {
        let carried = k + 1..coupling.end(block.start + k) - block.start;
        let (above, row) = u.split_at_mut(k * n);
        let carried_row = &row[carried.clone()];
        let diagonal = a[k * (n + 1)];
        let pivot = diagonal - dot(carried_row, carried_row);
        // What is left of the diagonal after elimination has an error of some roundings of the original entry.
        if !(pivot > 4.0 * n as f64 * f64::EPSILON * diagonal && pivot.is_finite()) {
            return Err(MassError::NotPositiveDefinite { dof: block.start + k, pivot });
        }
        let root = pivot.sqrt();
        inverse[k] = 1.0 / root;
        for i in coupling.ancestors(block.start + k) {
            let i = i - block.start;
            let target = &mut above[i * n..(i + 1) * n];
            target[k] = (a[i * n + k] - dot(&target[carried.clone()], carried_row)) * inverse[k];
        }
        row[k] = root;
    }
    Ok(())
}

/// The scalar product, in four sums so that an addition does not wait for the one before it.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (head_a, head_b) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest = head_a.remainder().iter().zip(head_b.remainder()).map(|(a, b)| a * b).sum::<f64>();
    for (a, b) in head_a.zip(head_b) {
        for i in 0..4 {
            sums[i] += a[i] * b[i];
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}
