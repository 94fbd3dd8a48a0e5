//! Complementarity problems, and frictional problems in impulse space.

use std::time::Instant;

use signorini::contact::problem_file::FrictionalProblem;
use signorini::contact::{FrictionPolygon, ProblemError};
use signorini::lcp::{self, Lcp, MethodKind, MixedLcp, Solution, decide};

use super::contact::cone_solver;
use super::{Answer, ContactLaw, Denial, Options, Point};
use crate::results::{Ending, Laws};

/// Solves an LCP.
pub fn solve_lcp(problem: &Lcp, kind: &MethodKind, options: &Options) -> Result<Answer, ProblemError> {
    let mut method = kind.build()?;
    let begin = Instant::now();
    let mut solution = method.solve(problem, None);
    let denial = if solution.status.is_solved() { None } else { denial_of(&problem.clone().into(), &mut solution) };
    Ok(answer(kind, solution, denial, options, begin.elapsed().as_secs_f64()))
}

/// Solves a mixed LCP.
pub fn solve_mixed(problem: &MixedLcp, kind: &MethodKind, options: &Options) -> Result<Answer, ProblemError> {
    let mut method = kind.build()?;
    let begin = Instant::now();
    let mut solution = lcp::solve_mixed(problem, method.as_mut(), None);
    let denial = denial_of(problem, &mut solution);
    Ok(answer(kind, solution, denial, options, begin.elapsed().as_secs_f64()))
}

/// Looks for what a method left open through the problem's cases: the solution, or the proof that there is none.
fn denial_of(problem: &MixedLcp, solution: &mut Solution) -> Option<(Denial, f64)> {
    let proof = decide(problem, solution)?;
    let residual = proof.residual(problem);
    Some((Denial::Cases(proof), residual))
}

/// Solves a frictional problem: its polygonal LCP by a method, or with the circular cone where none is given.
pub fn solve_frictional(
    problem: &FrictionalProblem,
    method: Option<&MethodKind>,
    directions: Option<usize>,
    options: &Options,
) -> Result<Answer, ProblemError> {
    let Some(kind) = method else { return solve_frictional_cone(problem, options) };
    let lcp = problem.polygonal_lcp(directions.unwrap_or(FrictionalProblem::DEFAULT_DIRECTIONS))?;
    let mut answer = solve_lcp(&lcp, kind, options)?;
    if let Point::Plain(z) = &answer.point {
        answer.residual = Laws::of_friction(&problem.certify(&lcp, z));
        answer.holds = answer.residual.worst().1 <= options.tolerance;
        let impulses = frictional_impulses(problem, z);
        answer.circular_laws = Some(Laws::of_friction(&problem.certify_cone(&impulses)));
    }
    (answer.contacts, answer.law) = (Some(problem.friction.len()), Some(ContactLaw::Polygon));
    Ok(answer)
}

fn solve_frictional_cone(problem: &FrictionalProblem, options: &Options) -> Result<Answer, ProblemError> {
    let mut solver = cone_solver(options.tolerance)?;
    let begin = Instant::now();
    let solution = solver.solve_frictional(problem);
    let seconds = begin.elapsed().as_secs_f64();
    Ok(Answer {
        n: problem.free_velocity.len(),
        contacts: Some(problem.friction.len()),
        method: "circular".into(),
        law: Some(ContactLaw::Circular),
        ending: Ending::of_cone(&solution.status, None),
        holds: solution.certificate.holds(options.tolerance),
        residual: Laws::of_friction(&solution.certificate),
        circular_laws: None,
        contact_laws: None,
        iterations: u64::from(solution.report.newton_iterations + solution.report.sweeps),
        seconds,
        least_norm: None,
        denial: None,
        distributions: None,
        point: Point::Cone(Box::new(solution)),
    })
}

/// Impulses (normal, tangent 1, tangent 2) of each contact from `z = (λ_N, α, β)` of a polygonal LCP.
pub fn frictional_impulses(problem: &FrictionalProblem, z: &[f64]) -> Vec<[f64; 3]> {
    let nc = problem.friction.len();
    let count = z.len().checked_div(nc).map_or(0, |rows| rows.saturating_sub(2));
    let polygon = FrictionPolygon::regular(count, 0.0).unwrap_or_default();
    let impulse = |i: usize| {
        let alpha = &z[nc + count * i..nc + count * (i + 1)];
        let sum = |r: usize| polygon.directions().iter().zip(alpha).map(|(d, a)| d[r] * a).sum();
        [z[i], sum(0), if problem.dimension == 3 { sum(1) } else { 0.0 }]
    };
    (0..nc).map(impulse).collect()
}

fn answer(
    kind: &MethodKind,
    solution: Solution,
    denial: Option<(Denial, f64)>,
    options: &Options,
    seconds: f64,
) -> Answer {
    let residual = Laws::natural_map(solution.residual.value);
    let ending = Ending::of_lcp(&solution.status, denial.as_ref().map(|(proof, _)| proof));
    Answer {
        n: solution.z.len(),
        contacts: None,
        method: kind.to_string(),
        law: None,
        ending,
        holds: residual.worst().1 <= options.tolerance,
        residual,
        circular_laws: None,
        contact_laws: None,
        iterations: solution.iterations as u64,
        seconds,
        least_norm: None,
        denial,
        distributions: None,
        point: Point::Plain(solution.z),
    }
}
