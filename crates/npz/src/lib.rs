//! NumPy's `.npy` and `.npz` files: the exchange format of contact problems and solutions.
//!
//! An `.npz` file is a zip archive of `.npy` members, one array each. This crate reads stored
//! (`numpy.savez`) and deflated (`numpy.savez_compressed`) members and writes stored ones, so that
//! a file written here needs no inflate anywhere.
//!
//! Read: `f64`, `f32`, `i64`, `i32`, `u8`, `bool` and byte strings (`|S`), any rank, C or Fortran
//! order, little-endian. Values always come out in C order (last index fastest).
//!
//! Matrices follow one convention: `X` alone is a dense rank-2 array; `X_data`, `X_indices`,
//! `X_indptr`, `X_shape` together are a matrix in compressed sparse row form.
//!
//! Whatever the bytes, reading ends in a value or in an [`NpzError`] that names the file, the member
//! and the fault. Sizes that a file declares are compared with the bytes present before any
//! allocation, so a damaged header cannot exhaust memory.
//!
//! ```
//! use signorini_npz::{Archive, ArchiveWriter};
//! let mut writer = ArchiveWriter::new();
//! writer.f64("b", &[2], &[1.0, -2.0])?.string("kind", "lcp")?;
//! let archive = Archive::from_bytes("memory.npz", writer.to_bytes()?)?;
//! assert_eq!(archive.f64("b")?, [1.0, -2.0]);
//! assert_eq!(archive.string("kind")?, "lcp");
//! # Ok::<(), signorini_npz::NpzError>(())
//! ```

mod archive;
mod array;
mod error;
mod matrix;
mod npy;
mod writer;
mod zip;

pub use archive::Archive;
pub use array::{Array, ArrayData};
pub use error::{MemberProblem, NpzError};
pub use matrix::{DenseMatrix, MAX_DENSE_ENTRIES, SparseMatrix, StoredMatrix};
pub use npy::{read_npy, write_npy};
pub use writer::ArchiveWriter;
