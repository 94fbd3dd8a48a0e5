//! The proof that nothing balances the loads.

use super::units::{friction_units, rounding};
use crate::ContactProblem;

/// What a virtual motion shows.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct MechanismCertificate {
    /// Power of the loads along the motion beyond what friction with constant bounds can take from it, less a bound on its rounding;
    /// per unit of time step: impulse times velocity, J.
    pub power: f64,
    /// The fastest that the motion closes a contact or breaks a constraint, the friction of the contact counted against it and bounds on
    /// rounding included, m/s or rad/s; 0 where it opens every contact.
    pub violation: f64,
    /// Contact impulses (normal impulses and those of constraints together) are at least this if they balance the loads, N·s; infinite
    /// where no impulses do, whatever their size, and 0 where the motion proves nothing.
    pub required_impulse: f64,
    /// The largest entry of the loads' impulse by the required impulse: 0 for a proof without any condition.
    pub residual: f64,
}

/// Judges a virtual motion as the proof that no admissible impulses balance the loads.
///
/// For every admissible `λ`, `νᵀ(p + Jᵀλ) ≥ power + Σ λ_N,i o_i + λ_Bᵀ J_B ν`, where `o_i = c_N − μ h(c_T)` is how fast the motion opens
/// contact `i` after all that friction can take from it (`h(c) = max_k −d_kᵀc`). Where every `o_i ≥ 0`, `J_B ν = 0` and the power is
/// positive, the left side cannot be zero. What is negative by rounding is said as the impulses that a balance would need.
///
/// - `motion`: ν, `[nv]`, m/s or rad/s
///
/// # Source
/// Farkas' lemma for the polyhedral cone of admissible impulses; the sums with bounds on their rounding.
pub fn certify_mechanism(problem: &ContactProblem, motion: &[f64]) -> MechanismCertificate {
    let proves_nothing =
        MechanismCertificate { power: 0.0, violation: 0.0, required_impulse: 0.0, residual: f64::INFINITY };
    if motion.len() != problem.nv() || !motion.iter().all(|x| x.is_finite()) {
        return proves_nothing;
    }
    let mut load = vec![0.0; problem.nv()];
    problem.mass.multiply_into(&problem.free_velocity, &mut load);
    let terms: f64 = motion.iter().zip(&load).map(|(x, p)| (x * p).abs()).sum();
    let mut power: f64 = motion.iter().zip(&load).map(|(x, p)| x * p).sum();
    power -= rounding(problem.nv(), terms);
    let mut opening: Vec<f64> = (0..problem.contact_count())
        .map(|i| {
            let ([normal, ..], terms) = problem.jacobian.multiply_with_terms(i, motion);
            normal - rounding(problem.jacobian.group(i).0.len(), terms)
        })
        .collect();
    for unit in friction_units(problem) {
        let (slip, rounded) = unit.slip(problem, motion);
        let longest = unit.directions.iter().map(|d| d[0].hypot(d[1])).fold(0.0, f64::max);
        let resistance = unit.resistance(slip) + 2.0 * longest * rounded;
        power -= unit.constant * resistance;
        if let Some((contact, coefficient)) = unit.normal {
            opening[contact] -= coefficient * resistance * (1.0 + 4.0 * f64::EPSILON);
        }
    }
    let closing = opening.iter().map(|o| -o);
    let broken = (0..problem.bilateral_violation.len()).map(|k| {
        let ([rate], terms) = problem.bilateral_jacobian.multiply_with_terms(k, motion);
        rate.abs() + rounding(problem.bilateral_jacobian.group(k).0.len(), terms)
    });
    let violation = closing.chain(broken).fold(0.0, f64::max);
    if !(power > 0.0 && violation.is_finite()) {
        return MechanismCertificate { power, violation, ..proves_nothing };
    }
    let size = load.iter().fold(0.0, |a: f64, p| a.max(p.abs()));
    let required_impulse = power / violation;
    MechanismCertificate { power, violation, required_impulse, residual: size * violation / power }
}
