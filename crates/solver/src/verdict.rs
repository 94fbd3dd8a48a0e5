//! Completing a solution and judging it: what follows from its impulses, the certificate, and which velocity is claimed.

use super::ContactSolver;
use signorini_contact::certificate::{certify_with, velocity_from_impulses, velocity_summed_backwards};
use signorini_contact::recovery::{recover_into, recover_with};
use signorini_contact::{ContactProblem, ContactSolution};

/// How far the claimed velocity may be from that of the impulses along any row, in tolerances: where a contact is closed the laws
/// hold for both, which leaves two.
const CARRIED: f64 = 2.0;
/// How far, in tolerances, two ways to sum the velocity of the impulses may differ.
const RESOLVED: f64 = 5.0;
/// A residual that no choice among velocities mends.
const HOPELESS: f64 = 1e-3;

impl ContactSolver {
    /// Fills in what follows from impulses and velocity, and certifies it; whether the certificate holds.
    pub(super) fn complete(&mut self, problem: &ContactProblem, solution: &mut ContactSolution) -> bool {
        recover_into(problem, &self.cones, self.scales.velocity, solution);
        self.certify_recovered(problem, solution)
    }

    /// The same where every island is as the start gives it, so that the contacts' velocities are known.
    pub(super) fn complete_given(&mut self, problem: &ContactProblem, solution: &mut ContactSolution) -> bool {
        recover_with(problem, &self.cones, self.scales.velocity, |i, _| self.given.rates[i], solution);
        self.certify_recovered(problem, solution)
    }

    fn certify_recovered(&mut self, problem: &ContactProblem, solution: &mut ContactSolution) -> bool {
        solution.certificate = certify_with(problem, solution, &self.scales, &mut self.scratch);
        self.is_certified(solution) || {
            self.take_better_velocity(problem, solution);
            self.is_certified(solution)
        }
    }

    /// Tries the velocity of the impulses where the certificate does not hold, unless they are far from a solution with any velocity.
    pub(super) fn take_better_velocity(&mut self, problem: &ContactProblem, solution: &mut ContactSolution) {
        let hopeless = solution.certificate.natural_map > HOPELESS && self.residuals.iter().any(|r| *r > HOPELESS);
        if !hopeless && !self.is_certified(solution) {
            self.take_velocity_of_impulses(problem, solution);
        }
    }

    /// The worst residual of the solution that was certified last, and what counts as one: a velocity that is not that of the
    /// impulses.
    pub(super) fn violation(&self, solution: &ContactSolution) -> f64 {
        solution.certificate.worst().max(self.scratch.carried / CARRIED)
    }

    /// Whether that is within the tolerance.
    pub(super) fn is_certified(&self, solution: &ContactSolution) -> bool {
        self.violation(solution) <= self.settings.tolerance
    }

    /// Whether the velocity of the impulses is one number up to a few tolerances, in whatever order it is summed: with very large
    /// impulses a certificate can hold by the luck of one order.
    pub(super) fn is_resolved(&mut self, problem: &ContactProblem, solution: &mut ContactSolution) -> bool {
        if self.scales.rounding(solution) <= self.settings.tolerance {
            return true;
        }
        let other = velocity_summed_backwards(problem, solution);
        let claimed = std::mem::replace(&mut solution.velocity, other);
        certify_with(problem, solution, &self.scales, &mut self.scratch);
        solution.velocity = claimed;
        self.scratch.carried <= RESOLVED * self.settings.tolerance
    }

    pub(super) fn certify_completed(&mut self, problem: &ContactProblem, solution: &mut ContactSolution) {
        recover_into(problem, &self.cones, self.scales.velocity, solution);
        solution.certificate = certify_with(problem, solution, &self.scales, &mut self.scratch);
    }

    /// Replaces the refined velocity by that of the impulses, with the `β` that follows from it, where this certifies
    /// better: light bodies turn refinements that the contact rows do not see into a difference between the two.
    fn take_velocity_of_impulses(&mut self, problem: &ContactProblem, solution: &mut ContactSolution) {
        let (refined_certificate, carried) = (solution.certificate, self.scratch.carried);
        let refined_violation = self.violation(solution);
        let unrefined = velocity_from_impulses(problem, solution);
        let refined = std::mem::replace(&mut solution.velocity, unrefined);
        self.certify_completed(problem, solution);
        if self.violation(solution) >= refined_violation {
            solution.velocity = refined;
            recover_into(problem, &self.cones, self.scales.velocity, solution);
            (solution.certificate, self.scratch.carried) = (refined_certificate, carried);
        }
    }
}
