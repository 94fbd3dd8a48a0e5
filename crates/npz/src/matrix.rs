//! Dense and sparse matrices, as files hold them.

use crate::error::MemberProblem;

/// [`SparseMatrix::to_dense`] refuses more entries than this (2 GiB of `f64`).
pub const MAX_DENSE_ENTRIES: usize = 1 << 28;

/// A matrix in either storage.
#[derive(Debug, Clone, PartialEq)]
pub enum StoredMatrix {
    /// All entries.
    Dense(DenseMatrix),
    /// Entries that may differ from zero.
    Sparse(SparseMatrix),
}

impl StoredMatrix {
    /// Number of rows and columns.
    pub fn shape(&self) -> (usize, usize) {
        match self {
            Self::Dense(x) => (x.rows, x.cols),
            Self::Sparse(x) => (x.rows, x.cols),
        }
    }

    /// All entries.
    ///
    /// # Errors
    /// [`MemberProblem::TooLarge`] above [`MAX_DENSE_ENTRIES`].
    pub fn to_dense(&self) -> Result<DenseMatrix, MemberProblem> {
        match self {
            Self::Dense(x) => Ok(x.clone()),
            Self::Sparse(x) => x.to_dense(),
        }
    }
}

/// A dense matrix, row after row.
#[derive(Debug, Clone, PartialEq)]
pub struct DenseMatrix {
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub cols: usize,
    /// `values[i * cols + j]` is the entry in row i, column j.
    pub values: Vec<f64>,
}

impl DenseMatrix {
    /// Entry in row `i`, column `j`.
    ///
    /// # Panics
    /// When `i` or `j` is outside the matrix.
    pub fn get(&self, i: usize, j: usize) -> f64 {
        assert!(i < self.rows && j < self.cols, "entry ({i}, {j}) of {}x{}", self.rows, self.cols);
        self.values[i * self.cols + j]
    }
}

/// A matrix in compressed sparse row form (CSR).
///
/// Row i holds `values[indptr[i]..indptr[i+1]]` in the columns `indices[indptr[i]..indptr[i+1]]`.
/// Columns of a row may come in any order; entries of the same place add up.
#[derive(Debug, Clone, PartialEq)]
pub struct SparseMatrix {
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub cols: usize,
    /// Where each row starts; `rows + 1` values, the last is the number of entries.
    pub indptr: Vec<usize>,
    /// Column of each entry.
    pub indices: Vec<usize>,
    /// Value of each entry.
    pub values: Vec<f64>,
}

impl SparseMatrix {
    /// Checks the lengths, that `indptr` ascends from 0 to the number of entries, and that every
    /// column is inside the matrix.
    ///
    /// # Errors
    /// [`MemberProblem::Csr`] with the first violation.
    pub fn validate(&self) -> Result<(), MemberProblem> {
        let bad = |problem, index| Err(MemberProblem::Csr { problem, index });
        if self.rows.checked_add(1) != Some(self.indptr.len()) {
            return bad("indptr must have one value more than rows", self.indptr.len());
        }
        if self.indices.len() != self.values.len() {
            return bad("indices and data differ in length", self.indices.len());
        }
        if self.indptr[0] != 0 {
            return bad("indptr must start at 0", 0);
        }
        if let Some(i) = (1..self.indptr.len()).find(|&i| self.indptr[i] < self.indptr[i - 1]) {
            return bad("indptr must not descend", i);
        }
        if self.indptr[self.rows] != self.values.len() {
            return bad("indptr must end at the number of entries", self.rows);
        }
        match self.indices.iter().position(|&column| column >= self.cols) {
            Some(index) => bad("a column index is outside the matrix", index),
            None => Ok(()),
        }
    }

    /// All entries.
    ///
    /// # Errors
    /// [`MemberProblem::TooLarge`] above [`MAX_DENSE_ENTRIES`], [`MemberProblem::Csr`] when
    /// [`SparseMatrix::validate`] fails.
    pub fn to_dense(&self) -> Result<DenseMatrix, MemberProblem> {
        self.validate()?;
        let entries = self.rows.checked_mul(self.cols).filter(|&n| n <= MAX_DENSE_ENTRIES);
        let Some(entries) = entries else {
            return Err(MemberProblem::TooLarge { shape: vec![self.rows, self.cols] });
        };
        let mut values = vec![0.0; entries];
        for i in 0..self.rows {
            for k in self.indptr[i]..self.indptr[i + 1] {
                values[i * self.cols + self.indices[k]] += self.values[k];
            }
        }
        Ok(DenseMatrix { rows: self.rows, cols: self.cols, values })
    }
}
