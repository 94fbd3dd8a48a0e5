//! Completing a solution and judging it: what follows from its impulses, the certificate, and which velocity is claimed.
//!
//! The certificate is computed from the data alone. Beside it stand two comparisons: the claimed velocity with that of the impulses along
//! every row, and, where impulses are so large that their last digits are velocities, the latter with the same sums in another order.

use signorini_contact::certificate::{
    Certificate, Scales, Scratch, certify_afresh, certify_with, take_velocity_before_recovery, velocity_from_impulses,
    velocity_summed_backwards,
};
use signorini_contact::projection::Cones;
use signorini_contact::recovery::{recover_into, recover_with};
use signorini_contact::spread::certify_and_spread;
use signorini_contact::{ContactProblem, ContactSolution, ResidualSpread, SolveStatus};

use crate::islands::Islands;
use crate::residual::RESIDUALS;

/// What is needed to judge solutions of a problem.
#[derive(Debug, Default)]
pub(crate) struct Verdict {
    tolerance: f64,
    scales: Scales,
    scratch: Scratch,
}

impl Verdict {
    /// Takes the scales of a problem from its islands.
    pub fn begin(&mut self, islands: &Islands, tolerance: f64) {
        self.scales = Scales::new(islands.delassus_scale(), islands.velocity_scale());
        self.tolerance = tolerance;
    }

    /// Fills in what follows from impulses and velocity, and certifies it; whether the certificate holds. `residuals`: those of the
    /// islands, if none of them is far from a solution another velocity may help.
    pub fn complete(
        &mut self,
        problem: &ContactProblem,
        cones: &Cones,
        residuals: &[f64],
        solution: &mut ContactSolution,
    ) -> bool {
        recover_into(problem, cones, self.scales.velocity, solution);
        self.certify_recovered(problem, cones, residuals, solution)
    }

    /// The same where every island is as the start gives it, so that the contacts' velocities are known.
    pub fn complete_given(
        &mut self,
        problem: &ContactProblem,
        cones: &Cones,
        (residuals, rates): (&[f64], &[[f64; 3]]),
        solution: &mut ContactSolution,
    ) -> bool {
        recover_with(problem, cones, self.scales.velocity, |i, _| rates[i], solution);
        self.certify_recovered(problem, cones, residuals, solution)
    }

    fn certify_recovered(
        &mut self,
        problem: &ContactProblem,
        cones: &Cones,
        residuals: &[f64],
        solution: &mut ContactSolution,
    ) -> bool {
        solution.certificate = certify_with(problem, solution, &self.scales, &mut self.scratch);
        if self.is_certified(solution) {
            return true;
        }
        let is_hopeless =
            solution.certificate.natural_map > RESIDUALS.far && residuals.iter().any(|r| *r > RESIDUALS.far);
        if !is_hopeless {
            self.take_velocity_of_impulses(problem, cones, solution);
        }
        self.is_certified(solution)
    }

    /// The same for what was left unfinished: with the velocity of the impulses, and with where the residual is.
    pub fn complete_unfinished(
        &mut self,
        problem: &ContactProblem,
        cones: &Cones,
        solution: &mut ContactSolution,
    ) -> bool {
        take_velocity_before_recovery(problem, solution, &mut self.scratch);
        recover_into(problem, cones, self.scales.velocity, solution);
        (solution.certificate, solution.spread) =
            certify_and_spread(problem, solution, &self.scales, &mut self.scratch);
        let is_certified = self.is_certified(solution);
        solution.spread = solution.spread.filter(|_| !is_certified);
        is_certified
    }

    /// Where the residual of a solution is.
    pub fn spread(&mut self, problem: &ContactProblem, solution: &ContactSolution) -> Option<ResidualSpread> {
        certify_and_spread(problem, solution, &self.scales, &mut self.scratch).1
    }

    /// The worst residual of the solution that was certified last, and what counts as one: a velocity that is not that of the
    /// impulses.
    pub fn violation(&self, solution: &ContactSolution) -> f64 {
        // Where a contact is closed the laws hold for both velocities, each within a tolerance: they may differ by two.
        solution.certificate.worst().max(self.scratch.carried / 2.0)
    }

    /// Whether that is within the tolerance.
    pub fn is_certified(&self, solution: &ContactSolution) -> bool {
        self.violation(solution) <= self.tolerance
    }

    /// Whether rounding of the impulses' sums is all that a solution lacks: it is within a few tolerances.
    pub fn is_rounded(&self, solution: &ContactSolution, tolerances: f64) -> bool {
        let most = tolerances * self.tolerance;
        self.violation(solution) <= most && self.scales.rounding(solution) <= most
    }

