//! Matrices and errors of problem files.

use signorini_complementarity::Matrix;
use signorini_npz::{Archive, SparseMatrix};

use crate::ProblemError;

/// Adds the file to an error that does not name it.
pub(super) fn in_file(archive: &Archive, error: ProblemError) -> ProblemError {
    match error {
        ProblemError::Archive(_) | ProblemError::File { .. } | ProblemError::InFile { .. } => error,
        _ => ProblemError::InFile { path: archive.file().to_owned(), error: Box::new(error) },
    }
}

pub(super) fn fault(archive: &Archive, reason: String) -> ProblemError {
    ProblemError::File { path: archive.file().to_owned(), reason }
}

pub(super) fn dense(archive: &Archive, name: &str) -> Result<Matrix, ProblemError> {
    let matrix = archive.matrix(name)?.to_dense().map_err(|e| fault(archive, format!("{name}: {e}")))?;
    Ok(Matrix::new(matrix.rows, matrix.cols, matrix.values)?)
}

/// The rows of a matrix in either storage, as (column, value) pairs in ascending columns.
pub(super) fn sparse_rows(
    archive: &Archive,
    name: &str,
    shape: (usize, usize),
) -> Result<Vec<Vec<(u32, f64)>>, ProblemError> {
    let matrix = archive.matrix(name)?;
    if matrix.shape() != shape {
        let (rows, cols) = matrix.shape();
        return Err(fault(archive, format!("{name} is {rows} x {cols}, expected {} x {}", shape.0, shape.1)));
    }
    let mut rows = vec![Vec::new(); shape.0];
    match matrix {
        signorini_npz::StoredMatrix::Dense(m) => {
            for (i, row) in m.values.chunks_exact(shape.1.max(1)).enumerate().take(shape.0) {
                let nonzero = row.iter().enumerate().filter(|(_, x)| **x != 0.0);
                rows[i].extend(nonzero.map(|(j, &x)| (j as u32, x)));
            }
        }
        signorini_npz::StoredMatrix::Sparse(m) => {
            m.validate().map_err(|e| fault(archive, format!("{name}: {e}")))?;
            for (i, row) in rows.iter_mut().enumerate() {
                let range = m.indptr[i]..m.indptr[i + 1];
                row.extend(m.indices[range.clone()].iter().map(|&j| j as u32).zip(m.values[range].iter().copied()));
                row.sort_by_key(|entry| entry.0);
            }
        }
    }
    Ok(rows)
}

/// Rows over the union of their columns.
pub(super) fn merge_rows<const R: usize>(rows: [&Vec<(u32, f64)>; R]) -> Vec<(u32, [f64; R])> {
    let mut merged = std::collections::BTreeMap::<u32, [f64; R]>::new();
    for (r, row) in rows.into_iter().enumerate() {
        for &(column, value) in row {
            merged.entry(column).or_insert([0.0; R])[r] += value;
        }
    }
    merged.into_iter().collect()
}

/// Collects the rows of a sparse matrix.
pub(super) struct SparseBuilder(SparseMatrix);

impl SparseBuilder {
    pub fn new(cols: usize) -> Self {
        Self(SparseMatrix { rows: 0, cols, indptr: vec![0], indices: Vec::new(), values: Vec::new() })
    }

    pub fn push_row(&mut self, entries: impl Iterator<Item = (usize, f64)>) {
        for (column, value) in entries.filter(|e| e.1 != 0.0) {
            self.0.indices.push(column);
            self.0.values.push(value);
        }
        self.0.rows += 1;
        self.0.indptr.push(self.0.values.len());
    }

    pub fn finish(self) -> SparseMatrix {
        self.0
    }
}
