//! The result of `compare`.

use serde::{Deserialize, Serialize};

use super::FileName;

/// All laws and methods on one problem.
#[derive(Clone, Debug, Serialize)]
pub struct Comparison {
    /// File.
    pub problem: FileName,
    /// Kind of the file.
    pub kind: &'static str,
    /// Degrees of freedom, where the problem has a velocity.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nv: Option<usize>,
    /// Contacts, where the problem has any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contacts: Option<usize>,
    /// Tolerance of `solved`.
    pub tolerance: f64,
    /// The row that the differences refer to: the first one that is solved.
    pub reference: Option<usize>,
    /// What the differences are of: `velocity` or `z`.
    pub difference_of: &'static str,
    /// One row for each law and method.
    pub rows: Vec<Row>,
}

/// A law and a method.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Row {
    /// The law: `polygon`, `circular`, `relaxation`; of a plain problem `lcp` or `mlcp`.
    pub law: String,
    /// Friction directions of each contact; `None` where the law has none, or the file's own differ from contact to contact.
    pub directions: Option<usize>,
    /// Whether they are those of the file.
    pub as_given: bool,
    /// Method.
    pub method: String,
    /// `solved`, or why not; `skipped`, `stopped`.
    pub status: String,
    /// The reason in one line, where there is one.
    pub reason: Option<String>,
    /// Rows of the complementarity problem.
    pub n: Option<usize>,
    /// Worst residual of the row's own law; `None` where it is infinite or there is no point.
    pub residual: Option<f64>,
    /// Worst residual of the circular cone's laws.
    pub circular_residual: Option<f64>,
    /// Of a relaxation: worst residual of the true contact laws.
    pub contact_residual: Option<f64>,
    /// Median wall time of a solve, s.
    pub seconds: Option<f64>,
    /// Solves in the median.
    pub repetitions: u32,
    /// Iterations.
    pub iterations: Option<u64>,
    /// Largest difference from the reference, relative to the data's velocity scale (of `z`: to the largest entry of the
    /// reference).
    pub difference: Option<f64>,
    /// The point that the difference is of.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub point: Vec<f64>,
}
