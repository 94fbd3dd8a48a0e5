//! Continuation: from a problem that has a solution and is easy, to the one that was asked for.
//!
//! Two things make a contact problem hard to solve from nothing. Where gaps are negative or constraints are violated a solution need not
//! exist, nor be where a path from infinity ends, though there is one with these taken as zero (formulation §4); and without friction the
//! problem is a convex quadratic program. So friction, and then gaps with violations, grow from zero to what they are, each problem
//! starting from the last solution. Nothing is known of the path between: it may end early, and that proves nothing.

use signorini_contact::{ContactProblem, ContactSolution, SolveStatus, WarmStart};

use crate::task::Patience;

/// What is tuned on a way.
struct Tuning {
    /// Its shortest step.
    shortest_step: f64,
}

/// Chosen by: the stored false denials (`crates/solver/tests/it/continuation.rs`), 23 November 2026.
const TUNING: Tuning = Tuning { shortest_step: 0.0625 };

/// What grows along a way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Grows {
    /// Negative gaps and violations of bilateral rows.
    Gaps,
    /// Coefficients of friction; gaps and violations are as asked for.
    Friction,
    /// The same with gaps and violations taken as zero.
    FrictionWithoutGaps,
}

/// A problem on its way to the one that was asked for.
struct Way<'a> {
    asked: &'a ContactProblem,
    shortest_step: f64,
    problem: ContactProblem,
    solution: ContactSolution,
}

impl Way<'_> {
    fn set(&mut self, grows: Grows, part: f64) {
        let (friction, gaps) = match grows {
            Grows::Gaps => (1.0, part),
            Grows::Friction => (part, 1.0),
            Grows::FrictionWithoutGaps => (part, 0.0),
        };
        let (asked, problem) = (self.asked, &mut self.problem);
        problem.friction.iter_mut().zip(&asked.friction).for_each(|(mu, asked)| *mu = friction * asked);
        problem.gap.iter_mut().zip(&asked.gap).for_each(|(phi, asked)| *phi = asked.max(gaps * asked));
        let violations = problem.bilateral_violation.iter_mut().zip(&asked.bilateral_violation);
        violations.for_each(|(theta, asked)| *theta = gaps * asked);
    }
}

/// Solves a problem from a start, where there is one.
pub(crate) trait Solve: FnMut(&ContactProblem, Option<&WarmStart>, Patience, &mut ContactSolution) {}

impl<F: FnMut(&ContactProblem, Option<&WarmStart>, Patience, &mut ContactSolution)> Solve for F {}

/// Looks for a solution along ways from easier problems; writes it to `solution` and returns `true` where one of them arrives. Where what
/// was found lacks but a few modes (`is_near`), the easier problem's solution is no more than another start: it is not followed in shorter
/// steps, each of which would lack as much.
pub(crate) fn continue_to(
    asked: &ContactProblem,
    is_near: bool,
    solution: &mut ContactSolution,
    mut solve: impl Solve,
) -> bool {
    let shortest_step = if is_near { 1.0 } else { TUNING.shortest_step };
    let mut way = Way { asked, shortest_step, problem: asked.clone(), solution: ContactSolution::default() };
    let violated = asked.gap.iter().any(|phi| *phi < 0.0) || asked.bilateral_violation.iter().any(|t| *t != 0.0);
    let rubs = asked.friction.iter().any(|mu| *mu > 0.0);
    let mut goes = |first: Grows, last: Option<Grows>| {
        way.begin(first, &mut solve) && way.follow(first, &mut solve) && last.is_none_or(|l| way.follow(l, &mut solve))
    };
    let found = violated && goes(Grows::Gaps, None)
        || rubs && goes(Grows::Friction, None)
        || violated && rubs && goes(Grows::FrictionWithoutGaps, Some(Grows::Gaps));
    if found {
        let report = std::mem::take(&mut solution.report);
        std::mem::swap(solution, &mut way.solution);
        solution.report.accumulate(&report);
    }
    found
}

impl Way<'_> {
    /// Solves the problem at the beginning of a way.
    fn begin(&mut self, grows: Grows, solve: &mut impl Solve) -> bool {
        self.set(grows, 0.0);
        solve(&self.problem, None, Patience::Full, &mut self.solution);
        self.solution.status == SolveStatus::Solved
    }

    /// Follows a way from its beginning, whose solution is at hand, to its end.
    fn follow(&mut self, grows: Grows, solve: &mut impl Solve) -> bool {
        let (mut part, mut step) = (0.0, 1.0);
        let mut found = ContactSolution::default();
        loop {
            let next: f64 = if part + step >= 1.0 { 1.0 } else { part + step };
            self.set(grows, next);
            let start = WarmStart::from_solution(&self.solution);
            solve(&self.problem, Some(&start), Patience::Brief, &mut found);
            if found.status == SolveStatus::Solved {
                std::mem::swap(&mut self.solution, &mut found);
                if next == 1.0 {
                    return true;
                }
                (part, step) = (next, 2.0 * step);
            } else {
                step *= 0.5;
                if step < self.shortest_step {
                    return false;
                }
            }
        }
    }
}
