//! What a frame says of a step, taken into the problem that was built anew.

use signorini_contact::{ContactProblem, ContactSolution};
use signorini_multibody::glam::DVec3;
use signorini_multibody::{Model, State};
use signorini_recording::{Frame, Impulses, LimitFrame, PolygonCode, StepSolution};

use super::fault::StepFault;
use crate::warm::{joint_limit_key, tendon_limit_key};
use crate::workspace::Workspace;

/// Adds a recorded limit to the problem, where it is one that came in during the step. The limit of a ball joint is bounded about the axis that is
/// recorded, and in recordings of before schema version 6 about that of the velocity at the end.
pub(super) fn take_limit(
    limit: &LimitFrame,
    model: &Model,
    state: &State,
    velocity: &[f64],
    ws: &mut Workspace,
) -> Result<(), StepFault> {
    let index = limit.index as usize;
    let key = if limit.tendon { tendon_limit_key } else { joint_limit_key };
    let Some(axis) = limit.axis.map(DVec3::from) else {
        let key = key(index, u32::from(limit.upper));
        if ws.builder.keys.contains(&key) {
            return Ok(());
        }
        ws.builder.add_limits(model, &ws.kinematics, state, velocity, |other, _| *other == key);
        return Ok(());
    };
    if ws.builder.has_cone(index, axis) {
        return Ok(());
    }
    if limit.tendon || !axis.is_normalized() || !ws.builder.add_cone(model, state, index, axis) {
        return Err(StepFault::Unusable(format!("limit {index} with the axis {axis} is none of a ball joint")));
    }
    Ok(())
}

/// Limits what corrections the problem asks for to the part that the step's report says.
pub(super) fn take_corrections(solution: &StepSolution, ws: &mut Workspace) -> Result<(), StepFault> {
    ws.corrections.ask(&ws.builder.problem, ws.builder.bilateral_source.len());
    if let Some(theta) = solution.theta {
        if !(0.0..1.0).contains(&theta) {
            return Err(StepFault::Theta { theta });
        }
        let (all, contacts) = (solution.limited.is_empty(), ws.builder.problem.contact_count());
        let is_limited = |row: usize| all || solution.limited.binary_search(&(row as u32)).is_ok();
        ws.corrections.limit(is_limited, |k| is_limited(contacts + k));
        ws.corrections.set(theta, &mut ws.builder.problem);
    }
    let contacts = ws.builder.problem.contact_count();
    let is_listed = |k: usize| solution.limited.binary_search(&((contacts + k) as u32)).is_ok();
    ws.corrections.leave_listed(is_listed, &mut ws.builder.problem);
    if solution.clipped_gaps {
        ws.builder.clip_gaps();
    }
    Ok(())
}

/// The directions that a law of friction has turned, in place of those of the settings.
pub(super) fn take_directions(frame: &Frame, problem: &mut ContactProblem) -> Result<(), StepFault> {
    problem.directions.clear();
    problem.direction_offsets.clear();
    problem.direction_offsets.push(0);
    for i in 0..problem.contact_count() {
        if let Some(PolygonCode::Listed { start, count }) = frame.contacts.get(i).map(|contact| contact.polygon) {
            let listed = frame.listed_directions.iter().skip(start as usize).take(count as usize);
            problem.directions.extend(listed);
        }
        problem.direction_offsets.push(problem.directions.len());
    }
    take_group_directions(&frame.solution, 0, problem)
}

/// The directions of friction groups that a law of friction has turned, from recorded group `first` on.
pub(super) fn take_group_directions(
    solution: &StepSolution,
    first: usize,
    problem: &mut ContactProblem,
) -> Result<(), StepFault> {
    let groups = &mut problem.friction_groups;
    let counts = &solution.group_direction_counts;
    let (found, expected) = (counts.len().saturating_sub(first), groups.len());
    // They were not recorded before schema version 5, nor those of a decompression before version 6.
    if found > 0 {
        if found < expected {
            return Err(StepFault::Length { array: "directions of friction groups", expected, found });
        }
        let sum = |counts: &[u32]| counts.iter().map(|count| *count as usize).sum::<usize>();
        let (start, own) = (sum(&counts[..first]), &counts[first..first + expected]);
        groups.directions.clear();
        groups.directions.extend(solution.group_directions.iter().skip(start).take(sum(own)));
        groups.direction_offsets.truncate(1);
        let ends = own.iter().scan(0, |end, count| {
            *end += *count as usize;
            Some(*end)
        });
        groups.direction_offsets.extend(ends);
    }
    problem.check().map_err(|error| StepFault::Unusable(error.to_string()))
}

/// Recorded velocity and multipliers as a claimed solution of a problem; what the certificate does not read is computed from
/// them.
pub(super) fn take_solution(
    problem: &ContactProblem,
    recorded: &Impulses,
    solution: &mut ContactSolution,
) -> Result<(), StepFault> {
    let groups = &problem.friction_groups;
    for (array, found, expected) in [
        ("v⁺", recorded.velocity.len(), problem.nv()),
        ("λ_N", recorded.lambda_n.len(), problem.contact_count()),
        ("α", recorded.alpha.len(), problem.direction_count()),
        ("β", recorded.beta.len(), problem.contact_count()),
        ("λ_B", recorded.bilateral.len(), problem.bilateral_violation.len()),
        ("α_F", recorded.group_alpha.len(), groups.direction_count()),
        ("β_F", recorded.group_beta.len(), groups.len()),
    ] {
        if found != expected {
            return Err(StepFault::Length { array, expected, found });
        }
    }
    solution.velocity.clone_from(&recorded.velocity);
    solution.lambda_n.clone_from(&recorded.lambda_n);
    solution.alpha.clone_from(&recorded.alpha);
    solution.beta.clone_from(&recorded.beta);
    solution.bilateral.clone_from(&recorded.bilateral);
    solution.group_alpha.clone_from(&recorded.group_alpha);
    solution.group_beta.clone_from(&recorded.group_beta);
    let sum = |directions: &[[f64; 2]], alpha: &[f64]| {
        let along = |r: usize| directions.iter().zip(alpha).map(|(d, a)| d[r] * a).sum::<f64>();
        [along(0), along(1)]
    };
    solution.impulse.clear();
    solution.impulse.extend((0..problem.contact_count()).map(|i| {
        let alpha = &recorded.alpha[problem.direction_offsets[i]..problem.direction_offsets[i + 1]];
        let [t_1, t_2] = sum(problem.directions_of(i), alpha);
        [recorded.lambda_n[i], t_1, t_2]
    }));
    solution.group_impulse.clear();
    let of_groups =
        (0..groups.len()).map(|j| sum(groups.directions_of(j), &recorded.group_alpha[groups.direction_range(j)]));
    solution.group_impulse.extend(of_groups);
    Ok(())
}
