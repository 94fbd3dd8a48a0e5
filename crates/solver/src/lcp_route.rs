//! A contact problem solved by a method for general LCPs.

use signorini_lcp::{Basis, Lcp, Method, MixedLcp, Solution, Status, solve_mixed};

use crate::residual::RESIDUALS;
use signorini_contact::certificate::{certify, tangential_impulse, velocity_from_impulses};
use signorini_contact::projection::Cones;
use signorini_contact::recovery::recover_into;
use signorini_contact::{
    ContactProblem, ContactSolution, FrictionBound, Layout, ProblemError, SolveReport, SolveStatus,
};

/// What is tuned in taking out the rounding of an LCP's entries.
pub(crate) struct Tuning {
    /// How often it is taken out, at most.
    pub corrections: u32,
}

/// Chosen by: no command on record, since 22 November 2026.
pub(crate) const TUNING: Tuning = Tuning { corrections: 4 };

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
    solve_corrected(problem, method, tolerance, TUNING.corrections)
}

/// The same with at most so many corrections of the rounding of the LCP.
pub(crate) fn solve_corrected(
    problem: &ContactProblem,
    method: &mut dyn Method,
    tolerance: f64,
    corrections: u32,
) -> Result<ContactSolution, ProblemError> {
    let lcp = match problem.bilateral_violation.is_empty() {
        true => CondensedLcp::Standard(problem.standard_lcp()?),
        false => CondensedLcp::Mixed(problem.condensed_lcp()?),
    };
    let at = problem.standard_layout();
    let mut outcome = lcp.solve(method, None);
    let mut solution = ContactSolution::default();
    solution.prepare(problem);
    let mut cones = Cones::default();
    cones.prepare(problem);
    complete(problem, &cones, &at, &outcome.z, &mut solution);
    if solution.certificate.worst() > tolerance && solution.certificate.worst() < RESIDUALS.far {
        take_out_rounding((problem, &cones), lcp, method, (tolerance, corrections), &mut outcome, &mut solution)?;
    }
    solution.report = SolveReport::default();
    solution.report.lemke_pivots = outcome.iterations as u32;
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

/// Solves the LCP again from its basis, with a right-hand side that makes up for the rounding of its matrix, and takes the point that
/// certifies best. Where impulses are so large that their last digits decide, one point is as good as the next until one holds.
fn take_out_rounding(
    (problem, cones): (&ContactProblem, &Cones),
    mut lcp: CondensedLcp,
    method: &mut dyn Method,
    (tolerance, corrections): (f64, u32),
    outcome: &mut Solution,
    solution: &mut ContactSolution,
) -> Result<(), ProblemError> {
    let at = problem.standard_layout();
    let mut near = solution.clone();
    for _ in 0..corrections {
        lcp = lcp.corrected(&true_rows(problem, &at, &outcome.z, &near.velocity), &outcome.w)?;
        let corrected = lcp.solve(method, Some(&outcome.basis));
        complete(problem, cones, &at, &corrected.z, &mut near);
        outcome.iterations += corrected.iterations;
        (outcome.z, outcome.w, outcome.basis) = (corrected.z, corrected.w, corrected.basis);
        if near.certificate.worst() < solution.certificate.worst() {
            solution.clone_from(&near);
        }
        if near.certificate.worst() <= tolerance || near.certificate.worst() >= RESIDUALS.far {
            break;
        }
    }
    Ok(())
}

/// The LCP of a contact problem, mixed where there are bilateral rows.
enum CondensedLcp {
    Standard(Lcp),
    Mixed(MixedLcp),
}

impl CondensedLcp {
    fn solve(&self, method: &mut dyn Method, warm: Option<&Basis>) -> Solution {
        match self {
            Self::Standard(lcp) => method.solve(lcp, warm),
            Self::Mixed(lcp) => solve_mixed(lcp, method, warm),
        }
    }

    /// The LCP with the right-hand side for which its `w` at a point is the true one: the entries of its matrix are rounded, and large
    /// impulses multiply that. `rows`: true `w` of the rows of impulses; `rounded`: `A z + b`.
    fn corrected(&self, rows: &[f64], rounded: &[f64]) -> Result<Self, ProblemError> {
        let corrected = |b: &[f64]| {
            let differences = rows.iter().zip(rounded).map(|(exact, rounded)| exact - rounded);
            b.iter().zip(differences.chain(std::iter::repeat(0.0))).map(|(b, d)| b + d).collect()
        };
        Ok(match self {
            Self::Standard(lcp) => {
                Self::Standard(Lcp::with_scaling(lcp.A().clone(), corrected(lcp.b()), lcp.scaling().clone())?)
            }
            Self::Mixed(lcp) => {
                let (free, scaling) = (lcp.free().to_vec(), lcp.scaling().clone());
                Self::Mixed(MixedLcp::with_scaling(lcp.A().clone(), corrected(lcp.b()), free, scaling)?)
            }
        })
    }
}

/// `w` of the rows of impulses at `z`, whose velocity is known.
fn true_rows(problem: &ContactProblem, at: &Layout, z: &[f64], velocity: &[f64]) -> Vec<f64> {
    let mut w = problem.rates(velocity);
    for i in 0..problem.contact_count() {
        for k in problem.direction_offsets[i]..problem.direction_offsets[i + 1] {
            w[at.tangential + k] += z[at.bounds + i];
        }
    }
    for j in 0..problem.friction_groups.len() {
        for k in problem.friction_groups.direction_range(j) {
            w[at.group_tangential + k] += z[at.group_bounds + j];
        }
    }
    w
}

/// Impulses, velocity and what follows from them, certified.
fn complete(problem: &ContactProblem, cones: &Cones, at: &Layout, z: &[f64], solution: &mut ContactSolution) {
    take_unknowns(problem, cones, at, z, solution);
    recover_into(problem, cones, problem.velocity_scale(), solution);
    solution.certificate = certify(problem, solution);
}

/// Whether theory promises a solution (formulation §4): a ray or a proof of the contrary is then an effect of rounding. Along a
/// ray the impulses balance each other, so that bilateral rows that are not violated do not count; the constant bounds leave no impulse, and impulses bounded by contacts do no work against `v^f`, so that friction
/// groups spoil the promise only where a contact bounds them and their target is not zero (a moving wedge can jam).
fn must_have_a_solution(problem: &ContactProblem) -> bool {
    let groups = &problem.friction_groups;
    let still = |(bound, target): (&FrictionBound, &[f64; 2])| {
        matches!(bound, FrictionBound::Impulse(_)) || *target == [0.0; 2]
    };
    problem.bilateral_violation.iter().all(|theta| *theta == 0.0)
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
        // The first component times the group's coefficient is its bound.
        let first = if cones.friction(unit) > 0.0 { bound / cones.friction(unit) } else { 0.0 };
        solution.solver_modes[unit] = cones.mode_at(unit, [first, f_1, f_2]);
    }
    solution.velocity = velocity_from_impulses(problem, solution);
}

/// Contacts with an entry of a ray or of Farkas multipliers in their normal or tangential rows, ascending.
fn contacts_in(problem: &ContactProblem, at: &Layout, entries: &[f64]) -> Vec<usize> {
    let size = entries.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
    let active = |k: usize| entries[k].abs() > RESIDUALS.cancelled * size;
    let takes_part = |i: &usize| {
        let mut directions = problem.direction_offsets[*i]..problem.direction_offsets[i + 1];
        active(at.normal + i) || directions.any(|k| active(at.tangential + k))
    };
    (0..problem.contact_count()).filter(takes_part).collect()
}
