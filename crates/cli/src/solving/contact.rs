//! Contact problems by every solver.

use std::time::Instant;

use signorini::contact::{
    CircularConeSolver, ConeSettings, ConeSolution, ConeStatus, ContactProblem, ContactSolution, ContactSolver,
    ConvexRelaxation, GapContradiction, LeastNorm, LeastNormOutcome, ProblemError, SolveStatus, SolverSettings,
    certify_cone, force_distributions, gap_contradiction, solve_as_lcp,
};
use signorini::lcp::{Existence, exclude, tractable_cases};

use super::{Answer, ContactLaw, Denial, Options, Point, SolverChoice};
use crate::args::MethodChoice;
use crate::results::{Distributions, Ending, Laws, LeastNormResult};

/// The contact problem with the directions asked for.
pub fn with_directions(
    problem: Box<ContactProblem>,
    directions: Option<usize>,
) -> Result<Box<ContactProblem>, ProblemError> {
    match directions {
        Some(count) => Ok(Box::new(problem.with_directions(count)?)),
        None => Ok(problem),
    }
}

/// Solves a contact problem.
pub fn solve_contact(
    problem: &ContactProblem,
    choice: &SolverChoice,
    options: &Options,
) -> Result<Answer, ProblemError> {
    match choice {
        SolverChoice::Polygon(method) => {
            let begin = Instant::now();
            let mut solution = match method {
                MethodChoice::Structured => ContactSolver::new(structured(options))?.solve(problem, None),
                MethodChoice::Lcp(kind) => solve_as_lcp(problem, kind.build()?.as_mut(), options.tolerance)?,
            };
            let seconds = begin.elapsed().as_secs_f64();
            let least_norm = choose_impulses(problem, &mut solution, options)?;
            polygon_answer(problem, solution, least_norm, options, method.name(), seconds)
        }
        SolverChoice::Refined => refine(problem, options),
        SolverChoice::Circular => {
            let mut solver = cone_solver(options.tolerance)?;
            let begin = Instant::now();
            let solution = solver.solve(problem, None);
            Ok(cone_answer(problem, solution, options, begin.elapsed().as_secs_f64()))
        }
        SolverChoice::Relaxation => Ok(relax(problem, options)),
    }
}

/// The structured solver's settings; the time of its stages is measured.
fn structured(options: &Options) -> SolverSettings {
    let settings = SolverSettings::default().with_time_stages(true).with_record_history(options.history);
    settings.for_tolerance(options.tolerance)
}

/// A solver for the circular cone.
pub(super) fn cone_solver(tolerance: f64) -> Result<CircularConeSolver, ProblemError> {
    let settings = ConeSettings::default().for_tolerance(tolerance);
    let polygon = SolverSettings::default().with_time_stages(true);
    CircularConeSolver::new(settings, ContactSolver::new(polygon.for_tolerance(tolerance))?)
}

fn choose_impulses(
    problem: &ContactProblem,
    solution: &mut ContactSolution,
    options: &Options,
) -> Result<Option<LeastNormResult>, ProblemError> {
    if !options.least_norm {
        return Ok(None);
    }
    let report = LeastNorm::default().apply(problem, solution, options.tolerance);
    match report.outcome {
        LeastNormOutcome::Unsupported(unsupported) => Err(unsupported.into()),
        _ => Ok(Some(LeastNormResult::of(&report))),
    }
}

fn polygon_answer(
    problem: &ContactProblem,
    solution: ContactSolution,
    least_norm: Option<LeastNormResult>,
    options: &Options,
    method: String,
    seconds: f64,
) -> Result<Answer, ProblemError> {
    let bilateral = !problem.bilateral_violation.is_empty();
    let holds = solution.certificate.holds(options.tolerance);
    let distributions =
        if options.ranges && holds { Some(Distributions::of(&force_distributions(problem, &solution)?)) } else { None };
    let denial = denial_of(problem, &solution.status)?;
    let circular = problem.check_circular().is_ok().then(|| certify_cone(problem, &as_cone(&solution)));
    Ok(Answer {
        n: problem.standard_layout().size,
        contacts: Some(problem.contact_count()),
        method,
        law: Some(ContactLaw::Polygon),
        ending: Ending::of_contacts(&solution.status, denial.as_ref().map(|(proof, _)| proof)),
        holds,
        denial,
        residual: Laws::of_contacts(&solution.certificate, bilateral),
        circular_laws: circular.map(|cone| Laws::of_contacts(&cone, bilateral)),
        contact_laws: None,
        iterations: u64::from(solution.report.iterations()),
        seconds,
        least_norm,
        distributions,
        point: Point::Contact(Box::new(solution)),
    })
}

