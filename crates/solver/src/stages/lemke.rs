//! Lexicographic Lemke on an island's LCP: it ends in a solution, or on a ray where the contacts wedge.

use signorini_contact::{ContactProblem, ContactSolution, FrictionPolygon, SolveStatus, StageOutcome};
use signorini_lcp::{Lemke, LemkeSettings};
use signorini_multibody::BlockDiagonal;

use super::shared::{Outcome, Shared};
use crate::islands::Island;
use crate::iterate::Iterate;
use crate::lcp_route::{self, solve_corrected};
use crate::residual::RESIDUALS;
use crate::settings::SolverSettings;
use crate::task::{Look, SIZES, Task};

/// What is tuned in this stage.
struct Tuning {
    /// What counts as zero at the second look, relative to the largest entry of a column: almost equal contacts have pivots that are
    /// no larger than what is otherwise rounding.
    smallest_pivot: f64,
    /// Covering vectors of LCPs with no more rows than a large island has units: where gaps are violated one path may end on a ray and
    /// another one at a solution. Each path finds fewer of the solutions that are left, the ninth those of about one problem in a thousand.
    covering_vectors: u32,
}

/// Chosen by: `random_steps --seeds 0..300000`, 21 November 2026; `smallest_pivot` by the stored cases 2157082_1 and 613293_0.
const TUNING: Tuning = Tuning { smallest_pivot: 1e-14, covering_vectors: 13 };

/// What the laws lack by more than the tolerance, in an island that is not too large, and where more digits can be had.
pub(super) fn applies(task: &Task, iterate: &Iterate) -> bool {
    let is_enough = match task.look {
        Look::Only | Look::Part => return false,
        // What is cut short there, and is not near, mostly has no solution; and a pivot of many rows costs as much as an iteration.
        Look::Short if iterate.residual > RESIDUALS.far || rows(task) + task.island.bilateral.len() > SIZES.costly => {
            return false;
        }
        Look::Short => task.accept(),
        Look::First if task.is_large() => RESIDUALS.far,
        Look::First => task.settings.tolerance,
        Look::Second => task.accept(),
    };
    task.settings.budget.is_none()
        && iterate.residual > is_enough
        && rows(task) <= task.settings.lemke_max_rows
        && !iterate.is_out_of_digits(task.problem, task.island, task.settings.tolerance)
}

/// Takes what Lemke's method finds if it is better, or its denial.
pub(super) fn run(lemke: &mut Lemke, shared: &mut Shared, task: &Task, iterate: &mut Iterate) -> Outcome {
    let found = local_problem(task.problem, task.island).and_then(|local| {
        // The proximal iterations go on from what one correction leaves; at a short look nothing goes on.
        solve(lemke, &local, task.settings, task.look, u32::from(task.look != Look::Short))
    });
    let Some(found) = found else {
        return Outcome { why: StageOutcome::Failed, status: Some(SolveStatus::Inaccurate) };
    };
    shared.map.effort.pivots += found.report.lemke_pivots;
    if found.certificate.worst() < iterate.residual {
        take_solution(task, &found, iterate);
    }
    let global = |contacts: Vec<usize>| contacts.into_iter().map(|c| task.island.units[c] as usize).collect();
    let (why, status) = match found.status {
        SolveStatus::Solved => (StageOutcome::Solved, None),
        SolveStatus::Ray { contacts } => (StageOutcome::Denied, Some(SolveStatus::Ray { contacts: global(contacts) })),
        SolveStatus::Infeasible { contacts } => {
            (StageOutcome::Denied, Some(SolveStatus::Infeasible { contacts: global(contacts) }))
        }
        other => (StageOutcome::Failed, Some(other)),
    };
    Outcome { why, status }
}

/// Lemke's solution of a whole problem with bounds that the other stages do not know; nothing if the problem is too large for it or its
/// data are not those of a problem.
pub(crate) fn solve_whole(
    lemke: &mut Lemke,
    problem: &ContactProblem,
    settings: &SolverSettings,
) -> Option<ContactSolution> {
    if problem.standard_layout().size > settings.lemke_max_rows {
        return None;
    }
    let first = solve(lemke, problem, settings, Look::First, lcp_route::TUNING.corrections)?;
    if !matches!(first.status, SolveStatus::Inaccurate | SolveStatus::IterationLimit) {
        return Some(first);
    }
    let second = solve(lemke, problem, settings, Look::Second, lcp_route::TUNING.corrections)?;
    Some(if second.certificate.worst() < first.certificate.worst() { second } else { first })
}

/// Rows of the island's LCP.
fn rows(task: &Task) -> usize {
    let (problem, island) = (task.problem, task.island);
    let of_contact = |&i: &u32| 2 + problem.directions_of(i as usize).len();
    let of_group = |&i: &u32| 1 + problem.friction_groups.directions_of(i as usize - problem.contact_count()).len();
    let (contacts, groups) = island.units.split_at(island.contact_count);
    contacts.iter().map(of_contact).sum::<usize>() + groups.iter().map(of_group).sum::<usize>()
}

