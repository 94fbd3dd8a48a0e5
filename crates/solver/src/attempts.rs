//! The attempts on an island: the first two stages of the cascade, from start after start.

use super::SolverSettings;
use super::fallback::QUICK_ROWS;
use super::given::GivenStart;
use super::island::Island;
use super::island_pool::Outcome;
use super::island_solver::IslandSolver;
use super::proximal::{LARGE, first_patient, is_patient};
use super::warm_start;
use signorini_contact::ContactProblem;
use signorini_contact::projection::Cones;

/// Where the certificate asks for more than `accept`, a small island has to come down to this part of it, a large one, whose residual
/// may be mostly rounding, to that.
const CLOSER: f64 = 0.1;
pub(super) const CLOSER_LARGE: f64 = 0.3;

/// A patient attempt on a large island begins where the one before it ended if the residual there is below this.
const NEAR: f64 = 1e-2;

/// An attempt on a large island that ended below this residual is gone on with from there, with a large ε: what it lacks are a few modes,
/// and another start would take all of the way again. Patient ones then need no block sweeps, which would lead far away ...
const CLOSE: f64 = 1e-4;
/// ... the others go on so often, as long as that leaves less than this part of the residual.
const CONTINUATIONS: u32 = 3;
const CLOSER_BY: f64 = 0.5;

/// Where the attempts on an island begin.
#[derive(Clone, Copy)]
pub(super) enum Start<'a> {
    /// From an earlier solution.
    Warm(&'a GivenStart),
    /// Without impulses.
    Zero,
    /// Without impulses, and with the attempts that follow a failure.
    Cold,
    /// From what Lemke's method found.
    Found(&'a GivenStart),
}

/// Runs the first two stages of the cascade on an island; the best of all attempts is what comes out. Attempt 0 starts from the
/// warm start if there is one, the later ones are cold.
pub(super) fn solve_island(
    solver: &mut IslandSolver,
    problem: &ContactProblem,
    cones: &Cones,
    island: &Island,
    settings: &SolverSettings,
    start: Start,
    outcome: &mut Outcome,
) {
    let first_attempt = u32::from(matches!(start, Start::Cold));
    // Nothing was tried before: what is enough is `accept`, and what may be jammed has one attempt before Lemke's method.
    let begins = matches!(start, Start::Warm(_) | Start::Zero);
    let large = island.units.len() >= LARGE;
    let may_jam = may_jam(island, cones);
    solver.brief = may_jam && begins;
    let restarts = match start {
        Start::Found(_) if !may_jam => 0,
        _ if solver.brief => 0,
        _ if large => settings.max_restarts.min(first_patient(island)) + 1,
        _ => settings.max_restarts,
    };
    let accept = if begins { settings.accept } else { closely_accepted(island, settings) };
    for attempt in first_attempt..=restarts.max(first_attempt) {
        solver.start(problem, island);
        if let (0, Start::Warm(given) | Start::Found(given)) = (attempt, start) {
            warm_start::load(solver, island, given);
            if settings.sleeping
                && matches!(start, Start::Warm(_))
                && let Some(residual) = solver.rest(problem, cones, island, settings)
            {
                (outcome.residual, outcome.asleep) = (residual, true);
                outcome.take(solver);
                return;
            }
        }
        if attempt > 0 && large && outcome.residual < NEAR {
            outcome.give(solver);
        }
        let patient = is_patient(island, attempt);
        solver.goes_on = patient && outcome.residual < CLOSE;
        let run = |solver: &mut IslandSolver| solver.run(problem, cones, island, settings, attempt);
        let in_impulses = solver.solve_in_impulses(problem, cones, island, settings);
        let residual = in_impulses.unwrap_or_else(|| run(solver));
        keep(solver, residual, outcome);
        if large && !patient {
            go_on(solver, problem, island, accept, outcome, run);
        }
        if outcome.residual <= accept || !solver.contradiction.is_empty() {
            outcome.contradiction.clone_from(&solver.contradiction);
            break;
        }
        outcome.restarts += 1;
    }
}

/// Goes on with an attempt on a large island that ended close to a solution; `attempt` runs it.
fn go_on(
    solver: &mut IslandSolver,
    problem: &ContactProblem,
    island: &Island,
    accept: f64,
    outcome: &mut Outcome,
    attempt: impl Fn(&mut IslandSolver) -> f64,
) {
    solver.goes_on = true;
    for _ in 0..CONTINUATIONS {
        let before = outcome.residual;
        if before <= accept || before > CLOSE || !solver.contradiction.is_empty() {
            break;
        }
        outcome.restarts += 1;
        solver.start(problem, island);
        outcome.give(solver);
        let residual = attempt(solver);
        keep(solver, residual, outcome);
        if outcome.residual > CLOSER_BY * before {
            break;
        }
    }
}

/// Keeps the best of all attempts, and counts them all.
fn keep(solver: &IslandSolver, residual: f64, outcome: &mut Outcome) {
    outcome.effort.add(solver.effort);
    if residual < outcome.residual {
        outcome.residual = residual;
        outcome.take(solver);
    }
}

/// Whether an island is small and has gaps that are violated: where its first attempt fails its contacts are often jammed or squeezed,
/// and Lemke's method has the next turn, which tells a solution from a ray. The other attempts follow where it does neither.
fn may_jam(island: &Island, cones: &Cones) -> bool {
    let rows = |unit: &u32| 2 + cones.direction_count(*unit as usize);
    island.units.len() < LARGE
        && island.offset[..island.contact_count].iter().any(|offset| offset[0] < 0.0)
        && island.units.iter().map(rows).sum::<usize>() <= QUICK_ROWS
}

/// The residual that islands have to reach after a solution that the certificate did not accept.
pub(super) fn closely_accepted(island: &Island, settings: &SolverSettings) -> f64 {
    if island.units.len() >= LARGE { CLOSER_LARGE * settings.accept } else { CLOSER * settings.accept }
}
