//! Symmetric matrices in diagonal blocks, one per kinematic tree, and their factorisation.
//!
//! The mass matrix couples only degrees of freedom of the same tree, so it is stored as one dense block per tree: a free
//! box is one 6 × 6 block. Any symmetric positive definite matrix can be brought in with [`BlockDiagonal::from_dense`].

use crate::model::Model;

/// What is wrong with a mass matrix.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MassError {
    /// The matrix has a direction without inertia.
    #[error(
        "the mass matrix is not positive definite: pivot {pivot} at degree of freedom {dof}; \
         give what moves there an inertia or its joint an armature, and check the state for numbers that are not finite"
    )]
    NotPositiveDefinite {
        /// Degree of freedom at which the factorisation stopped.
        dof: usize,
        /// The pivot found there, which should be positive.
        pivot: f64,
    },
    /// A dense matrix with the wrong number of entries.
    #[error("a matrix over {nv} degrees of freedom has {expected} entries, found {found}")]
    WrongLength {
        /// Degrees of freedom.
        nv: usize,
        /// `nv²`.
        expected: usize,
        /// Entries given.
        found: usize,
    },
    /// A dense matrix whose two triangles differ, or that holds a number that is not finite.
    #[error(
        "entries ({row}, {column}) and ({column}, {row}) of the mass matrix are {upper} and {lower}: they must be equal and finite"
    )]
    NotSymmetric {
        /// Row of the upper entry.
        row: usize,
        /// Column of the upper entry.
        column: usize,
        /// Upper entry.
        upper: f64,
        /// Lower entry.
        lower: f64,
    },
}

/// A dense block on the diagonal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Block {
    /// First degree of freedom.
    pub start: usize,
    /// Number of degrees of freedom.
    pub size: usize,
    /// Where its entries begin in the matrix's data.
    pub offset: usize,
}

impl Block {
    /// The degrees of freedom it covers.
    pub fn range(&self) -> std::ops::Range<usize> {
        self.start..self.start + self.size
    }

    fn data_range(&self) -> std::ops::Range<usize> {
        self.offset..self.offset + self.size * self.size
    }
}

/// A symmetric matrix in dense diagonal blocks, both triangles stored, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockDiagonal {
    blocks: Vec<Block>,
    /// For every degree of freedom its block.
    block_of: Vec<usize>,
    data: Vec<f64>,
}

impl BlockDiagonal {
    /// A zero matrix with the blocks of a model: one per kinematic tree. (Trees whose degrees of freedom interleave, which
    /// happens only if bodies are not added tree by tree, share a block.)
    pub fn new(model: &Model) -> Self {
        Self::with_reach(&(0..model.nv).map(|k| model.dof_parent[k].unwrap_or(k)).collect::<Vec<_>>())
    }

    /// A symmetric matrix given row by row, cut into the smallest blocks of consecutive indices that hold all its
    /// entries that are not zero.
    ///
    /// # Errors
    /// [`MassError::WrongLength`] unless there are `nv²` entries; [`MassError::NotSymmetric`] if the triangles differ by
    /// more than rounding (1e-12 of the larger of the two diagonal entries) or an entry is not finite.
    pub fn from_dense(nv: usize, dense: &[f64]) -> Result<Self, MassError> {
        if dense.len() != nv * nv {
            return Err(MassError::WrongLength { nv, expected: nv * nv, found: dense.len() });
        }
        for row in 0..nv {
            for column in row..nv {
                let (upper, lower) = (dense[row * nv + column], dense[column * nv + row]);
                let scale = dense[row * nv + row].abs().max(dense[column * nv + column].abs());
                let equal = (upper - lower).abs() <= 1e-12 * scale;
                if !equal || !upper.is_finite() || !lower.is_finite() {
                    return Err(MassError::NotSymmetric { row, column, upper, lower });
                }
            }
        }
        let reach = |i: usize| (0..=i).find(|&j| dense[i * nv + j] != 0.0).unwrap_or(i);
        let mut out = Self::with_reach(&(0..nv).map(reach).collect::<Vec<_>>());
        for block in &out.blocks {
            for i in 0..block.size {
                for j in 0..block.size {
                    let (row, column) = (block.start + i, block.start + j);
                    let (low, high) = (row.max(column), row.min(column));
                    out.data[block.offset + i * block.size + j] = dense[low * nv + high];
                }
            }
        }
        Ok(out)
    }

