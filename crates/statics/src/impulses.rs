//! Impulses that come from elsewhere, in the form of a solution.

use signorini_contact::certificate::{certify, tangential_impulse, velocity_from_impulses};
use signorini_contact::projection::Cones;
use signorini_contact::recovery::recover_into;
use signorini_contact::{ContactProblem, ContactSolution};

/// A solution from `λ_N`, `α`, `λ_B` and the groups' `α`: velocity, β, modes and certificate follow.
pub(crate) fn solution_from(
    problem: &ContactProblem,
    lambda_n: &[f64],
    alpha: &[f64],
    bilateral: &[f64],
    group_alpha: &[f64],
) -> ContactSolution {
    let mut solution = ContactSolution::default();
    solution.prepare(problem);
    solution.lambda_n.copy_from_slice(lambda_n);
    solution.alpha.copy_from_slice(alpha);
    solution.bilateral.copy_from_slice(bilateral);
    solution.group_alpha.copy_from_slice(group_alpha);
    let mut cones = Cones::default();
    cones.prepare(problem);
    for i in 0..problem.contact_count() {
        let [t_1, t_2] = tangential_impulse(problem, &solution, i);
        let impulse = [solution.lambda_n[i], t_1, t_2];
        let mode = cones.mode_at(i, impulse);
        solution.take_unit(i, impulse, mode);
    }
    let groups = &problem.friction_groups;
    for j in 0..groups.len() {
        let [f_1, f_2] = groups.impulse(j, &solution.group_alpha);
        let unit = problem.contact_count() + j;
        let mode = cones.mode_at(unit, [groups.bound_at(j, &solution.lambda_n), f_1, f_2]);
        solution.take_unit(unit, [0.0, f_1, f_2], mode);
    }
    solution.velocity = velocity_from_impulses(problem, &solution);
    recover_into(problem, &cones, problem.velocity_scale(), &mut solution);
    solution.certificate = certify(problem, &solution);
    solution
}
