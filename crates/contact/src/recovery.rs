//! From impulses and velocity to a complete solution: `α`, `β` and the contact modes.

use crate::lists::raise;
use crate::projection::Cones;
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
pub fn recover_into(problem: &ContactProblem, cones: &Cones, velocity_scale: f64, solution: &mut ContactSolution) {
    recover_with(problem, cones, velocity_scale, |i, v| problem.contact_velocity(i, v), solution);
}

/// The same with the velocity of each contact at hand, as a function of its index and of `v⁺`.
#[inline]
pub fn recover_with(
    problem: &ContactProblem,
    cones: &Cones,
    velocity_scale: f64,
    contact_velocity: impl Fn(usize, &[f64]) -> [f64; 3],
    solution: &mut ContactSolution,
) {
    let slow = STICKING * velocity_scale;
    let ContactSolution { velocity, lambda_n, alpha, beta, modes, impulse, .. } = &mut *solution;
    alpha.fill(0.0);
    let mut rest = &mut alpha[..];
    let units = impulse.iter().zip(lambda_n).zip(beta).zip(modes).enumerate();
    for (i, (((&impulse, lambda_n), beta), mode)) in units {
        let [_, c_1, c_2] = contact_velocity(i, velocity);
        let directions = problem.directions_of(i);
        let own;
        (own, rest) = rest.split_at_mut(directions.len());
        let pair = cones.decompose(i, impulse, own);
        take_up_rounding(own, pair, problem.friction[i] * impulse[0]);
        *lambda_n = impulse[0];
        *beta = sliding_speed(directions, [c_1, c_2]);
        *mode = contact_mode(impulse[0], own, pair, *beta > slow, cones.friction(i) > 0.0);
    }
    recover_groups(problem, cones, slow, solution);
}

/// The same for the friction groups.
fn recover_groups(problem: &ContactProblem, cones: &Cones, slow: f64, solution: &mut ContactSolution) {
    let groups = &problem.friction_groups;
    solution.group_alpha.fill(0.0);
    for j in 0..groups.len() {
        let [s_1, s_2] = groups.slip(j, &solution.velocity);
        let speed = sliding_speed(groups.directions_of(j), [s_1, s_2]);
        let bound = groups.bound_at(j, &solution.lambda_n);
        if groups.jacobian.group(j).0.is_empty() {
            solution.group_impulse[j] = immovable_impulse(groups.directions_of(j), bound, [s_1, s_2]);
        }
        let [f_1, f_2] = solution.group_impulse[j];
        let alpha = &mut solution.group_alpha[groups.direction_range(j)];
        let pair = cones.decompose(problem.contact_count() + j, [bound, f_1, f_2], alpha);
        take_up_rounding(alpha, pair, bound);
        solution.group_beta[j] = speed;
        solution.group_modes[j] = contact_mode(bound, alpha, pair, speed > slow, true);
    }
}

/// `max_k(−d_kᵀ c)`, 0 if that is less or no number.
fn sliding_speed(directions: &[[f64; 2]], c: [f64; 2]) -> f64 {
    let mut speed = 0.0;
    directions.iter().for_each(|d| raise(&mut speed, -(d[0] * c[0] + d[1] * c[1])));
    speed
}

/// Makes the sum of multipliers that are at the bound equal to it, without rounding and in any order: with large impulses a last
/// digit is a velocity. `pair`: the two that may differ from zero.
fn take_up_rounding(alpha: &mut [f64], pair: Option<[usize; 2]>, bound: f64) {
    let Some([a, b]) = pair else { return };
    if bound <= 0.0 || (bound - (alpha[a] + alpha[b])).abs() > AT_BOUND * bound {
        return;
    }
    let [largest, other] = larger_first(alpha, [a, b]);
    if alpha[other] > 0.0 {
        // The larger one is at least half the bound: the difference is exact.
        alpha[largest] = alpha[largest].clamp(0.5 * bound, bound);
        alpha[other] = bound - alpha[largest];
    } else {
        alpha[largest] = bound;
    }
}

/// Of two multipliers the larger one first, of equal ones that of the lower index.
fn larger_first(alpha: &[f64], [a, b]: [usize; 2]) -> [usize; 2] {
    if alpha[b] > alpha[a] || alpha[b] == alpha[a] && b < a { [b, a] } else { [a, b] }
}

/// The impulse of a group that moves nothing, at its bound along the direction most against the slip; none without slip.
fn immovable_impulse(directions: &[[f64; 2]], bound: f64, slip: [f64; 2]) -> [f64; 2] {
    let against = |d: &[f64; 2]| -(d[0] * slip[0] + d[1] * slip[1]);
    let best = directions.iter().max_by(|a, b| against(a).total_cmp(&against(b)));
    best.filter(|d| against(d) > 0.0).map_or([0.0; 2], |d| d.map(|x| bound * x))
}

/// `bound`: the normal impulse of a contact, the bound of a friction group; `pair`: the multipliers that may differ from zero.
fn contact_mode(bound: f64, alpha: &[f64], pair: Option<[usize; 2]>, slides: bool, frictional: bool) -> ContactMode {
    if bound <= 0.0 {
        return ContactMode::Open;
    }
    if !frictional {
        return ContactMode::Frictionless;
    }
    if !slides {
        return ContactMode::Sticking;
    }
    let Some(pair) = pair else { return ContactMode::Sliding { k: 0 } };
    let [first, second] = larger_first(alpha, pair);
    if alpha[second] > STICKING * alpha[first] {
        ContactMode::SlidingBetween { j: first.min(second) as u32, k: first.max(second) as u32 }
    } else {
        ContactMode::Sliding { k: if alpha[first] > 0.0 { first as u32 } else { 0 } }
    }
}
