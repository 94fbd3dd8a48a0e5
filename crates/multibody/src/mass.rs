//! Symmetric matrices in diagonal blocks, one per kinematic tree.
//!
//! The mass matrix couples only degrees of freedom of the same tree, so it is stored as one dense block per tree: a free
//! box is one 6 × 6 block. Any symmetric positive definite matrix can be brought in with [`BlockDiagonal::from_dense`].

use crate::cholesky::BlockCholesky;
use crate::model::Model;

/// What is wrong with a mass matrix.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MassError {
    /// The matrix has a direction without inertia (none but rounding is left of it in the factorisation).
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

    pub(crate) fn data_range(&self) -> std::ops::Range<usize> {
        self.offset..self.offset + self.size * self.size
    }
}

/// Which rows a row is coupled with: those on its way to the root and those that have it on theirs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Coupling {
    /// The next row on the way to the root.
    previous: Vec<Option<usize>>,
    /// One after the last row that has this one on its way to the root, or after the row itself.
    end: Vec<usize>,
}

impl Coupling {
    /// Every row of a block with every other.
    fn full(blocks: &[Block]) -> Self {
        let rows = || blocks.iter().flat_map(|block| block.range().map(move |k| (k, block)));
        Self {
            previous: rows().map(|(k, block)| k.checked_sub(1).filter(|&p| p >= block.start)).collect(),
            end: rows().map(|(_, block)| block.start + block.size).collect(),
        }
    }

    fn of_tree(dof_parent: &[Option<usize>]) -> Self {
        let mut end: Vec<usize> = (1..=dof_parent.len()).collect();
        for k in (0..end.len()).rev() {
            if let Some(parent) = dof_parent[k] {
                end[parent] = end[parent].max(end[k]);
            }
        }
        Self { previous: dof_parent.to_vec(), end }
    }

    /// The rows on the way from row `k` to the root, without `k`.
    pub fn ancestors(&self, k: usize) -> impl Iterator<Item = usize> + '_ {
        std::iter::successors(self.previous[k], |&i| self.previous[i])
    }

    /// One after the last row that is coupled with row `k`.
    pub fn end(&self, k: usize) -> usize {
        self.end[k]
    }
}

/// A symmetric matrix in dense diagonal blocks, both triangles stored, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockDiagonal {
    coupling: Coupling,
    blocks: Vec<Block>,
    /// For every degree of freedom its block.
    block_of: Vec<usize>,
    data: Vec<f64>,
}

impl BlockDiagonal {
    /// A zero matrix with the blocks of a model: one per kinematic tree. (Trees whose degrees of freedom interleave, which
    /// happens only if bodies are not added tree by tree, share a block.)
    pub fn new(model: &Model) -> Self {
        let mut matrix = Self::with_reach(&(0..model.nv).map(|k| model.dof_parent[k].unwrap_or(k)).collect::<Vec<_>>());
        matrix.coupling = Coupling::of_tree(&model.dof_parent);
        matrix
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
        Self { coupling: Coupling::full(&blocks), blocks, block_of, data: vec![0.0; entries] }
    }

    /// Number of rows.
    pub fn dimension(&self) -> usize {
        self.block_of.len()
    }

    /// The blocks, in order; they cover all rows.
    pub fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// Where entries can differ from zero.
    pub(crate) fn coupling(&self) -> &Coupling {
        &self.coupling
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

    /// Takes over the entries of a matrix with the same blocks, without allocation.
    ///
    /// # Panics
    /// If the blocks differ.
    pub fn copy_from(&mut self, other: &Self) {
        assert_eq!(self.blocks, other.blocks, "the matrices have different blocks");
        self.data.copy_from_slice(&other.data);
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

    /// Adds to the entries at (row, column) and (column, row), which must be in one block and not on the diagonal.
    pub(crate) fn add_off_diagonal(&mut self, row: usize, column: usize, value: f64) {
        let block = self.blocks[self.block_of[row]];
        let (i, j) = (row - block.start, column - block.start);
        self.data[block.offset + i * block.size + j] += value;
        self.data[block.offset + j * block.size + i] += value;
    }

    /// A block and its entries.
    pub(crate) fn block_mut(&mut self, block: usize) -> (Block, &mut [f64]) {
        let block = self.blocks[block];
        (block, &mut self.data[block.data_range()])
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
