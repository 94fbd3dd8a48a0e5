//! Writing `.npz` archives.

use std::path::Path;

use crate::array::{Array, ArrayData};
use crate::error::{MemberProblem, NpzError};
use crate::matrix::SparseMatrix;
use crate::{npy, zip};

const LONGEST_NAME: usize = 60_000;

/// Collects arrays, then writes them as one uncompressed `.npz` file.
///
/// Equal arrays in equal order give equal bytes.
#[derive(Debug, Clone, Default)]
pub struct ArchiveWriter {
    members: Vec<(String, Vec<u8>)>,
}

impl ArchiveWriter {
    /// An archive without arrays.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds an array of any type and shape.
    ///
    /// # Errors
    /// [`NpzError::Unwritable`] when shape and values disagree or the name is taken.
    pub fn array(&mut self, name: &str, array: &Array) -> Result<&mut Self, NpzError> {
        let unwritable = |problem| NpzError::Unwritable { member: name.to_owned(), problem };
        let file_name = format!("{name}.npy");
        let taken = self.members.iter().any(|(other, _)| *other == file_name);
        if taken || name.is_empty() || name.len() > LONGEST_NAME {
            return Err(unwritable(MemberProblem::Name));
        }
        let bytes = npy::encode(array).map_err(unwritable)?;
        self.members.push((file_name, bytes));
        Ok(self)
    }

    /// Adds `f64` values of the given shape, in C order.
    ///
    /// # Errors
    /// As [`ArchiveWriter::array`].
    pub fn f64(&mut self, name: &str, shape: &[usize], x: &[f64]) -> Result<&mut Self, NpzError> {
        self.values(name, shape, ArrayData::F64(x.to_vec()))
    }

    /// Adds `i32` values of the given shape, in C order.
    ///
    /// # Errors
    /// As [`ArchiveWriter::array`].
    pub fn i32(&mut self, name: &str, shape: &[usize], x: &[i32]) -> Result<&mut Self, NpzError> {
        self.values(name, shape, ArrayData::I32(x.to_vec()))
    }

    /// Adds `i64` values of the given shape, in C order.
    ///
    /// # Errors
    /// As [`ArchiveWriter::array`].
    pub fn i64(&mut self, name: &str, shape: &[usize], x: &[i64]) -> Result<&mut Self, NpzError> {
        self.values(name, shape, ArrayData::I64(x.to_vec()))
    }

    /// Adds `u8` values of the given shape, in C order.
    ///
    /// # Errors
    /// As [`ArchiveWriter::array`].
    pub fn u8(&mut self, name: &str, shape: &[usize], x: &[u8]) -> Result<&mut Self, NpzError> {
        self.values(name, shape, ArrayData::U8(x.to_vec()))
    }

    /// Adds a text as a byte string of rank 0. Zero bytes at its end would be lost.
    ///
    /// # Errors
    /// As [`ArchiveWriter::array`].
    pub fn string(&mut self, name: &str, text: &str) -> Result<&mut Self, NpzError> {
        self.values(name, &[], ArrayData::Bytes(vec![text.into()]))
    }

    /// Adds a number of rank 0.
    ///
    /// # Errors
    /// As [`ArchiveWriter::array`].
    pub fn scalar_f64(&mut self, name: &str, value: f64) -> Result<&mut Self, NpzError> {
        self.values(name, &[], ArrayData::F64(vec![value]))
    }

    /// Adds a sparse matrix as `name_data` (f64), `name_indices` (i32), `name_indptr` (i32) and
    /// `name_shape` (i64).
    ///
    /// # Errors
    /// [`NpzError::Unwritable`] when the matrix is not valid, its size or indices exceed 32 bits, or a name
    /// is taken.
    pub fn csr(&mut self, name: &str, matrix: &SparseMatrix) -> Result<&mut Self, NpzError> {
        let unwritable = |problem| NpzError::Unwritable { member: name.to_owned(), problem };
        matrix.validate().map_err(unwritable)?;
        let narrow = |sizes: &[usize]| -> Result<Vec<i32>, NpzError> {
            let narrow = sizes.iter().map(|&size| i32::try_from(size)).collect::<Result<_, _>>();
            let shape = || vec![matrix.rows, matrix.cols];
            narrow.map_err(|_| unwritable(MemberProblem::TooLarge { shape: shape() }))
        };
        let (indices, indptr) = (narrow(&matrix.indices)?, narrow(&matrix.indptr)?);
        let shape = narrow(&[matrix.rows, matrix.cols])?;
        let shape = shape.into_iter().map(i64::from).collect::<Vec<_>>();
        self.f64(&format!("{name}_data"), &[matrix.values.len()], &matrix.values)?
            .i32(&format!("{name}_indices"), &[indices.len()], &indices)?
            .i32(&format!("{name}_indptr"), &[indptr.len()], &indptr)?
            .i64(&format!("{name}_shape"), &[2], &shape)
    }

    /// The file's bytes.
    ///
    /// # Errors
    /// [`NpzError::Unwritable`] when the archive exceeds 4 GiB or 65,535 arrays.
    pub fn to_bytes(&self) -> Result<Vec<u8>, NpzError> {
        let members = self.members.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice()));
        zip::pack(members).ok_or_else(|| NpzError::Unwritable {
            member: self.members.last().map(|(name, _)| name.clone()).unwrap_or_default(),
            problem: MemberProblem::ArchiveFull,
        })
    }

    /// Writes the file, whole or not at all.
    ///
    /// # Errors
    /// [`NpzError::Io`], and [`NpzError::Unwritable`] as [`ArchiveWriter::to_bytes`].
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), NpzError> {
        let bytes = self.to_bytes()?;
        let file = path.as_ref();
        let io = |source| NpzError::Io { file: file.to_path_buf(), source };
        signorini_files::write(file, bytes).map_err(io)
    }

    fn values(&mut self, name: &str, shape: &[usize], data: ArrayData) -> Result<&mut Self, NpzError> {
        self.array(name, &Array { shape: shape.to_vec(), data })
    }
}
