//! The best point that a method has found so far.

use crate::polish::Polish;
use crate::{Basis, Lcp, Report, Residual, Solution, Status};

/// The point with the smallest residual in the original data, from `z = 0` on.
pub(crate) struct Incumbent<'a> {
    pub(crate) problem: &'a Lcp,
    pub(crate) z: Vec<f64>,
    w: Vec<f64>,
    pub(crate) residual: Residual,
    pub(crate) basis: Basis,
}

impl<'a> Incumbent<'a> {
    pub(crate) fn new(problem: &'a Lcp) -> Self {
        let n = problem.len();
        let (z, w) = (vec![0.0; n], problem.b().to_vec());
        Self { problem, residual: problem.residual_at(&z, &w), z, w, basis: Basis::slack(n) }
    }

    /// Takes the point, its negative entries set to zero, if it is better; returns its residual.
    pub(crate) fn offer(&mut self, mut z: Vec<f64>, basis: &Basis) -> Residual {
        z.iter_mut().for_each(|z| *z = z.max(0.0));
        let w = self.problem.w(&z);
        let residual = self.problem.residual_at(&z, &w);
        if residual.value < self.residual.value {
            (self.z, self.w, self.residual) = (z, w, residual);
            self.basis.clone_from(basis);
        }
        residual
    }

    /// Offers the point that solves the linear system of the basis in the original data; `None` where it has none.
    pub(crate) fn offer_basis(&mut self, polish: &mut Polish, basis: &Basis) -> Option<Residual> {
        let problem = self.problem;
        let mut z = vec![0.0; problem.len()];
        let active = basis.active();
        let solved = polish.solve_active(problem.A(), problem.b(), problem.scaling(), &active, &active, &mut z);
        solved.then(|| self.offer(z, basis))
    }

    /// The solution; it is solved if and only if its residual is within the tolerance, whatever `otherwise` says.
    pub(crate) fn into_solution(
        self,
        tolerance: f64,
        otherwise: Status,
        iterations: usize,
        report: Report,
    ) -> Solution {
        Solution {
            z: self.z,
            w: self.w,
            status: if self.residual.within(tolerance) { Status::Solved } else { otherwise },
            basis: self.basis,
            iterations,
            residual: self.residual,
            report,
        }
    }
}
