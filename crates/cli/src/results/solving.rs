//! Results of `solve` and `check`.

use std::path::PathBuf;

use serde::Serialize;
use signorini::contact::SolveStatus;
use signorini::lcp::Status;

use super::Laws;

/// A solved (or refused) problem.
#[derive(Clone, Debug, Serialize)]
pub struct SolveResult {
    /// File.
    pub problem: PathBuf,
    /// Kind of the file.
    pub kind: &'static str,
    /// Rows of the complementarity problem.
    pub n: usize,
    /// Contacts, where the problem has any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contacts: Option<usize>,
    /// Method.
    pub method: String,
    /// `solved`, or why not.
    pub status: &'static str,
    /// Tolerance of `solved`.
    pub tolerance: f64,
    /// Residuals.
    pub residual: Laws,
    /// Pivots, mode changes and proximal iterations.
    pub iterations: u64,
    /// Wall time of the solve, s.
    pub seconds: f64,
    /// Contacts (of a contact problem) or rows that wedge or contradict each other.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub involved: Vec<usize>,
    /// Solution written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub solution: Option<PathBuf>,
}

/// A checked solution.
#[derive(Clone, Debug, Serialize)]
pub struct CheckResult {
    /// Problem file.
    pub problem: PathBuf,
    /// Solution file.
    pub solution: PathBuf,
    /// Kind of the problem.
    pub kind: &'static str,
    /// Tolerance on every law.
    pub tolerance: f64,
    /// Residuals.
    #[serde(flatten)]
    pub laws: Laws,
    /// Names of the laws whose residual exceeds the tolerance.
    pub violated: Vec<&'static str>,
    /// Whether every law holds.
    pub ok: bool,
}

impl CheckResult {
    /// Compares residuals with the tolerance.
    pub fn new(problem: PathBuf, solution: PathBuf, kind: &'static str, tolerance: f64, laws: Laws) -> Self {
        let exceeds = |r: f64| r.is_nan() || r > tolerance;
        let violated: Vec<_> = laws.list().filter(|law| exceeds(law.1)).map(|law| law.0).collect();
        let ok = violated.is_empty();
        Self { problem, solution, kind, tolerance, laws, violated, ok }
    }
}

/// A contact solver's status by name, with the contacts it speaks of.
pub fn solve_status(status: &SolveStatus) -> (&'static str, Vec<usize>) {
    match status {
        SolveStatus::Solved => ("solved", Vec::new()),
        SolveStatus::Ray { contacts } => ("ray", contacts.clone()),
        SolveStatus::Infeasible { contacts } => ("infeasible", contacts.clone()),
        SolveStatus::IterationLimit => ("iteration_limit", Vec::new()),
        _ => ("inaccurate", Vec::new()),
    }
}

/// A method's status by name, with the rows it speaks of.
pub fn lcp_status(status: &Status) -> (&'static str, Vec<usize>) {
    match status {
        Status::Solved => ("solved", Vec::new()),
        Status::Ray(ray) => ("ray", ray.support.clone()),
        Status::Infeasible(farkas) => ("infeasible", (0..farkas.y.len()).filter(|&i| farkas.y[i] != 0.0).collect()),
        Status::NoSolution => ("no_solution", Vec::new()),
        Status::IterationLimit => ("iteration_limit", Vec::new()),
        Status::Inconsistent { row } => ("inconsistent", vec![*row]),
        Status::Singular => ("singular", Vec::new()),
        Status::TooLarge { .. } => ("too_large", Vec::new()),
        Status::Refused(refusal) => ("refused", vec![refusal.row()]),
        Status::Stationary { .. } => ("stationary", Vec::new()),
        _ => ("inaccurate", Vec::new()),
    }
}
