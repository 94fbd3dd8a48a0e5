//! Reading `.npz` archives.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::array::{Array, ArrayData};
use crate::error::{MemberProblem, NpzError};
use crate::matrix::{DenseMatrix, SparseMatrix, StoredMatrix};
use crate::{npy, zip};

/// An `.npz` file in memory; arrays are decoded when asked for.
#[derive(Debug, Clone)]
pub struct Archive {
    file: PathBuf,
    bytes: Vec<u8>,
    members: BTreeMap<String, zip::Member>,
}

impl Archive {
    /// Reads the file and its directory.
    ///
    /// # Errors
    /// [`NpzError::Io`], [`NpzError::Zip`].
    pub fn read(path: impl AsRef<Path>) -> Result<Self, NpzError> {
        let file = path.as_ref().to_path_buf();
        match std::fs::read(&file) {
            Ok(bytes) => Self::from_bytes(file, bytes),
            Err(source) => Err(NpzError::Io { file, source }),
        }
    }

    /// An archive from its bytes; `file` is the name that errors will carry.
    ///
    /// # Errors
    /// [`NpzError::Zip`].
    pub fn from_bytes(file: impl Into<PathBuf>, bytes: Vec<u8>) -> Result<Self, NpzError> {
        let file = file.into();
        let entries = match zip::directory(&bytes) {
            Ok(entries) => entries,
            Err(zip::Fault { offset, problem }) => {
                return Err(NpzError::Zip { file, offset, problem });
            }
        };
        let mut members = BTreeMap::new();
        for (name, member) in entries {
            let name = name.strip_suffix(".npy").unwrap_or(&name).to_owned();
            if members.insert(name, member).is_some() {
                let problem = "two members have the same name";
                return Err(NpzError::Zip { file, offset: bytes.len(), problem });
            }
        }
        Ok(Self { file, bytes, members })
    }

    /// The file's name, as errors carry it.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Names of the arrays, sorted.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.members.keys().map(String::as_str)
    }

    /// Whether there is an array of this name.
    pub fn contains(&self, name: &str) -> bool {
        self.members.contains_key(name)
    }

    /// The array `name`, of whatever type and shape it has.
    ///
    /// # Errors
    /// [`NpzError::Missing`], [`NpzError::Member`].
    pub fn array(&self, name: &str) -> Result<Array, NpzError> {
        let Some(member) = self.members.get(name) else {
            return Err(NpzError::Missing {
                file: self.file.clone(),
                member: name.to_owned(),
                present: self.members.keys().cloned().collect(),
            });
        };
        let array = member.read(&self.bytes).and_then(|bytes| npy::decode(&bytes));
        array.map_err(self.at(name))
    }

    /// The values of `name` in C order, exactly as `f64` (see [`Array::to_f64`]).
    ///
    /// # Errors
    /// [`NpzError::Missing`], [`NpzError::Member`].
    pub fn f64(&self, name: &str) -> Result<Vec<f64>, NpzError> {
        self.array(name)?.to_f64().map_err(self.at(name))
    }

    /// The values of `name` in C order as `i32` (see [`Array::to_i32`]).
    ///
    /// # Errors
    /// [`NpzError::Missing`], [`NpzError::Member`].
    pub fn i32(&self, name: &str) -> Result<Vec<i32>, NpzError> {
        self.array(name)?.to_i32().map_err(self.at(name))
    }

    /// The values of `name` in C order as `i64` (see [`Array::to_i64`]).
    ///
    /// # Errors
    /// [`NpzError::Missing`], [`NpzError::Member`].
    pub fn i64(&self, name: &str) -> Result<Vec<i64>, NpzError> {
        self.array(name)?.to_i64().map_err(self.at(name))
    }

    /// The values of `name` in C order as `u8` (see [`Array::to_u8`]).
    ///
    /// # Errors
    /// [`NpzError::Missing`], [`NpzError::Member`].
    pub fn u8(&self, name: &str) -> Result<Vec<u8>, NpzError> {
        self.array(name)?.to_u8().map_err(self.at(name))
    }

    /// The text of `name`, a byte string with one value.
    ///
    /// # Errors
    /// [`NpzError::Missing`], [`NpzError::Member`].
    pub fn string(&self, name: &str) -> Result<String, NpzError> {
        self.array(name)?.to_text().map_err(self.at(name))
    }

    /// The only value of `name` as `f64`; any shape with one element will do.
    ///
    /// # Errors
    /// [`NpzError::Missing`], [`NpzError::Member`].
    pub fn scalar_f64(&self, name: &str) -> Result<f64, NpzError> {
        let array = self.array(name)?;
        match array.to_f64().map_err(self.at(name))?[..] {
            [value] => Ok(value),
            _ => Err(self.at(name)(array.wrong_shape("one value"))),
        }
    }

    /// The matrix `name`: the dense array `name`, or CSR from `name_data`, `name_indices`,
    /// `name_indptr` and `name_shape`.
    ///
    /// # Errors
    /// [`NpzError::Missing`] (naming `name` when neither form is there), [`NpzError::Member`].
    pub fn matrix(&self, name: &str) -> Result<StoredMatrix, NpzError> {
        let sparse = !self.contains(name) && self.contains(&format!("{name}_data"));
        if sparse {
            return self.csr(name).map(StoredMatrix::Sparse);
        }
        let array = self.array(name)?;
        let values = array.to_f64().map_err(self.at(name))?;
        match array.shape[..] {
            [rows, cols] => Ok(StoredMatrix::Dense(DenseMatrix { rows, cols, values })),
            _ => Err(self.at(name)(array.wrong_shape("a matrix (rank 2)"))),
        }
    }

    /// Whether the matrix `name` is there in either form.
    pub fn contains_matrix(&self, name: &str) -> bool {
        self.contains(name) || self.contains(&format!("{name}_data"))
    }

    fn csr(&self, name: &str) -> Result<SparseMatrix, NpzError> {
        let shape = self.sizes(&format!("{name}_shape"))?;
        let [rows, cols] = shape[..] else {
            let found = vec![shape.len()];
            let problem = MemberProblem::Shape { expected: "two values (rows, columns)", found };
            return Err(self.at(&format!("{name}_shape"))(problem));
        };
        let matrix = SparseMatrix {
            rows,
            cols,
            indptr: self.sizes(&format!("{name}_indptr"))?,
            indices: self.sizes(&format!("{name}_indices"))?,
            values: self.f64(&format!("{name}_data"))?,
        };
        matrix.validate().map_err(self.at(name))?;
        Ok(matrix)
    }

    /// Integers that must not be negative.
    fn sizes(&self, name: &str) -> Result<Vec<usize>, NpzError> {
        let array = self.array(name)?;
        if matches!(array.data, ArrayData::Bool(_)) {
            return Err(self.at(name)(array.wrong_type("integers")));
        }
        let size = |(index, value): (usize, i64)| {
            let expected = "a size";
            let out_of_range = MemberProblem::OutOfRange { index, value, expected };
            usize::try_from(value).map_err(|_| self.at(name)(out_of_range))
        };
        self.i64(name)?.into_iter().enumerate().map(size).collect()
    }

    /// Names the file and the array in an error.
    fn at<'a>(&'a self, name: &'a str) -> impl Fn(MemberProblem) -> NpzError + 'a {
        |problem| NpzError::Member { file: self.file.clone(), member: name.to_owned(), problem }
    }
}
