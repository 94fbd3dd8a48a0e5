//! Balances: solutions whose velocity is zero.

use signorini_contact::{ContactProblem, ContactSolution, WarmStart, certify};
use signorini_solver::ContactSolver;

use crate::settings::StabilitySettings;

/// The impulses of a solution as a balance, where they are one: velocity zero, certified within the tolerance of balances.
pub(crate) fn as_balance(
    problem: &ContactProblem,
    solution: &ContactSolution,
    settings: &StabilitySettings,
) -> Option<ContactSolution> {
    let mut still = solution.clone();
    still.velocity.fill(0.0);
    still.beta.fill(0.0);
    let groups = &problem.friction_groups;
    for (j, beta) in still.group_beta.iter_mut().enumerate() {
        // A surface that moves slides, by its own speed.
        let u = groups.target[j];
        *beta = groups.directions_of(j).iter().map(|d| d[0] * u[0] + d[1] * u[1]).fold(0.0, f64::max);
    }
    still.certificate = certify(problem, &still);
    still.certificate.holds(settings.balance_tolerance).then_some(still)
}

/// Makes impulses that nearly balance the loads exact, by solving from them.
pub(crate) fn polished(
    problem: &ContactProblem,
    near: &ContactSolution,
    solver: &mut ContactSolver,
    settings: &StabilitySettings,
) -> Option<ContactSolution> {
    as_balance(problem, near, settings).or_else(|| {
        let solved = solver.solve(problem, Some(&WarmStart::from_solution(near)));
        as_balance(problem, &solved, settings)
    })
}

/// A balance without the friction of contacts as one of the problem with it, where joints and servos have none that could be mistaken.
pub(crate) fn with_idle_friction(
    problem: &ContactProblem,
    without: &ContactSolution,
    settings: &StabilitySettings,
) -> Option<ContactSolution> {
    if !problem.friction_groups.is_empty() {
        return None;
    }
    let mut balance = ContactSolution::default();
    balance.prepare(problem);
    balance.lambda_n.clone_from(&without.lambda_n);
    balance.impulse.clone_from(&without.impulse);
    balance.bilateral.clone_from(&without.bilateral);
    as_balance(problem, &balance, settings)
}
