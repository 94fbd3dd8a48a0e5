//! Symmetric matrices in diagonal blocks, one per kinematic tree.
//!
//! The mass matrix couples only degrees of freedom of the same tree, so it is stored as one dense block per tree: a free
//! box is one 6 × 6 block. Any symmetric positive definite matrix can be brought in with [`BlockDiagonal::from_dense`].

use std::ops::Range;
use std::sync::Arc;

use crate::dot::dot;
use crate::layout::{Block, Layout};
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

/// A symmetric matrix in dense diagonal blocks, both triangles stored, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockDiagonal {
    layout: Arc<Layout>,
    data: Vec<f64>,
}

impl BlockDiagonal {
    /// A zero matrix with the blocks of a model: one per kinematic tree. (Trees whose degrees of freedom interleave, which
    /// happens only if bodies are not added tree by tree, share a block.)
    pub fn new(model: &Model) -> Self {
        Self::zeros(Layout::of_tree(&model.dof_parent))
    }

    fn zeros(layout: Layout) -> Self {
        Self { data: vec![0.0; layout.entries()], layout: Arc::new(layout) }
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
        let mut out = Self::zeros(Layout::full(&(0..nv).map(reach).collect::<Vec<_>>()));
        for block in &out.layout.blocks {
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

    /// Number of rows.
    pub fn dimension(&self) -> usize {
        self.layout.block_of.len()
    }

    /// The blocks, in order; they cover all rows.
    pub fn blocks(&self) -> &[Block] {
        &self.layout.blocks
    }

    /// Where entries can differ from zero.
    pub(crate) fn layout(&self) -> &Arc<Layout> {
        &self.layout
    }

    /// Index of the block that a degree of freedom belongs to.
    pub fn block_of(&self, dof: usize) -> usize {
        self.layout.block_of[dof]
    }

    /// The blocks that ascending columns lie in: each by its index, with the places of its columns among all of these.
    pub fn blocks_touched<'a>(&'a self, columns: &'a [u32]) -> impl Iterator<Item = (usize, Range<usize>)> + 'a {
        self.layout.blocks_touched(columns)
    }

    /// The row before a row on its way to the root of its tree. A row is coupled with the rows on its way to the root, and with
    /// those that have it on theirs; in a matrix that was given densely it is coupled with its whole block.
    pub fn previous(&self, row: usize) -> Option<usize> {
        self.layout.previous(row)
    }

    /// Entries of a block, row by row, `[size, size]`.
    pub fn block_data(&self, block: usize) -> &[f64] {
        &self.data[self.layout.blocks[block].data_range()]
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
        assert_eq!(self.layout.blocks, other.layout.blocks, "the matrices have different blocks");
        self.data.copy_from_slice(&other.data);
    }

    /// The entry at a row and column; zero outside the blocks.
    pub fn get(&self, row: usize, column: usize) -> f64 {
        let block = self.layout.blocks[self.layout.block_of[row]];
        if block.range().contains(&column) {
            self.data[block.offset + (row - block.start) * block.size + column - block.start]
        } else {
            0.0
        }
    }

    /// Adds to a diagonal entry.
    pub fn add_to_diagonal(&mut self, dof: usize, value: f64) {
        let block = self.layout.blocks[self.layout.block_of[dof]];
        self.data[block.offset + (dof - block.start) * (block.size + 1)] += value;
    }

    /// Adds `factor` times these values to the entries of a row from a column on, which must be in the row's block.
    pub(crate) fn add_to_row(&mut self, row: usize, column: usize, factor: f64, values: &[f64]) {
        let block = self.layout.blocks[self.layout.block_of[row]];
        let first = block.offset + (row - block.start) * block.size + column - block.start;
        self.data[first..].iter_mut().zip(values).for_each(|(entry, x)| *entry += factor * x);
    }

    /// Takes the entries above a block's diagonal from those below it.
    pub(crate) fn mirror_lower(&mut self, block: usize) {
        let Self { layout, data } = self;
        let block = layout.blocks[block];
        let (n, data) = (block.size, &mut data[block.data_range()]);
        for row in 0..n {
            let mut next = layout.previous(block.start + row);
            while let Some(last) = next {
                let first = layout.run_start(last);
                for column in first - block.start..=last - block.start {
                    data[column * n + row] = data[row * n + column];
                }
                next = layout.previous(first);
            }
        }
    }

    /// A block and its entries.
    pub(crate) fn block_mut(&mut self, block: usize) -> (Block, &mut [f64]) {
        let block = self.layout.blocks[block];
        (block, &mut self.data[block.data_range()])
    }

    /// The largest entry on the diagonal; 0 without rows. No other entry of a positive definite matrix exceeds it.
    pub fn largest_diagonal(&self) -> f64 {
        (0..self.blocks().len()).fold(0.0, |largest, block| self.largest_in_block(block).max(largest))
    }

    /// The largest entry of a block, which is on its diagonal as the matrix is positive definite.
    pub fn largest_in_block(&self, block: usize) -> f64 {
        let block = self.layout.blocks[block];
        let entries = &self.data[block.data_range()];
        entries
            .iter()
            .step_by(block.size + 1)
            .fold(0.0, |largest, &entry| if entry > largest { entry } else { largest })
    }

    /// All entries row by row, `[nv, nv]`.
    pub fn to_dense(&self) -> Vec<f64> {
        let n = self.dimension();
        let mut dense = vec![0.0; n * n];
        for block in &self.layout.blocks {
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
        if self.data.len() == x.len() {
            // Every block is a number.
            return out.iter_mut().zip(x).zip(&self.data).for_each(|((out, x), a)| *out = a * x);
        }
        for block in &self.layout.blocks {
            let (rows, x, out) = (&self.data[block.data_range()], &x[block.range()], &mut out[block.range()]);
            match block.size {
                1 => out[0] = rows[0] * x[0],
                3 => multiply_small::<3>(rows, x, out),
                6 => multiply_small::<6>(rows, x, out),
                size => rows.chunks_exact(size).zip(out).for_each(|(row, out)| *out = dot(row, x)),
            }
        }
    }

    pub(crate) fn data_of(&self, block: &Block) -> &[f64] {
        &self.data[block.data_range()]
    }
}

/// `A x` for a block of `N` rows: a free body or a part of it, with the same sums as in other blocks.
fn multiply_small<const N: usize>(rows: &[f64], x: &[f64], out: &mut [f64]) {
    if let Ok(x) = <&[f64; N]>::try_from(x) {
        rows.as_chunks::<N>().0.iter().zip(out).for_each(|(row, out)| *out = dot(row, x));
    }
}