/// The proof that a denied problem has no solution with its polygon: of its gaps, or of all cases where these are few enough.
fn denial_of(problem: &ContactProblem, status: &SolveStatus) -> Result<Option<(Denial, f64)>, ProblemError> {
    if !matches!(status, SolveStatus::Ray { .. } | SolveStatus::Infeasible { .. }) {
        return Ok(None);
    }
    if let Some((proof, residual)) = contradiction_of(problem, status) {
        return Ok(Some((Denial::Gaps(proof), residual)));
    }
    // The form whose entries are the data themselves: what is zero in them is zero, and no rounding of sums.
    let lcp = problem.mixed_lcp()?;
    Ok(match exclude(&lcp, tractable_cases(lcp.len())) {
        Existence::Excluded(proof) => {
            let residual = proof.residual(&lcp);
            Some((Denial::Cases(proof), residual))
        }
        _ => None,
    })
}

/// The proof that a denied problem's gaps contradict each other, and what rounding leaves of it.
fn contradiction_of(problem: &ContactProblem, status: &SolveStatus) -> Option<(GapContradiction, f64)> {
    let (SolveStatus::Ray { contacts } | SolveStatus::Infeasible { contacts }) = status else { return None };
    let proof = gap_contradiction(problem, contacts)?;
    let residual = proof.residual(problem);
    Some((proof, residual))
}

/// Velocity and impulses of a polygon's solution as the circular cone has them.
fn as_cone(solution: &ContactSolution) -> ConeSolution {
    let mut cone = ConeSolution::default();
    cone.take_polygon(solution);
    cone
}

fn refine(problem: &ContactProblem, options: &Options) -> Result<Answer, ProblemError> {
    let mut solver = cone_solver(options.tolerance.min(options.cone_tolerance))?;
    let (mut refined, mut solution) = (problem.clone(), ContactSolution::default());
    let begin = Instant::now();
    let report = solver.refine_into(&mut refined, None, options.cone_tolerance, &mut solution);
    let seconds = begin.elapsed().as_secs_f64();
    if let Some(unsupported) = report.unsupported {
        let solution = ConeSolution::default();
        let mut answer = cone_answer(problem, solution, options, seconds);
        (answer.ending, answer.method) = (Ending::refused(unsupported.to_string()), "refined".into());
        return Ok(answer);
    }
    let least_norm = choose_impulses(&refined, &mut solution, options)?;
    let mut answer = polygon_answer(&refined, solution, least_norm, options, "refined".into(), seconds)?;
    answer.holds &= answer.circular_laws.is_some_and(|laws| laws.worst().1 <= options.cone_tolerance);
    answer.iterations = u64::from(report.solves);
    if let Point::Contact(solution) = &answer.point {
        let mut cone = as_cone(solution);
        cone.report.stages = report.stages;
        answer.point = Point::Cone(Box::new(cone));
    }
    Ok(answer)
}

fn cone_answer(problem: &ContactProblem, mut solution: ConeSolution, options: &Options, seconds: f64) -> Answer {
    let bilateral = !problem.bilateral_violation.is_empty();
    if solution.velocity.len() != problem.nv() {
        solution.certificate = certify_cone(problem, &solution);
    }
    let denial = match &solution.status {
        ConeStatus::Denied(status) => contradiction_of(problem, status).map(|(proof, r)| (Denial::Gaps(proof), r)),
        _ => None,
    };
    let report = &solution.report;
    Answer {
        n: problem.standard_layout().size,
        contacts: Some(problem.contact_count()),
        method: "circular".into(),
        law: Some(ContactLaw::Circular),
        ending: Ending::of_cone(&solution.status, denial.as_ref().map(|(proof, _)| proof)),
        holds: solution.certificate.holds(options.tolerance),
        residual: Laws::of_contacts(&solution.certificate, bilateral),
        circular_laws: None,
        contact_laws: None,
        iterations: u64::from(report.newton_iterations + report.sweeps),
        seconds,
        least_norm: None,
        denial,
        distributions: None,
        point: Point::Cone(Box::new(solution)),
    }
}

fn relax(problem: &ContactProblem, options: &Options) -> Answer {
    let begin = Instant::now();
    let solution = ConvexRelaxation::default().solve(problem, options.tolerance);
    let seconds = begin.elapsed().as_secs_f64();
    let bilateral = !problem.bilateral_violation.is_empty();
    Answer {
        n: problem.standard_layout().size,
        contacts: Some(problem.contact_count()),
        method: "relaxation".into(),
        law: Some(ContactLaw::Relaxation),
        ending: Ending::of_relaxation(&solution.status),
        holds: solution.certificate.holds(options.tolerance),
        residual: Laws::of_relaxation(&solution.certificate, bilateral),
        circular_laws: None,
        contact_laws: Some(Laws::of_contacts(&solution.contact_laws(problem), bilateral)),
        iterations: u64::from(solution.report.iterations),
        seconds,
        least_norm: None,
        denial: None,
        distributions: None,
        point: Point::Relaxed(Box::new(solution)),
    }
}
