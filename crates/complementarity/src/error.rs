/// What can be wrong with a problem or with settings; found once, at construction.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LcpError {
    /// The number of entries does not fit the shape of the matrix.
    #[error("a matrix of {rows} rows and {cols} columns needs {} entries, found {found}: pass rows·cols numbers, row after row", rows * cols)]
    MatrixSize {
        /// Rows asked for.
        rows: usize,
        /// Columns asked for.
        cols: usize,
        /// Entries given.
        found: usize,
    },
    /// `A` must be square.
    #[error("A has {rows} rows and {cols} columns: a complementarity problem needs a square matrix")]
    NotSquare {
        /// Rows of `A`.
        rows: usize,
        /// Columns of `A`.
        cols: usize,
    },
    /// A vector does not have one entry per row of `A`.
    #[error("{what} has {found} entries, A has {expected} rows: give one entry per row")]
    Length {
        /// The vector.
        what: &'static str,
        /// Rows of `A`.
        expected: usize,
        /// Entries given.
        found: usize,
    },
    /// An entry of `A` is NaN or infinite.
    #[error("A[{row}, {col}] = {value}: every entry must be finite")]
    MatrixNotFinite {
        /// Row of the entry.
        row: usize,
        /// Column of the entry.
        col: usize,
        /// The entry.
        value: f64,
    },
    /// An entry of a vector is NaN or infinite.
    #[error("{what}[{index}] = {value}: every entry must be finite")]
    VectorNotFinite {
        /// The vector.
        what: &'static str,
        /// Index of the entry.
        index: usize,
        /// The entry.
        value: f64,
    },
    /// A scaling weight is not a positive finite number.
    #[error("scaling weight {what}[{index}] = {value}: weights must be positive and finite")]
    Weight {
        /// `z` or `w`.
        what: &'static str,
        /// Index of the weight.
        index: usize,
        /// The weight.
        value: f64,
    },
    /// A setting is outside its range.
    #[error("setting {setting} = {value} is outside its range: {range}")]
    Setting {
        /// The field.
        setting: &'static str,
        /// The value given.
        value: f64,
        /// The range allowed.
        range: &'static str,
    },
    /// The problem has more pairs than the method accepts.
    #[error(
        "the problem has {found} pairs, the enumeration accepts {limit}: raise max_pairs, or ask for one solution by another method"
    )]
    TooManyPairs {
        /// Pairs of the problem.
        found: usize,
        /// Pairs accepted.
        limit: usize,
    },
    /// No method has this name.
    #[error("no method is called \"{name}\": the names are {known}")]
    UnknownMethod {
        /// The name given.
        name: String,
        /// The names that exist.
        known: &'static str,
    },
}
