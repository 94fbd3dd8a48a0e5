//! One row of a comparison, solved again and again.

use std::time::Instant;

use signorini::contact::problem_file::{FrictionalProblem, ProblemFile};
use signorini::contact::{ContactProblem, ProblemError};

use super::arguments::Arguments;
use super::plan::Plan;
use crate::results::Row;
use crate::solving::{
    Answer, Options, Point, frictional_impulses, solve_contact, solve_frictional, solve_lcp, solve_mixed,
};

/// Solves a row as often as the arguments say, or as half of its time allows.
pub fn solve(problem: &ProblemFile, plan: &Plan, arguments: &Arguments) -> Row {
    let options = arguments.options();
    let begin = Instant::now();
    let mut answer = match solve_once(problem, plan, &options) {
        Ok(answer) => answer,
        Err(error) => return Row { status: "refused".into(), reason: Some(error.to_string()), ..plan.row() },
    };
    let mut seconds = vec![answer.seconds];
    while seconds.len() < arguments.repetitions as usize
        && begin.elapsed().as_secs_f64() + answer.seconds < 0.5 * arguments.time_limit
    {
        let Ok(again) = solve_once(problem, plan, &options) else { break };
        seconds.push(again.seconds);
        answer = again;
    }
    let finite = |x: f64| x.is_finite().then_some(x);
    let status = answer.status();
    let refused = matches!(status, "refused" | "too_large");
    let (own, circular) = (answer.residual.worst().1, answer.circular_laws.map(|laws| laws.worst().1));
    // A refined polygon is judged by the law that it was refined for.
    let circular = if answer.law.is_some() && plan.law == "circular" { circular.or(Some(own)) } else { circular };
    Row {
        status: status.into(),
        reason: answer.ending.reason.clone().filter(|_| !answer.holds),
        n: Some(answer.n.max(plan.n)),
        residual: finite(own).filter(|_| !refused),
        circular_residual: circular.and_then(finite).filter(|_| !refused),
        contact_residual: answer.contact_laws.and_then(|laws| finite(laws.worst().1)).filter(|_| !refused),
        seconds: (!refused).then(|| median(&mut seconds)),
        repetitions: seconds.len() as u32,
        iterations: (!refused).then_some(answer.iterations),
        point: if refused { Vec::new() } else { point(problem, &answer) },
        ..plan.row()
    }
}

fn solve_once(problem: &ProblemFile, plan: &Plan, options: &Options) -> Result<Answer, ProblemError> {
    match (problem, plan.method.lcp()) {
        (ProblemFile::Lcp(problem), Some(method)) => solve_lcp(problem, method, options),
        (ProblemFile::MixedLcp(problem), Some(method)) => solve_mixed(problem, method, options),
        (ProblemFile::Frictional(problem), method) => solve_frictional(problem, method, plan.regular, options),
        (ProblemFile::Contact(problem), _) => solve_contact(&polygons(problem, plan)?, &plan.method, options),
        _ => {
            Err(ProblemError::File { path: Default::default(), reason: "the method does not suit the problem".into() })
        }
    }
}

fn polygons(problem: &ContactProblem, plan: &Plan) -> Result<ContactProblem, ProblemError> {
    match plan.regular {
        Some(count) => problem.with_directions(count),
        None => Ok(problem.clone()),
    }
}

fn median(seconds: &mut [f64]) -> f64 {
    seconds.sort_by(f64::total_cmp);
    let middle = seconds.len() / 2;
    if seconds.len() % 2 == 1 { seconds[middle] } else { 0.5 * (seconds[middle - 1] + seconds[middle]) }
}

/// What rows are compared by: the velocity, or `z` of a plain problem.
fn point(problem: &ProblemFile, answer: &Answer) -> Vec<f64> {
    match (problem, &answer.point) {
        (ProblemFile::Frictional(problem), Point::Plain(z)) => velocity(problem, &frictional_impulses(problem, z)),
        (ProblemFile::Frictional(problem), Point::Cone(solution)) => velocity(problem, &solution.impulse),
        (_, Point::Contact(solution)) => solution.velocity.clone(),
        (_, Point::Cone(solution)) => solution.velocity.clone(),
        (_, Point::Relaxed(solution)) => solution.velocity.clone(),
        (_, Point::Plain(z)) => z.clone(),
    }
}

/// `u = W r + q`.
fn velocity(problem: &FrictionalProblem, impulse: &[[f64; 3]]) -> Vec<f64> {
    let r: Vec<f64> = impulse.iter().flat_map(|p| p[..problem.dimension].iter().copied()).collect();
    let row = |k: usize| problem.delassus.row(k).iter().zip(&r).map(|(w, r)| w * r).sum::<f64>();
    problem.free_velocity.iter().enumerate().map(|(k, q)| q + row(k)).collect()
}
