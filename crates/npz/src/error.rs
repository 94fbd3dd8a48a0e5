//! What can be wrong with a file, and where.

use std::path::PathBuf;

/// Why a file could not be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum NpzError {
    /// The operating system refused to read or write the file.
    #[error("{}: {source}", file.display())]
    Io {
        /// The file.
        file: PathBuf,
        /// What the operating system said.
        source: std::io::Error,
    },
    /// The file is not a zip archive that this crate reads.
    #[error("{}: not a readable .npz (zip) file: {problem} (at byte {offset})", file.display())]
    Zip {
        /// The file.
        file: PathBuf,
        /// Where in the file.
        offset: usize,
        /// What was found or missing.
        problem: &'static str,
    },
    /// The archive has no array of this name.
    #[error("{}: no array `{member}`; the file holds: {}", file.display(), present.join(", "))]
    Missing {
        /// The file.
        file: PathBuf,
        /// The name asked for.
        member: String,
        /// The names that the file holds.
        present: Vec<String>,
    },
    /// One array is damaged, or is not what was asked for.
    #[error("{}: array `{member}`: {problem}", file.display())]
    Member {
        /// The file.
        file: PathBuf,
        /// The array's name; empty for a lone `.npy` file.
        member: String,
        /// What is wrong with it.
        #[source]
        problem: MemberProblem,
    },
    /// An array cannot be written as it was given.
    #[error("cannot write array `{member}`: {problem}")]
    Unwritable {
        /// The array's name.
        member: String,
        /// What is wrong with it.
        #[source]
        problem: MemberProblem,
    },
}

/// What is wrong with one array.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MemberProblem {
    /// The member is encrypted.
    #[error("is encrypted; save it without a password")]
    Encrypted,
    /// The member is compressed by a method other than deflate.
    #[error("is compressed by zip method {method}; save it with numpy.savez (uncompressed)")]
    Compression {
        /// The method's number in the zip specification.
        method: u16,
    },
    /// The deflated bytes are not a valid stream of the declared length.
    #[error("the compressed bytes are damaged (declared size {declared} bytes)")]
    Inflate {
        /// Size after decompression according to the directory.
        declared: usize,
    },
    /// The bytes end before the array does.
    #[error("is cut short: needs {needed} bytes, {found} are there")]
    Truncated {
        /// Bytes that the header promises.
        needed: usize,
        /// Bytes present.
        found: usize,
    },
    /// The checksum does not fit the bytes.
    #[error("is damaged: checksum {computed:08x}, the directory says {stored:08x}; fetch the file again")]
    Checksum {
        /// The directory's value.
        stored: u32,
        /// The value of the bytes.
        computed: u32,
    },
    /// The `.npy` header cannot be understood.
    #[error("bad .npy header: {problem}")]
    Header {
        /// What was expected.
        problem: &'static str,
    },
    /// The element type is not one that this crate reads.
    #[error("element type {descr} is not read; convert it to one of <f8 <f4 <i8 <i4 |u1 |b1 |S (little-endian)")]
    ElementType {
        /// The header's `descr` field.
        descr: String,
    },
    /// The number of bytes does not follow from shape and type.
    #[error("shape {shape:?} of type {element} needs {needed} bytes of data, {found} are there")]
    DataSize {
        /// The header's shape.
        shape: Vec<usize>,
        /// The element type.
        element: String,
        /// Bytes that shape and type ask for.
        needed: usize,
        /// Bytes after the header.
        found: usize,
    },
    /// The shape's number of elements does not fit an address space.
    #[error("shape {shape:?} is too large")]
    TooLarge {
        /// The shape.
        shape: Vec<usize>,
    },
    /// The array has another element type than the one asked for.
    #[error("holds {found}, {expected} was asked for")]
    WrongType {
        /// The type asked for.
        expected: &'static str,
        /// The type found.
        found: &'static str,
    },
    /// An integer does not fit the type asked for.
    #[error("entry {index} is {value}, which {expected} cannot hold exactly")]
    OutOfRange {
        /// Flat index in C order.
        index: usize,
        /// The value.
        value: i64,
        /// The type asked for.
        expected: &'static str,
    },
    /// The shape is not the one asked for.
    #[error("has shape {found:?}, expected {expected}")]
    Shape {
        /// In words.
        expected: &'static str,
        /// The array's shape.
        found: Vec<usize>,
    },
    /// A byte string is not UTF-8.
    #[error("is not UTF-8 text")]
    NotUtf8,
    /// The four arrays of a sparse matrix contradict each other.
    #[error("is not a valid CSR matrix: {problem} (at entry {index})")]
    Csr {
        /// What is violated.
        problem: &'static str,
        /// Index into the array at fault.
        index: usize,
    },
    /// The number of values does not fit the shape given with them.
    #[error("{found} values were given for shape {shape:?}")]
    ValueCount {
        /// The shape given.
        shape: Vec<usize>,
        /// The number of values given.
        found: usize,
    },
    /// The name is already taken in this archive, or is empty or too long for a zip file.
    #[error("the name is empty, longer than 60,000 bytes, or already in the archive")]
    Name,
    /// The archive would exceed what a zip file without extensions holds.
    #[error("the archive would exceed 4 GiB or 65,535 arrays; split it")]
    ArchiveFull,
}
