//! The last stage of the cascade: lexicographic Lemke on an island's LCP.

use signorini_lcp::{Lemke, LemkeSettings, Method, Solution, Status};
use signorini_multibody::BlockDiagonal;

use super::island::Island;
use super::{Cones, SolveStatus, SolverSettings};
use crate::{ContactProblem, ContactSolution};

/// Solves an island by Lemke's method and takes its impulses if they are better than what is there (`residual`). Returns
/// the failure to report, if the island stays unsolved.
pub(super) fn solve_with_lemke(
    problem: &ContactProblem,
    cones: &Cones,
    island: &Island,
    settings: &SolverSettings,
    residual: f64,
    solution: &mut ContactSolution,
) -> Option<SolveStatus> {
    let Some(local) = local_problem(problem, island) else { return Some(SolveStatus::Inaccurate) };
    let at = local.standard_layout();
    if at.size > settings.lemke_max_rows {
        return Some(SolveStatus::Inaccurate);
    }
    let Some((outcome, size)) = run_lemke(&local, settings) else { return Some(SolveStatus::Inaccurate) };
    solution.report.lemke_islands += 1;
    solution.report.lemke_pivots += outcome.iterations as u32;
    if outcome.residual.value < residual && outcome.z.len() == size {
        take_impulses(&local, cones, island, &outcome.z, solution);
    }
    let contacts = |active: &dyn Fn(usize) -> bool| {
        let of_contact = |c: usize| {
            let directions = local.direction_offsets[c]..local.direction_offsets[c + 1];
            active(at.normal + c) || directions.into_iter().any(|k| active(at.tangential + k))
        };
        (0..local.contact_count()).filter(|&c| of_contact(c)).map(|c| island.contacts[c] as usize).collect()
    };
    match &outcome.status {
        Status::Solved => None,
        Status::Ray(ray) => {
            let size = ray.z.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
            Some(SolveStatus::Ray { contacts: contacts(&|k| ray.z[k].abs() > 1e-9 * size) })
        }
        Status::Infeasible(farkas) => {
            let size = farkas.y.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
            Some(SolveStatus::Infeasible { contacts: contacts(&|k| farkas.y[k].abs() > 1e-9 * size) })
        }
        Status::IterationLimit => Some(SolveStatus::IterationLimit),
        _ => Some(SolveStatus::Inaccurate),
    }
}

/// Runs Lemke's method on the standard LCP, or on the condensed one where there are bilateral rows.
fn run_lemke(local: &ContactProblem, settings: &SolverSettings) -> Option<(Solution, usize)> {
    let lemke_settings = LemkeSettings {
        tolerance: settings.accept,
        pivots_per_pair: settings.lemke_pivots_per_row,
        ..LemkeSettings::default()
    };
    let mut lemke = Lemke::new(lemke_settings).ok()?;
    if local.bilateral_violation.is_empty() {
        let lcp = local.standard_lcp().ok()?;
        return Some((lemke.solve(&lcp, None), lcp.len()));
    }
    let mixed = local.condensed_lcp().ok()?;
    Some((mixed.solve(&mut lemke, None), mixed.len()))
}

/// The island as a problem of its own, with its contacts and rows in the island's order.
fn local_problem(problem: &ContactProblem, island: &Island) -> Option<ContactProblem> {
    let mut dense = vec![0.0; island.nv() * island.nv()];
    island.add_mass(&problem.mass, &mut dense);
    let mass = BlockDiagonal::from_dense(island.nv(), &dense).ok()?;
    let mut free_velocity = Vec::new();
    island.gather(&problem.free_velocity, &mut free_velocity);
    let mut local = ContactProblem::new(mass, free_velocity, problem.timestep).ok()?;
    local.jacobian = island.jacobian.clone();
    local.bilateral_jacobian = island.bilateral_jacobian.clone();
    for &i in &island.contacts {
        let i = i as usize;
        local.gap.push(problem.gap[i]);
        local.friction.push(problem.friction[i]);
        local.directions.extend_from_slice(problem.directions_of(i));
        local.direction_offsets.push(local.directions.len());
    }
    local.bilateral_violation.extend(island.bilateral.iter().map(|&i| problem.bilateral_violation[i as usize]));
    Some(local)
}

fn take_impulses(local: &ContactProblem, cones: &Cones, island: &Island, z: &[f64], solution: &mut ContactSolution) {
    let at = local.standard_layout();
    for (c, &i) in island.contacts.iter().enumerate() {
        let alpha = &z[at.tangential + local.direction_offsets[c]..at.tangential + local.direction_offsets[c + 1]];
        let sum = |r: usize| local.directions_of(c).iter().zip(alpha).map(|(d, a)| d[r] * a).sum::<f64>();
        let impulse = [z[at.normal + c], sum(0), sum(1)];
        solution.impulse[i as usize] = impulse;
        solution.solver_modes[i as usize] = cones.mode_at(i as usize, impulse);
    }
    for (k, &i) in island.bilateral.iter().enumerate() {
        solution.bilateral[i as usize] = z[at.bilateral + k];
    }
    island.scatter(&island_velocity(local, solution, island), &mut solution.velocity);
}

/// `v^f + M⁻¹(Jᵀλ + J_Bᵀλ_B)` of the island.
fn island_velocity(local: &ContactProblem, solution: &ContactSolution, island: &Island) -> Vec<f64> {
    let mut velocity = vec![0.0; local.nv()];
    for (c, &i) in island.contacts.iter().enumerate() {
        local.jacobian.add_transposed(c, solution.impulse[i as usize], &mut velocity);
    }
    for (k, &i) in island.bilateral.iter().enumerate() {
        local.bilateral_jacobian.add_transposed(k, [solution.bilateral[i as usize]], &mut velocity);
    }
    local.mass_factor.solve_in_place(&mut velocity);
    velocity.iter_mut().zip(&local.free_velocity).for_each(|(v, f)| *v += f);
    velocity
}
