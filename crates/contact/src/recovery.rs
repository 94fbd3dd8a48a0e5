//! From impulses and velocity to a complete solution: `α`, `β` and the contact modes.

use crate::solver::Cones;
use crate::{ContactMode, ContactProblem, ContactSolution};

/// Contacts slower than this fraction of the data's velocity scale stick.
const STICKING: f64 = 1e-9;

/// Fills `lambda_n`, `alpha`, `beta` and `modes` of a solution from `impulse` and `velocity`.
///
/// `α` splits `λ_T` over the two directions that enclose it; `β = max_k(−d_kᵀ c_T)`, the
/// sliding speed seen by the polygon, is the smallest multiplier that `w_α ≥ 0` admits.
pub(crate) fn recover_into(problem: &ContactProblem, cones: &Cones, solution: &mut ContactSolution) {
    let slow = STICKING * problem.velocity_scale();
    for i in 0..problem.contact_count() {
        let impulse = solution.impulse[i];
        let [_, c_1, c_2] = problem.contact_velocity(i, &solution.velocity);
        let directions = problem.directions_of(i);
        let speed = directions.iter().map(|d| -(d[0] * c_1 + d[1] * c_2)).fold(0.0, f64::max);
        let range = problem.direction_offsets[i]..problem.direction_offsets[i + 1];
        let alpha = &mut solution.alpha[range];
        cones.decompose(i, impulse, alpha);
        solution.lambda_n[i] = impulse[0];
        solution.beta[i] = speed;
        solution.modes[i] = contact_mode(impulse[0], alpha, speed > slow, cones.friction(i) > 0.0);
    }
}

fn contact_mode(lambda_n: f64, alpha: &[f64], slides: bool, frictional: bool) -> ContactMode {
    if lambda_n <= 0.0 {
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
