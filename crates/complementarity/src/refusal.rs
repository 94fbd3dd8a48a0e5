/// The hypothesis of a method's theory that a problem does not meet, with its place in the matrix.
///
/// Each is decided in the equilibrated problem, so that it does not depend on the units of variables and rows; values
/// are those of that problem, whose diagonal entries have size 1.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Refusal {
    /// The diagonal entry is zero or negative: the relaxation would divide by it.
    #[error("the diagonal entry of row {row} is {value:e} and must be positive")]
    Diagonal {
        /// The row.
        row: usize,
        /// The entry.
        value: f64,
    },
    /// The matrix is symmetric (perhaps after scaling), but not positive semidefinite.
    #[error("the matrix is not positive semidefinite: elimination leaves {value:e} on the diagonal of row {row}")]
    Indefinite {
        /// The row in whose elimination it was seen.
        row: usize,
        /// What the elimination left on its diagonal, or `−|s|` for an entry `s` beside a zero on it.
        value: f64,
    },
    /// No scaling of rows makes the matrix symmetric, and it is not diagonally dominant in any scaling of columns.
    #[error(
        "entries ({row}, {col}) and ({col}, {row}) differ, and row {dominance} is not diagonally dominant in any scaling"
    )]
    NeitherSymmetricNorDominant {
        /// Row of an entry that differs from its mirror image.
        row: usize,
        /// Its column.
        col: usize,
        /// A row that fails generalised diagonal dominance.
        dominance: usize,
    },
    /// The relaxation parameter is too large for a matrix that is not symmetric.
    #[error("the relaxation must stay below {limit} for this matrix, which is not symmetric; row {row} sets the limit")]
    Relaxation {
        /// The row that sets the limit.
        row: usize,
        /// Relaxations below this are known to converge.
        limit: f64,
    },
    /// A principal transform of the matrix has entries whose signs exclude a sufficient matrix, hence also a positive
    /// semidefinite one and a P-matrix.
    #[error(
        "the matrix is not sufficient (so neither positive semidefinite nor P): a pivot met {value:e} at ({row}, {col})"
    )]
    NotSufficient {
        /// Row of the entry of the transform.
        row: usize,
        /// Its column; equal to `row` for a negative diagonal.
        col: usize,
        /// The entry.
        value: f64,
    },
}

impl Refusal {
    /// The row at which the hypothesis fails.
    pub fn row(&self) -> usize {
        match self {
            Self::Diagonal { row, .. }
            | Self::Indefinite { row, .. }
            | Self::NeitherSymmetricNorDominant { row, .. }
            | Self::Relaxation { row, .. }
            | Self::NotSufficient { row, .. } => *row,
        }
    }

    /// The same with every index `i` replaced by `place(i)`.
    pub fn moved(mut self, place: impl Fn(usize) -> usize) -> Self {
        match &mut self {
            Self::Diagonal { row, .. } | Self::Indefinite { row, .. } | Self::Relaxation { row, .. } => {
                *row = place(*row);
            }
            Self::NotSufficient { row, col, .. } => (*row, *col) = (place(*row), place(*col)),
            Self::NeitherSymmetricNorDominant { row, col, dominance } => {
                (*row, *col, *dominance) = (place(*row), place(*col), place(*dominance));
            }
        }
        self
    }
}
