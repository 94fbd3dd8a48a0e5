//! What can be wrong with a contact problem.

use std::path::PathBuf;

use crate::UnsupportedFriction;

/// Wrong input, found when a problem is built or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ProblemError {
    /// An array has the wrong size.
    #[error("{array} has {found} entries, expected {expected}")]
    Length {
        /// The array.
        array: &'static str,
        /// Entries it should have.
        expected: usize,
        /// Entries it has.
        found: usize,
    },
    /// A number is out of its range or not finite.
    #[error("{array}[{index}] = {value}: must be {expected}")]
    Number {
        /// The array.
        array: &'static str,
        /// Position in it.
        index: usize,
        /// What it is.
        value: f64,
        /// What it has to be.
        expected: &'static str,
    },
    /// A set of friction directions is not a balanced convex polygon.
    #[error("friction directions{}: {reason}", contact.map(|c| format!(" of contact {c}")).unwrap_or_default())]
    Directions {
        /// The contact, where it is known.
        contact: Option<usize>,
        /// What is wrong.
        reason: String,
    },
    /// The directions of a friction group are not a balanced convex polygon.
    #[error("directions of friction group {group}: {reason}")]
    GroupDirections {
        /// The group.
        group: usize,
        /// What is wrong.
        reason: String,
    },
    /// The mass matrix is not symmetric positive definite.
    #[error(transparent)]
    Mass(#[from] signorini_multibody::MassError),
    /// A column index lies beyond the degrees of freedom.
    #[error("row {row} of the Jacobian has an entry at column {column}, but there are only {nv} degrees of freedom")]
    Column {
        /// Contact, bilateral row or friction group.
        row: usize,
        /// The column.
        column: usize,
        /// Degrees of freedom.
        nv: usize,
    },
    /// The columns of a Jacobian row are not strictly ascending.
    #[error("row {row} of the Jacobian has column {column} out of order: give each column once, in ascending order")]
    ColumnOrder {
        /// Contact, bilateral row or friction group.
        row: usize,
        /// The first column that does not exceed the one before it.
        column: usize,
    },
    /// A file cannot be read or lacks something.
    #[error(transparent)]
    Archive(#[from] signorini_npz::NpzError),
    /// A file holds a problem of an unknown kind or of inconsistent parts.
    #[error("{}: {reason}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong and what to do.
        reason: String,
    },
    /// The data in a file are not those of a problem.
    #[error("{}: {error}", path.display())]
    InFile {
        /// The file.
        path: PathBuf,
        /// What is wrong; it names the array.
        #[source]
        error: Box<ProblemError>,
    },
    /// The assembled complementarity problem is malformed.
    #[error(transparent)]
    Lcp(#[from] signorini_complementarity::LcpError),
    /// The problem has friction that what was asked for does not have.
    #[error(transparent)]
    Unsupported(#[from] UnsupportedFriction),
    /// What was given as a solution violates the laws.
    #[error(
        "the solution's certificate is {residual:.1e}, which is too much to say what else it admits: solve the problem first"
    )]
    NotASolution {
        /// Its worst residual.
        residual: f64,
    },
}
