//! The last stage of the cascade: lexicographic Lemke on an island's LCP.

use signorini_lcp::{Lemke, LemkeSettings};
use signorini_multibody::BlockDiagonal;

use super::SolverSettings;
use super::island::Island;
use crate::lcp_route::{CORRECTIONS, solve_corrected};
use signorini_contact::{ContactProblem, ContactSolution, FrictionPolygon, SolveStatus};

/// What counts as zero, relative to the largest entry, when a column is looked at a second time.
const SMALLEST_PIVOT: f64 = 1e-14;
/// Rows of an LCP that costs Lemke's method no more than the other attempts on an island.
pub(super) const QUICK_ROWS: usize = 128;
/// Covering vectors in problems of so many rows at most: where gaps are violated one path may end on a ray and another one at a
/// solution. Each path finds fewer of the solutions that are left, the ninth those of about one problem in a thousand; in very small
/// problems a few more cost little.
const COVERING_VECTORS: [(usize, u32); 2] = [(24, 13), (64, 9)];
/// A smaller part of a tolerance is rounding.
const SMALLEST_PART: f64 = 1e-6;

/// Solves an island by Lemke's method and takes its impulses if they are better than what is there (`residual`). Returns
/// the failure to report, if the island stays unsolved.
pub(super) fn solve_with_lemke(
    lemke: &mut Lemke,
    problem: &ContactProblem,
    island: &Island,
    settings: &SolverSettings,
    residual: f64,
    solution: &mut ContactSolution,
) -> Option<SolveStatus> {
    let Some(local) = solve_local(lemke, problem, island, settings) else { return Some(SolveStatus::Inaccurate) };
    solution.report.lemke_islands += 1;
    solution.report.lemke_pivots += local.report.lemke_pivots;
    if local.certificate.worst() < residual {
        let groups = local.group_impulse.iter().map(|&[a, b]| [0.0, a, b]);
        for (c, p) in local.impulse.iter().copied().chain(groups).enumerate() {
            solution.take_unit(island.units[c] as usize, p, local.solver_modes[c]);
        }
        for (k, &i) in island.bilateral.iter().enumerate() {
            solution.bilateral[i as usize] = local.bilateral[k];
        }
        island.scatter(&local.velocity, &mut solution.velocity);
    }
    let global = |contacts: Vec<usize>| contacts.into_iter().map(|c| island.units[c] as usize).collect();
    match local.status {
        SolveStatus::Solved => None,
        SolveStatus::Ray { contacts } => Some(SolveStatus::Ray { contacts: global(contacts) }),
        SolveStatus::Infeasible { contacts } => Some(SolveStatus::Infeasible { contacts: global(contacts) }),
        other => Some(other),
    }
}

/// Lemke's solution of a whole problem with bounds that the first two stages do not know; nothing if the problem is too large
/// for it or its data are not those of a problem.
pub(super) fn solve_whole(
    lemke: &mut Lemke,
    problem: &ContactProblem,
    settings: &SolverSettings,
) -> Option<ContactSolution> {
    if problem.standard_layout().size > settings.lemke_max_rows {
        return None;
    }
    solve_patiently(lemke, problem, settings, CORRECTIONS)
}

/// Lemke's method with the solver's settings and, where the certificate does not hold or theory promises a solution that was not
/// found, with its own, which polish longer, from more covering vectors and with pivots as small as they come: almost equal contacts
/// have pivots that are no larger than what is otherwise rounding.
fn solve_patiently(
    lemke: &mut Lemke,
    problem: &ContactProblem,
    settings: &SolverSettings,
    corrections: u32,
) -> Option<ContactSolution> {
    let part = part_of_velocities(problem);
    let covering_vectors = covering_vectors(problem.standard_layout().size);
    let first_settings = LemkeSettings::default()
        .with_tolerance(part * settings.accept)
        .with_pivots_per_pair(settings.lemke_pivots_per_row)
        .with_covering_vectors(covering_vectors);
    lemke.set(first_settings).ok()?;
    let first = solve_corrected(problem, lemke, settings.tolerance, corrections).ok()?;
    if !matches!(first.status, SolveStatus::Inaccurate | SolveStatus::IterationLimit) {
        return Some(first);
    }
    let usual = LemkeSettings::default();
    let second_settings = usual
        .clone()
        .with_tolerance(part * usual.tolerance)
        .with_pivot(SMALLEST_PIVOT)
        .with_covering_vectors(covering_vectors);
    lemke.set(second_settings).ok()?;
    let second = solve_corrected(problem, lemke, settings.tolerance, corrections).ok()?;
    Some(if second.certificate.worst() < first.certificate.worst() { second } else { first })
}

fn covering_vectors(size: usize) -> u32 {
    let enough = COVERING_VECTORS.iter().find(|(rows, _)| size <= *rows);
    enough.map_or(LemkeSettings::default().covering_vectors, |(_, count)| *count)
}

/// The velocity scale relative to the largest entry of the LCP's right-hand side, which the method's tolerance is relative to: that
/// has the constant bounds of friction groups in it, too, which are impulses and may be as large as they like.
fn part_of_velocities(problem: &ContactProblem) -> f64 {
    let bounds = problem.friction_groups.bound.iter().map(|bound| bound.constant().abs());
    let largest = problem.delassus_scale() * bounds.fold(0.0, f64::max);
    let velocity = problem.velocity_scale();
    if largest > velocity { (velocity / largest).max(SMALLEST_PART) } else { 1.0 }
}

/// Lemke's solution of the island as a problem of its own; nothing if the island is too large for it or its data are
/// not those of a problem.
fn solve_local(
    lemke: &mut Lemke,
    problem: &ContactProblem,
    island: &Island,
    settings: &SolverSettings,
) -> Option<ContactSolution> {
    let local = local_problem(problem, island)?;
    if local.standard_layout().size > settings.lemke_max_rows {
        return None;
    }
    // The iterations go on from what one correction leaves.
    solve_patiently(lemke, &local, settings, 1)
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