    /// Whether what the solution that was certified last lacks is what the last digits of its impulses make in a velocity, and more than
    /// the tolerance.
    pub fn is_out_of_digits(&self, solution: &ContactSolution) -> bool {
        let rounding = self.scales.rounding(solution);
        rounding > self.tolerance && self.violation(solution) <= RESIDUALS.far.min(RESIDUALS.rounded * rounding)
    }

    /// Whether the velocity of the impulses is one number up to a few tolerances, in whatever order it is summed: with very large
    /// impulses a certificate can hold by the luck of one order.
    pub fn is_resolved(&mut self, problem: &ContactProblem, solution: &mut ContactSolution) -> bool {
        if self.scales.rounding(solution) <= self.tolerance {
            return true;
        }
        let other = velocity_summed_backwards(problem, solution);
        let claimed = std::mem::replace(&mut solution.velocity, other);
        certify_with(problem, solution, &self.scales, &mut self.scratch);
        solution.velocity = claimed;
        self.scratch.carried <= RESIDUALS.rounded * self.tolerance
    }

    /// No impulses at all have the residual 1: what was found may be worse and of no use to anyone.
    pub fn drop_what_is_worse(&mut self, problem: &ContactProblem, cones: &Cones, solution: &mut ContactSolution) {
        if solution.certificate.natural_map > 1.0 || solution.certificate.natural_map.is_nan() {
            solution.drop_impulses(problem);
            self.certify_completed(problem, cones, solution);
        }
    }

    /// The certificate of any solution of the problem at hand; of another one where that has no rows.
    pub fn recertify(&mut self, problem: &ContactProblem, solution: &ContactSolution, has_rows: bool) -> Certificate {
        if has_rows {
            certify_with(problem, solution, &self.scales, &mut self.scratch)
        } else {
            certify_afresh(problem, solution, &mut self.scratch)
        }
    }

    fn certify_completed(&mut self, problem: &ContactProblem, cones: &Cones, solution: &mut ContactSolution) {
        recover_into(problem, cones, self.scales.velocity, solution);
        solution.certificate = certify_with(problem, solution, &self.scales, &mut self.scratch);
    }

    /// Replaces the refined velocity by that of the impulses, with the `β` that follows from it, where this certifies
    /// better: light bodies turn refinements that the contact rows do not see into a difference between the two.
    fn take_velocity_of_impulses(&mut self, problem: &ContactProblem, cones: &Cones, solution: &mut ContactSolution) {
        let (refined_certificate, carried) = (solution.certificate, self.scratch.carried);
        let refined_violation = self.violation(solution);
        let mut unrefined = velocity_from_impulses(problem, solution);
        // What rests stays at rest: its impulses and its weight cancel to rounding.
        for own in problem.mass.blocks().iter().map(|block| block.range()) {
            if solution.velocity[own.clone()].iter().all(|v| *v == 0.0) {
                unrefined[own].fill(0.0);
            }
        }
        let refined = std::mem::replace(&mut solution.velocity, unrefined);
        self.certify_completed(problem, cones, solution);
        if self.violation(solution) >= refined_violation {
            solution.velocity = refined;
            recover_into(problem, cones, self.scales.velocity, solution);
            (solution.certificate, self.scratch.carried) = (refined_certificate, carried);
        }
    }
}

/// Rows that belong to no island because no degree of freedom moves them, and that are violated: no impulse can help.
pub fn immovable_rows(problem: &ContactProblem) -> Option<SolveStatus> {
    let violated = |i: &usize| problem.jacobian.group(*i).0.is_empty() && problem.gap[*i] < 0.0;
    let contacts: Vec<usize> = (0..problem.contact_count()).filter(violated).collect();
    let contradicted =
        |k: usize| problem.bilateral_jacobian.group(k).0.is_empty() && problem.bilateral_violation[k] != 0.0;
    let any = !contacts.is_empty() || (0..problem.bilateral_violation.len()).any(contradicted);
    any.then_some(SolveStatus::Infeasible { contacts })
}

/// The solution where nothing touches: with `v⁺ = v^f` and no other unknown every residual is zero, if the data are numbers.
pub fn take_free_velocity(problem: &ContactProblem, solution: &mut ContactSolution) {
    solution.prepare(problem);
    solution.certificate = Certificate::default();
    if solution.velocity.iter().any(|v| !v.is_finite()) {
        solution.certificate = Certificate::everything_violated();
        solution.status = SolveStatus::Inaccurate;
    }
}