    /// Zero matrix whose row `i` has entries from column `reach[i]` on.
    fn with_reach(reach: &[usize]) -> Self {
        let n = reach.len();
        let mut blocks = Vec::new();
        let mut block_of = vec![0; n];
        let mut entries = 0;
        // Going up from the last row, a block ends where no row below reaches further up.
        let mut end = n;
        let mut top = n;
        for i in (0..n).rev() {
            top = top.min(reach[i]).min(i);
            if top == i {
                blocks.push(Block { start: i, size: end - i, offset: 0 });
                end = i;
            }
        }
        blocks.reverse();
        for (b, block) in blocks.iter_mut().enumerate() {
            block.offset = entries;
            entries += block.size * block.size;
            block_of[block.range()].fill(b);
        }
        Self { blocks, block_of, data: vec![0.0; entries] }
    }

    /// Number of rows.
    pub fn dimension(&self) -> usize {
        self.block_of.len()
    }

    /// The blocks, in order; they cover all rows.
    pub fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// Index of the block that a degree of freedom belongs to.
    pub fn block_of(&self, dof: usize) -> usize {
        self.block_of[dof]
    }

    /// Entries of a block, row by row, `[size, size]`.
    pub fn block_data(&self, block: usize) -> &[f64] {
        &self.data[self.blocks[block].data_range()]
    }

    /// Entries of all blocks, one block after another.
    pub fn data(&self) -> &[f64] {
        &self.data
    }

    /// Sets every entry to zero.
    pub fn set_zero(&mut self) {
        self.data.fill(0.0);
    }

    /// The entry at a row and column; zero outside the blocks.
    pub fn get(&self, row: usize, column: usize) -> f64 {
        let block = self.blocks[self.block_of[row]];
        if block.range().contains(&column) {
            self.data[block.offset + (row - block.start) * block.size + column - block.start]
        } else {
            0.0
        }
    }

    /// Adds to a diagonal entry.
    pub fn add_to_diagonal(&mut self, dof: usize, value: f64) {
        let block = self.blocks[self.block_of[dof]];
        self.data[block.offset + (dof - block.start) * (block.size + 1)] += value;
    }

    /// Sets the entries at (row, column) and (column, row), which must be in one block.
    pub(crate) fn set(&mut self, row: usize, column: usize, value: f64) {
        let block = self.blocks[self.block_of[row]];
        let (i, j) = (row - block.start, column - block.start);
        self.data[block.offset + i * block.size + j] = value;
        self.data[block.offset + j * block.size + i] = value;
    }

    /// All entries row by row, `[nv, nv]`.
    pub fn to_dense(&self) -> Vec<f64> {
        let n = self.dimension();
        let mut dense = vec![0.0; n * n];
        for block in &self.blocks {
            for i in 0..block.size {
                let row = &self.data[block.offset + i * block.size..][..block.size];
                dense[(block.start + i) * n + block.start..][..block.size].copy_from_slice(row);
            }
        }
        dense
    }

    /// `out = A x`, both `[nv]`.
    ///
    /// # Panics
    /// If a length is not the dimension.
    pub fn multiply_into(&self, x: &[f64], out: &mut [f64]) {
        assert!(x.len() == self.dimension() && out.len() == self.dimension(), "lengths must be the dimension");
        for block in &self.blocks {
            let x = &x[block.range()];
            for (row, out) in self.data[block.data_range()].chunks_exact(block.size).zip(&mut out[block.range()]) {
                *out = row.iter().zip(x).map(|(a, x)| a * x).sum();
            }
        }
    }

    /// Factorises the matrix; [`BlockCholesky::refactor`] does the same without allocation.
    ///
    /// # Errors
    /// [`MassError::NotPositiveDefinite`].
    pub fn factor(&self) -> Result<BlockCholesky, MassError> {
        let mut factor = BlockCholesky::new(self);
        factor.refactor(self)?;
        Ok(factor)
    }

    pub(crate) fn data_of(&self, block: &Block) -> &[f64] {
        &self.data[block.data_range()]
    }
}

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
        let mut data = vec![0.0; matrix.data.len()];
        for block in &matrix.blocks {
            for i in 0..block.size {
                data[block.offset + i * (block.size + 1)] = 1.0;
            }
        }
        Self {
            blocks: matrix.blocks.clone(),
            block_of: matrix.block_of.clone(),
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
        assert_eq!(self.blocks, matrix.blocks, "the factor was made for another matrix");
        for block in &self.blocks {
            let l = &mut self.data[block.data_range()];
            l.copy_from_slice(matrix.data_of(block));
            factor_block(l, block, &mut self.inverse_diagonal[block.range()])?;
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
fn factor_block(a: &mut [f64], block: &Block, inverse: &mut [f64]) -> Result<(), MassError> {
    let n = block.size;
    for k in (0..n).rev() {
        let (above, row) = a.split_at_mut(k * n);
        let pivot = row[k];
        if !(pivot > 0.0 && pivot.is_finite()) {
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
