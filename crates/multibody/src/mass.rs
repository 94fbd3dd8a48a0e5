//! Block-diagonal symmetric matrices: the mass matrix has one dense block per kinematic tree.

/// A symmetric matrix of dense square blocks along the diagonal.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BlockDiagonal {
    blocks: Vec<Block>,
    data: Vec<f64>,
    size: usize,
}

/// Where a block lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Block {
    /// First row and column.
    pub start: usize,
    /// Number of rows.
    pub size: usize,
    /// First entry in the data, row-major.
    pub offset: usize,
}

impl BlockDiagonal {
    /// Zero blocks of the given sizes.
    pub fn zeros(sizes: impl IntoIterator<Item = usize>) -> Self {
        let mut matrix = Self::default();
        let mut offset = 0;
        for size in sizes {
            matrix.blocks.push(Block { start: matrix.size, size, offset });
            matrix.size += size;
            offset += size * size;
        }
        matrix.data = vec![0.0; offset];
        matrix
    }

    /// Number of rows.
    pub fn size(&self) -> usize {
        self.size
    }

    /// The blocks in order.
    pub fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// Entries of a block, row-major.
    pub fn block(&self, block: Block) -> &[f64] {
        &self.data[block.offset..block.offset + block.size * block.size]
    }

    /// Entries of a block, row-major.
    pub fn block_mut(&mut self, block: Block) -> &mut [f64] {
        &mut self.data[block.offset..block.offset + block.size * block.size]
    }

    /// `y = A x`.
    pub fn multiply_into(&self, x: &[f64], y: &mut [f64]) {
        for &b in &self.blocks {
            let (a, x) = (self.block(b), &x[b.start..b.start + b.size]);
            for (i, y) in y[b.start..b.start + b.size].iter_mut().enumerate() {
                *y = a[i * b.size..(i + 1) * b.size].iter().zip(x).map(|(a, x)| a * x).sum();
            }
        }
    }
}

/// Cholesky factor `A = L Lᵀ` of a [`BlockDiagonal`], block by block.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BlockCholesky {
    lower: BlockDiagonal,
}

/// The matrix is not positive definite.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the matrix is not positive definite at row {dof}")]
pub struct NotPositiveDefinite {
    /// Row of the failing pivot.
    pub dof: usize,
}

impl BlockCholesky {
    /// Factorises; memory is reused when the blocks are the same as before.
    ///
    /// # Errors
    /// [`NotPositiveDefinite`] with the failing row.
    pub fn factor(&mut self, a: &BlockDiagonal) -> Result<(), NotPositiveDefinite> {
        self.lower.clone_from(a);
        for k in 0..self.lower.blocks.len() {
            let b = self.lower.blocks[k];
            let n = b.size;
            let l = self.lower.block_mut(b);
            for j in 0..n {
                let mut d = l[j * n + j];
                for k in 0..j {
                    d -= l[j * n + k] * l[j * n + k];
                }
                if d.is_nan() || d <= 0.0 {
                    return Err(NotPositiveDefinite { dof: b.start + j });
                }
                let d = d.sqrt();
                l[j * n + j] = d;
                for i in j + 1..n {
                    let mut s = l[i * n + j];
                    for k in 0..j {
                        s -= l[i * n + k] * l[j * n + k];
                    }
                    l[i * n + j] = s / d;
                }
            }
        }
        Ok(())
    }

    /// Overwrites `x` with `A⁻¹ x`.
    pub fn solve_in_place(&self, x: &mut [f64]) {
        for k in 0..self.lower.blocks.len() {
            let b = self.lower.blocks[k];
            self.solve_block_in_place(k, &mut x[b.start..b.start + b.size]);
        }
    }

    /// Overwrites `x` with `A_k⁻¹ x` for block `k` alone.
    pub fn solve_block_in_place(&self, k: usize, x: &mut [f64]) {
        let b = self.lower.blocks[k];
        let (n, l) = (b.size, self.lower.block(b));
        for i in 0..n {
            for k in 0..i {
                x[i] -= l[i * n + k] * x[k];
            }
            x[i] /= l[i * n + i];
        }
        for i in (0..n).rev() {
            for k in i + 1..n {
                x[i] -= l[k * n + i] * x[k];
            }
            x[i] /= l[i * n + i];
        }
    }
}
