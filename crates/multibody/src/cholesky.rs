//! Factorisation of block-diagonal matrices along kinematic trees.

use crate::mass::{Block, BlockDiagonal, MassError};

/// The factor `L` of `A = Lᵀ L` of a [`BlockDiagonal`], lower triangular.
///
/// Factorised from the last degree of freedom to the first, `L` has no entries where two degrees of freedom are not on one
/// path to the root, so branches do not fill in and a right-hand side that lives on paths to the root stays there.
///
/// # Source
/// Featherstone (2008), Rigid Body Dynamics Algorithms, ch. 6.5 (`LTL` factorisation).
#[derive(Clone, Debug)]
pub struct BlockCholesky {
    blocks: Vec<Block>,
    block_of: Vec<usize>,
    /// Lower triangles in dense row-major blocks.
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
    /// If the matrix has other blocks.
    pub fn refactor(&mut self, matrix: &BlockDiagonal) -> Result<(), MassError> {
        assert_eq!(self.blocks, matrix.blocks(), "the factor was made for another matrix");
        for block in &self.blocks {
            let l = &mut self.data[block.data_range()];
            let a = matrix.data_of(block);
            l.copy_from_slice(a);
            factor_block(l, block, |k| a[k * (block.size + 1)], &mut self.inverse_diagonal[block.range()])?;
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
        let (block, n) = (&self.blocks[block], self.blocks[block].size);
        assert_eq!(x.len(), n, "length must be the block's size");
        let l = &self.data[block.data_range()];
        let inverse = &self.inverse_diagonal[block.range()];
        for k in (0..n).rev() {
            let (head, tail) = x.split_at_mut(k);
            tail[0] *= inverse[k];
            for (x, l) in head.iter_mut().zip(&l[k * n..]) {
                *x -= l * tail[0];
            }
        }
        for k in 0..n {
            let (head, tail) = x.split_at_mut(k);
            let sum: f64 = head.iter().zip(&l[k * n..]).map(|(x, l)| x * l).sum();
            tail[0] = (tail[0] - sum) * inverse[k];
        }
    }

    /// `Y ← L⁻ᵀ Y` for `N` columns of one block, so that `YᵀY` is the product with `A_b⁻¹` between them.
    /// - `rows`: the first rows of `Y`, `[at most size, N]`; those after them are zero and stay zero
    ///
    /// # Panics
    /// If there are more rows than the block has.
    pub fn half_solve_block<const N: usize>(&self, block: usize, rows: &mut [[f64; N]]) {
        let block = &self.blocks[block];
        assert!(rows.len() <= block.size, "no more rows than the block has");
        let (l, inverse) = (&self.data[block.data_range()], &self.inverse_diagonal[block.range()]);
        for k in (0..rows.len()).rev() {
            let (head, tail) = rows.split_at_mut(k);
            let row = &mut tail[0];
            if *row == [0.0; N] {
                continue; // the rows of other branches of the tree
            }
            row.iter_mut().for_each(|y| *y *= inverse[k]);
            for (target, l) in head.iter_mut().zip(&l[k * block.size..]) {
                for (t, y) in target.iter_mut().zip(row.iter()) {
                    *t -= l * y;
                }
            }
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
        for i in (0..dofs.len()).rev() {
            let k = dofs[i];
            let block = &self.blocks[self.block_of[k]];
            let l = &self.data[block.offset + (k - block.start) * block.size..][..block.size];
            let (head, tail) = rows.split_at_mut(i);
            let row = &mut tail[0];
            row.iter_mut().for_each(|y| *y *= self.inverse_diagonal[k]);
            for (&j, target) in dofs[..i].iter().zip(head).rev() {
                if j < block.start {
                    break;
                }
                let factor = l[j - block.start];
                for (t, y) in target.iter_mut().zip(row.iter()) {
                    *t -= factor * y;
                }
            }
        }
    }
}

/// `A ← L` with `A = Lᵀ L`, on one dense row-major block whose lower triangle is read and overwritten.
/// - `diagonal`: the diagonal of `A`
fn factor_block(
    a: &mut [f64],
    block: &Block,
    diagonal: impl Fn(usize) -> f64,
    inverse: &mut [f64],
) -> Result<(), MassError> {
    let n = block.size;
    for k in (0..n).rev() {
        let (above, row) = a.split_at_mut(k * n);
        let pivot = row[k];
        // What is left of the diagonal after elimination has an error of some roundings of the original entry.
        if !(pivot > 4.0 * n as f64 * f64::EPSILON * diagonal(k) && pivot.is_finite()) {
            return Err(MassError::NotPositiveDefinite { dof: block.start + k, pivot });
        }
        let root = pivot.sqrt();
        (row[k], inverse[k]) = (root, 1.0 / root);
        for x in &mut row[..k] {
            *x *= inverse[k];
        }
        for i in 0..k {
            let factor = row[i];
            // Zero where i is not on k's way to the root.
            if factor != 0.0 {
                for (x, y) in above[i * n..i * n + i + 1].iter_mut().zip(&row[..=i]) {
                    *x -= factor * y;
                }
            }
        }
    }
    Ok(())
}
