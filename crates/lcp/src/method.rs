use crate::{Basis, Lcp, Solution};

/// A method for linear complementarity problems.
///
/// A method owns its memory and keeps it from call to call, hence `&mut self`; its answer depends on the
/// arguments and its settings only.
pub trait Method: Send {
    /// Solves the problem, from `warm` where one is given and fits the problem.
    fn solve(&mut self, problem: &Lcp, warm: Option<&Basis>) -> Solution;

    /// The tolerance on the relative residual below which this method says [`Solved`](crate::Status::Solved).
    fn tolerance(&self) -> f64;
}