/// Lemke's method at the first look with the solver's settings, at the second one with its own, which polish longer and take pivots as
/// small as they come.
fn solve(
    lemke: &mut Lemke,
    problem: &ContactProblem,
    settings: &SolverSettings,
    look: Look,
    corrections: u32,
) -> Option<ContactSolution> {
    let (part, usual) = (part_of_velocities(problem, settings.accept()), LemkeSettings::default());
    let all = usual.clone().with_covering_vectors(covering_vectors(problem.standard_layout().size));
    let lemke_settings = match look {
        // One path: one that ends mostly takes between a half and twice as many pivots as there are rows. Of 277 short looks at mixers, grooves,
        // necklaces, drums and houses it solved 83 and one with finer ties 41; regularised problems and corrections solved none.
        Look::Short => usual
            .clone()
            .with_covering_vectors(1)
            .with_tolerance(part * settings.accept())
            .with_pivots_per_pair(2)
            .with_regularizes(false),
        Look::First | Look::Only | Look::Part => {
            all.with_tolerance(part * settings.accept()).with_pivots_per_pair(settings.lemke_pivots_per_row)
        }
        Look::Second => all.with_tolerance(part * usual.tolerance).with_pivot(TUNING.smallest_pivot),
    };
    lemke.set(lemke_settings).ok()?;
    solve_corrected(problem, lemke, settings.tolerance, corrections).ok()
}

fn take_solution(task: &Task, found: &ContactSolution, iterate: &mut Iterate) {
    let groups = found.group_impulse.iter().map(|&[a, b]| [0.0, a, b]);
    iterate.impulse.clear();
    iterate.impulse.extend(found.impulse.iter().copied().chain(groups));
    iterate.set_bounds(task.problem, task.island);
    iterate.bilateral.clone_from(&found.bilateral);
    iterate.modes.clone_from(&found.solver_modes);
    iterate.velocity.clone_from(&found.velocity);
    iterate.residual = found.certificate.worst();
}

fn covering_vectors(size: usize) -> u32 {
    if size <= SIZES.large { TUNING.covering_vectors } else { LemkeSettings::default().covering_vectors }
}

/// The velocity scale relative to the largest entry of the LCP's right-hand side, which the method's tolerance is relative to: that
/// has the constant bounds of friction groups in it, too, which are impulses and may be as large as they like. Parts that would leave
/// less than rounding of what is accepted are none.
fn part_of_velocities(problem: &ContactProblem, accept: f64) -> f64 {
    let bounds = problem.friction_groups.bound.iter().map(|bound| bound.constant().abs());
    let largest = problem.delassus_scale() * bounds.fold(0.0, f64::max);
    let velocity = problem.velocity_scale();
    if largest > velocity { (velocity / largest).max(f64::EPSILON / accept) } else { 1.0 }
}

/// The island as a problem of its own, with its contacts and rows in the island's order.
fn local_problem(problem: &ContactProblem, island: &Island) -> Option<ContactProblem> {
    let mut dense = vec![0.0; island.nv() * island.nv()];
    island.add_mass(&problem.mass, &mut dense);
    let mass = BlockDiagonal::from_dense(island.nv(), &dense).ok()?;
    let mut free_velocity = Vec::new();
    island.gather(&problem.free_velocity, &mut free_velocity);
    let mut local = ContactProblem::new(mass, free_velocity, problem.timestep).ok()?;
    local.bilateral_jacobian = island.bilateral_jacobian.clone();
    let contacts = &island.units[..island.contact_count];
    // The columns of contacts are those of the island's units; a group's also have what bounds it.
    local.jacobian.clear();
    for (c, &i) in contacts.iter().enumerate() {
        let (i, (columns, entries)) = (i as usize, island.jacobian.group(c));
        local.jacobian.push(columns.iter().copied().zip(entries.iter().copied()));
        local.gap.push(problem.gap[i]);
        local.friction.push(problem.friction[i]);
        local.directions.extend_from_slice(problem.directions_of(i));
        local.direction_offsets.push(local.directions.len());
    }
    for c in island.contact_count..island.units.len() {
        let j = island.units[c] as usize - problem.contact_count();
        let (columns, entries) = island.jacobian.group(c);
        let groups = &problem.friction_groups;
        let bound = groups.bound[j].within(|contact| contacts.binary_search(&(contact as u32)).ok());
        let polygon = FrictionPolygon::from_directions(groups.directions_of(j).to_vec()).ok()?;
        let rows = columns.iter().zip(entries).map(|(&k, e)| (k, [e[1], e[2]]));
        local.push_friction(rows, groups.target[j], bound, &polygon);
    }
    local.bilateral_violation.extend(island.bilateral.iter().map(|&i| problem.bilateral_violation[i as usize]));
    Some(local)
}
