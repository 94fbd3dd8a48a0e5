//! From impulses and velocity to a complete solution: `α`, `β` and the contact modes.

use crate::scales::raise;
use crate::solver::Cones;
use crate::{ContactMode, ContactProblem, ContactSolution};

/// Contacts slower than this fraction of the data's velocity scale stick.
const STICKING: f64 = 1e-9;
/// Friction this close to its bound, relative to it, is at the bound: the projection and the split round.
const AT_BOUND: f64 = 16.0 * f64::EPSILON;

/// Fills `lambda_n`, `alpha`, `beta` and `modes` of a solution, of contacts and friction groups, from the impulses and
/// `velocity`.
///
/// `α` splits `λ_T` over the two directions that enclose it; `β = max_k(−d_kᵀ c_T)`, the
/// sliding speed seen by the polygon, is the smallest multiplier that `w_α ≥ 0` admits.
/// `velocity_scale`: [`ContactProblem::velocity_scale`], m/s.
pub(crate) fn recover_into(
    problem: &ContactProblem,
    cones: &Cones,
    velocity_scale: f64,
    solution: &mut ContactSolution,
) {
    let slow = STICKING * velocity_scale;
    for i in 0..problem.contact_count() {
        let impulse = solution.impulse[i];
        let [_, c_1, c_2] = problem.contact_velocity(i, &solution.velocity);
        let directions = problem.directions_of(i);
        let speed = sliding_speed(directions, [c_1, c_2]);
        let range = problem.direction_offsets[i]..problem.direction_offsets[i + 1];
        let alpha = &mut solution.alpha[range];
        cones.decompose(i, impulse, alpha);
        take_up_rounding(alpha, problem.friction[i] * impulse[0]);
        solution.lambda_n[i] = impulse[0];
        solution.beta[i] = speed;
        solution.modes[i] = contact_mode(impulse[0], alpha, speed > slow, cones.friction(i) > 0.0);
    }
    recover_groups(problem, cones, slow, solution);
}

/// The same for the friction groups.
fn recover_groups(problem: &ContactProblem, cones: &Cones, slow: f64, solution: &mut ContactSolution) {
    let groups = &problem.friction_groups;
    for j in 0..groups.len() {
        let [s_1, s_2] = groups.slip(j, &solution.velocity);
        let speed = sliding_speed(groups.directions_of(j), [s_1, s_2]);
        let bound = groups.bound_at(j, &solution.lambda_n);
        if groups.jacobian.group(j).0.is_empty() {
            solution.group_impulse[j] = immovable_impulse(groups.directions_of(j), bound, [s_1, s_2]);
        }
        let [f_1, f_2] = solution.group_impulse[j];
        let alpha = &mut solution.group_alpha[groups.direction_range(j)];
        cones.decompose(problem.contact_count() + j, [bound, f_1, f_2], alpha);
        take_up_rounding(alpha, bound);
        solution.group_beta[j] = speed;
        solution.group_modes[j] = contact_mode(bound, alpha, speed > slow, true);
    }
}

/// `max_k(−d_kᵀ c)`, 0 if that is less or no number.
fn sliding_speed(directions: &[[f64; 2]], c: [f64; 2]) -> f64 {
    let mut speed = 0.0;
    directions.iter().for_each(|d| raise(&mut speed, -(d[0] * c[0] + d[1] * c[1])));
    speed
}

/// Makes the sum of multipliers that are at the bound equal to it, without rounding and in any order: with large impulses a last
/// digit is a velocity.
fn take_up_rounding(alpha: &mut [f64], bound: f64) {
    let sum: f64 = alpha.iter().sum();
    if bound <= 0.0 || (bound - sum).abs() > AT_BOUND * bound {
        return;
    }
    let largest = (0..alpha.len()).fold(0, |best, k| if alpha[k] > alpha[best] { k } else { best });
    let other = (0..alpha.len()).find(|&k| k != largest && alpha[k] > 0.0);
    match other {
        // The larger one is at least half the bound: the difference is exact.
        Some(other) => {
            alpha[largest] = alpha[largest].clamp(0.5 * bound, bound);
            alpha[other] = bound - alpha[largest];
        }
        None => alpha[largest] = bound,
    }
}

/// The impulse of a group that moves nothing, at its bound along the direction most against the slip; none without slip.
fn immovable_impulse(directions: &[[f64; 2]], bound: f64, slip: [f64; 2]) -> [f64; 2] {
    let against = |d: &[f64; 2]| -(d[0] * slip[0] + d[1] * slip[1]);
    let best = directions.iter().max_by(|a, b| against(a).total_cmp(&against(b)));
    best.filter(|d| against(d) > 0.0).map_or([0.0; 2], |d| d.map(|x| bound * x))
}

/// `bound`: the normal impulse of a contact, the bound of a friction group.
fn contact_mode(bound: f64, alpha: &[f64], slides: bool, frictional: bool) -> ContactMode {
    if bound <= 0.0 {
        return ContactMode::Open;
    }
    if !frictional {
        return ContactMode::Frictionless;
    }
    if !slides {
        return ContactMode::Sticking;
    }
    let (mut first, mut second) = (0, None);
    for (k, &a) in alpha.iter().enumerate() {
        if a > alpha[first] {
            first = k;
        }
    }
    for (k, &a) in alpha.iter().enumerate() {
        if k != first && a > STICKING * alpha[first] {
            second = Some(k);
        }
    }
    match second {
        None => ContactMode::Sliding { k: first as u32 },
        Some(k) => ContactMode::SlidingBetween { j: first.min(k) as u32, k: first.max(k) as u32 },
    }
}
