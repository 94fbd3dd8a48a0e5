//! What a polygon's solution misses of the circular cone's laws, contact by contact.

use super::law::CoulombLaw;
use crate::{ContactProblem, ContactSolution};

/// What the friction of one contact, taken from a polygon, misses of Coulomb's law at the velocity it slides with. All zero
/// where the contact is open, sticks, has no directions to choose from, or anisotropic friction, which is not Coulomb's.
///
/// With `c` the sliding velocity, `λ_T` the friction impulse, `R = μ λ_N` and `η` half the widest angle between neighbouring
/// directions of the polygon:
/// - the polygon's law gives `−cᵀλ_T = R max_k(−d_kᵀc)`, and some direction is within `η` of `−c`, so that
///   `R‖c‖ cos η ≤ −cᵀλ_T ≤ R‖c‖`;
/// - `λ_T` lies in the polygon, so that `‖λ_T‖ ≤ R` and the angle `θ` between `λ_T` and `−c` has
///   `cos θ = −cᵀλ_T / ‖λ_T‖‖c‖ ≥ cos η`;
/// - `‖λ_T + R c/‖c‖‖² = ‖λ_T‖² − 2R (−cᵀλ_T)/‖c‖ + R² ≤ 2R²(1 − cos η)`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ConeGap {
    /// Angle `θ` between the friction impulse and the opposite of the slip, rad.
    pub angle: f64,
    /// `η`: no solution with the contact's polygon has a larger angle, rad.
    pub angle_bound: f64,
    /// `μ λ_N ‖c‖ + cᵀλ_T ≥ 0`: energy that Coulomb's friction would dissipate beyond the polygon's in this step, J.
    pub missing_dissipation: f64,
    /// `μ λ_N ‖c‖ (1 − cos η)`: the largest it can be, J.
    pub missing_dissipation_bound: f64,
    /// `‖λ_T + μ λ_N c/‖c‖‖`: distance from Coulomb's friction at this normal impulse and slip, N·s.
    pub missing_impulse: f64,
    /// `2 μ λ_N sin(η/2)`: the largest it can be, N·s.
    pub missing_impulse_bound: f64,
}

/// The gaps between a polygon's solution and the laws of the circular cone, one for each contact.
///
/// - `problem`, `solution`: an LCP and its solution, as [`certify`](crate::certify) accepts it; only `velocity` and `impulse` are
///   read, and what they lack is no gap
///
/// # Source
/// Formulation §§2 and 9.
pub fn cone_gaps(problem: &ContactProblem, solution: &ContactSolution) -> Vec<ConeGap> {
    let sizes_fit = solution.velocity.len() == problem.nv() && solution.impulse.len() == problem.contact_count();
    let gap_of = |i: usize| if sizes_fit { contact_gap(problem, solution, i) } else { ConeGap::default() };
    (0..problem.contact_count()).map(gap_of).collect()
}

fn contact_gap(problem: &ContactProblem, solution: &ContactSolution, i: usize) -> ConeGap {
    let law = CoulombLaw::of(problem, i);
    let [_, c_1, c_2] = problem.contact_velocity(i, &solution.velocity);
    let [lambda_n, t_1, t_2] = solution.impulse[i];
    let (slip, radius, friction) = (c_1.hypot(c_2), law.friction() * lambda_n, t_1.hypot(t_2));
    if !law.is_circular() || problem.is_anisotropic(i) || slip == 0.0 || radius <= 0.0 {
        return ConeGap::default();
    }
    let power = c_1 * t_1 + c_2 * t_2;
    let eta = half_widest_angle(problem.directions_of(i));
    ConeGap {
        angle: if friction > 0.0 { (t_2 * c_1 - t_1 * c_2).atan2(-power).abs() } else { 0.0 },
        angle_bound: eta,
        missing_dissipation: (radius * slip + power).max(0.0),
        missing_dissipation_bound: radius * slip * (1.0 - eta.cos()),
        missing_impulse: (t_1 + radius * c_1 / slip).hypot(t_2 + radius * c_2 / slip),
        missing_impulse_bound: 2.0 * radius * (0.5 * eta).sin(),
    }
}

/// Half the widest angle between neighbours of a balanced set of directions, rad.
pub fn half_widest_angle(directions: &[[f64; 2]]) -> f64 {
    let widest = directions.iter().map(|d| {
        let following = directions.iter().map(|e| (d[0] * e[1] - d[1] * e[0]).atan2(d[0] * e[0] + d[1] * e[1]));
        // A balanced set has a next direction within half a turn of each.
        following.filter(|angle| *angle > 0.0).fold(std::f64::consts::PI, f64::min)
    });
    0.5 * widest.fold(0.0, f64::max)
}

/// A bound on the distance of a polygon's velocity `v` from the circular cone's `v*`, `‖v − v*‖_M = √((v−v*)ᵀM(v−v*))`, √J,
/// where friction does not change the normal impulses: `√(Σ_i e_i)` with `e_i` the missing dissipation.
///
/// Both velocities satisfy the momentum balance, so `‖v − v*‖²_M = Σ (λ − λ*)ᵀ(u − u*)` over the contacts, and bilateral rows add
/// nothing. Signorini's law makes the normal part `−λ_N u_N* − λ_N* u_N ≤ 0`. In the tangential part `λ_Tᵀc = −μλ_N‖c‖ + e`,
/// `λ_T*ᵀc* = −μλ_N*‖c*‖`, `−λ_Tᵀc* ≤ μλ_N‖c*‖` and `−λ_T*ᵀc ≤ μλ_N*‖c‖`, together
///
/// `‖v − v*‖²_M ≤ Σ_i e_i + Σ_i μ_i (λ_N,i − λ_N,i*)(‖c_i*‖ − ‖c_i‖)`.
///
/// The second sum vanishes where the normal impulses agree (friction does not shift the loads, and the loads are determinate),
/// and where all contacts have the same μ, the same slip and the same total load (a box that slides without turning). Elsewhere
/// it is the price of Coulomb's law being no minimum principle, and this value is an estimate, not a bound.
pub fn velocity_error_bound(gaps: &[ConeGap]) -> f64 {
    gaps.iter().map(|gap| gap.missing_dissipation).sum::<f64>().sqrt()
}
