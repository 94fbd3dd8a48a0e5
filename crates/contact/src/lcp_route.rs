//! A contact problem solved by a method for general LCPs.

use signorini_lcp::{Method, Status};

use crate::certificate::{certify, tangential_impulse, velocity_from_impulses};
use crate::recovery::recover_into;
use crate::solver::{Cones, SolveReport, SolveStatus};
use crate::{ContactProblem, ContactSolution, FrictionBound, Layout, ProblemError};

/// Solves a contact problem as an LCP: the standard form (formulation §4), or with bilateral rows the condensed one.
///
/// - `method`: any method of `signorini-lcp`
/// - `tolerance`: the certificate's worst residual up to which the status is `Solved`
///
/// # Errors
/// [`ProblemError::Lcp`] if a number of the assembled problem is not finite.
///
/// # Cost
/// Dense in all rows: `nc (2 + m)` squared memory. [`ContactSolver`](crate::ContactSolver) does without.
pub fn solve_as_lcp(
    problem: &ContactProblem,
    method: &mut dyn Method,
    tolerance: f64,
) -> Result<ContactSolution, ProblemError> {
    let at = problem.standard_layout();
    let outcome = if problem.bilateral_violation.is_empty() {
        method.solve(&problem.standard_lcp()?, None)
    } else {
        problem.condensed_lcp()?.solve(method, None)
    };
    let mut solution = ContactSolution::default();
    solution.prepare(problem);
    let mut cones = Cones::default();
    cones.prepare(problem);
    take_unknowns(problem, &cones, &at, &outcome.z, &mut solution);
    recover_into(problem, &cones, problem.velocity_scale(), &mut solution);
    solution.certificate = certify(problem, &solution);
    solution.report = SolveReport { lemke_pivots: outcome.iterations as u32, ..SolveReport::default() };
    solution.status = match &outcome.status {
        _ if solution.certificate.holds(tolerance) => SolveStatus::Solved,
        Status::Ray(_) | Status::Infeasible(_) if must_have_a_solution(problem) => SolveStatus::Inaccurate,
        Status::Ray(ray) => SolveStatus::Ray { contacts: contacts_in(problem, &at, &ray.z) },
        Status::Infeasible(farkas) => SolveStatus::Infeasible { contacts: contacts_in(problem, &at, &farkas.y) },
        Status::Inconsistent { .. } => SolveStatus::Infeasible { contacts: Vec::new() },
        Status::IterationLimit => SolveStatus::IterationLimit,
        Status::Refused(refusal) => SolveStatus::Refused(*refusal),
        Status::TooLarge { limit } => SolveStatus::TooLarge { limit: *limit },
        _ => SolveStatus::Inaccurate,
    };
    Ok(solution)
}

/// Whether theory promises a solution (formulation §4): a ray or a proof of the contrary is then an effect of rounding. Along a
/// ray the constant bounds leave no impulse, and impulses bounded by contacts do no work against `v^f`, so that friction
/// groups spoil the promise only where a contact bounds them and their target is not zero (a moving wedge can jam).
fn must_have_a_solution(problem: &ContactProblem) -> bool {
    let groups = &problem.friction_groups;
    let still = |(bound, target): (&FrictionBound, &[f64; 2])| {
        matches!(bound, FrictionBound::Impulse(_)) || *target == [0.0; 2]
    };
    problem.bilateral_violation.is_empty()
        && problem.gap.iter().all(|phi| *phi >= 0.0)
        && groups.bound.iter().zip(&groups.target).all(still)
}

/// Impulses, modes and velocity from the unknowns `(λ_B, λ_N, α, α_F, β, β_F)`.
fn take_unknowns(problem: &ContactProblem, cones: &Cones, at: &Layout, z: &[f64], solution: &mut ContactSolution) {
    if z.len() != at.size {
        return;
    }
    solution.bilateral.copy_from_slice(&z[at.bilateral..at.normal]);
    solution.lambda_n.copy_from_slice(&z[at.normal..at.tangential]);
    solution.alpha.copy_from_slice(&z[at.tangential..at.group_tangential]);
    solution.group_alpha.copy_from_slice(&z[at.group_tangential..at.bounds]);
    for i in 0..problem.contact_count() {
        let [t_1, t_2] = tangential_impulse(problem, solution, i);
        solution.impulse[i] = [solution.lambda_n[i], t_1, t_2];
        solution.solver_modes[i] = cones.mode_at(i, solution.impulse[i]);
    }
    let groups = &problem.friction_groups;
    for j in 0..groups.len() {
        let [f_1, f_2] = groups.impulse(j, &solution.group_alpha);
        let bound = groups.bound_at(j, &solution.lambda_n);
        let unit = problem.contact_count() + j;
        solution.group_impulse[j] = [f_1, f_2];
        solution.solver_modes[unit] = cones.mode_at(unit, [bound, f_1, f_2]);
    }
    solution.velocity = velocity_from_impulses(problem, solution);
}

/// Contacts with an entry of a ray or of Farkas multipliers in their normal or tangential rows, ascending.
fn contacts_in(problem: &ContactProblem, at: &Layout, entries: &[f64]) -> Vec<usize> {
    let size = entries.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
    let active = |k: usize| entries[k].abs() > 1e-9 * size;
    let takes_part = |i: &usize| {
        let mut directions = problem.direction_offsets[*i]..problem.direction_offsets[i + 1];
        active(at.normal + i) || directions.any(|k| active(at.tangential + k))
    };
    (0..problem.contact_count()).filter(takes_part).collect()
}
