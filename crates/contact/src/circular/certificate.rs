//! The certificate of a solution with the circular cone, computed from the data alone (formulation §§8 and 9).

use super::ConeSolution;
use super::law::CoulombLaw;
use crate::ContactProblem;
use crate::momentum::{Scratch, needs_terms};
use crate::problem_file::FrictionalProblem;
use crate::residuals::{Certificate, keep, natural};

/// Certifies a claimed solution `(v⁺, λ, λ_B, λ_F)` with the circular cone; only these of `solution` are read.
///
/// - `problem`: the data. Of each contact's directions only this matters: none means no friction, two opposite ones friction
///   along their line, more friction in all tangential directions, and likewise for friction groups, whose impulse lies in the disc
///   (the interval) of radius `r`. Where it has friction that the circular cone has no law
///   for ([`ContactProblem::check_circular`]), every residual is infinite.
/// - `solution`: arrays of the problem's sizes; a missing entry, or one that is not finite, makes every residual infinite.
///
/// # Source
/// Formulation §§8 and 9; G. De Saxcé, Z.-Q. Feng. The bipotential method. Math. Comput. Modelling 28 (1998).
pub fn certify_cone(problem: &ContactProblem, solution: &ConeSolution) -> Certificate {
    certify_cone_with(problem, solution, &mut Scratch::default())
}

/// [`certify_cone`] in memory at hand.
pub fn certify_cone_with(problem: &ContactProblem, solution: &ConeSolution, scratch: &mut Scratch) -> Certificate {
    let groups = &problem.friction_groups;
    let contacts = solution.velocity.iter().chain(&solution.bilateral).chain(solution.impulse.iter().flatten());
    let mut numbers = contacts.chain(solution.group_impulse.iter().flatten());
    if !solution.fits(problem) || numbers.any(|x| !x.is_finite()) || problem.check_circular().is_err() {
        return Certificate::everything_violated();
    }
    let scales = scratch.scales(problem, cone_velocity_scale(problem));
    let (g, s) = (scales.delassus, scales.velocity);
    scratch.resize(problem.nv());
    scratch.add_forces(problem, |i| solution.impulse[i], &solution.bilateral, |j| solution.group_impulse[j]);
    let mut momentum = scratch.balance(problem, &solution.velocity, s);
    if needs_terms(momentum) {
        scratch.add_terms(problem, |i| solution.impulse[i], &solution.bilateral, |j| solution.group_impulse[j]);
        momentum = scratch.balance_beside_terms(problem, s);
    }
    let mut raw = Certificate { momentum, ..Default::default() };
    for (i, lambda) in solution.impulse.iter().enumerate() {
        let [n, t_1, t_2] = problem.jacobian.multiply_pairs(i, &scratch.both);
        let gap_rate = problem.gap[i] / problem.timestep;
        let [given, claimed] = [0, 1].map(|k| [n[k] + gap_rate, t_1[k], t_2[k]]);
        contact_laws(&mut raw, &CoulombLaw::of(problem, i), *lambda, given, claimed, g);
    }
    for (j, [f_1, f_2]) in solution.group_impulse.iter().enumerate() {
        let (t_1_2, [u_1, u_2]) = (groups.jacobian.multiply_pairs(j, &scratch.both), groups.target[j]);
        let [given, claimed] = [0, 1].map(|k| [0.0, t_1_2[0][k] - u_1, t_1_2[1][k] - u_2]);
        let r = groups.bound[j].at(|contact| solution.impulse[contact][0]);
        group_laws(&mut raw, &CoulombLaw::of_group(problem, j), [[0.0, *f_1, *f_2], given, claimed], r, g, s);
    }
    for (k, theta) in problem.bilateral_violation.iter().enumerate() {
        let [[given, claimed]] = problem.bilateral_jacobian.multiply_pairs(k, &scratch.both);
        keep(&mut raw.natural_map, (given + theta / problem.timestep).abs());
        keep(&mut raw.bilateral, (claimed + theta / problem.timestep).abs());
    }
    scales.normalise(problem, &solution.velocity, raw)
}

/// Adds one contact's laws, in velocities and impulses: impulse, velocity that the impulses give, claimed velocity.
fn contact_laws(raw: &mut Certificate, law: &CoulombLaw, lambda: [f64; 3], given: [f64; 3], claimed: [f64; 3], g: f64) {
    keep(&mut raw.natural_map, law.natural_map(lambda, given, g));
    keep(&mut raw.signorini, natural(g * lambda[0], claimed[0]));
    friction_laws(raw, law, [lambda, claimed], law.friction() * lambda[0], 1.0);
}

/// The same for a friction group with the bound `r`, its impulse and slips in the last two places. `s`: the data's velocity scale,
/// by which the dissipation is measured where the bound is larger than what any impulse of the step needs.
fn group_laws(
    raw: &mut Certificate,
    law: &CoulombLaw,
    [lambda, given, claimed]: [[f64; 3]; 3],
    r: f64,
    g: f64,
    s: f64,
) {
    keep(&mut raw.natural_map, law.group_natural_map(lambda, given, r, g));
    let strength = s.max(g * r);
    friction_laws(raw, law, [lambda, claimed], r, if strength > 0.0 { s / strength } else { 1.0 });
}

/// Friction within its bound, and against the slip; `relative`: what its dissipation is multiplied with.
fn friction_laws(raw: &mut Certificate, law: &CoulombLaw, [lambda, claimed]: [[f64; 3]; 2], bound: f64, relative: f64) {
    let (t, slip) = (law.tangential(lambda), law.tangential(claimed));
    let outside = (lambda[1] - t[0]).hypot(lambda[2] - t[1]);
    keep(&mut raw.friction, (t[0].hypot(t[1]) - bound).max(outside).max(0.0));
    let power = slip[0] * t[0] + slip[1] * t[1];
    keep(&mut raw.dissipation, (power + bound * slip[0].hypot(slip[1])).abs() * relative);
}

/// `s_v`: the largest velocity of the data in the directions of the laws, m/s.
pub fn cone_velocity_scale(problem: &ContactProblem) -> f64 {
    let mut scale = 0.0_f64;
    for i in 0..problem.contact_count() {
        let [c_n, c_1, c_2] = problem.contact_velocity(i, &problem.free_velocity);
        let tangential = match problem.directions_of(i) {
            [] => 0.0,
            [d, _] => (d[0] * c_1 + d[1] * c_2).abs(),
            _ => c_1.hypot(c_2),
        };
        scale = scale.max((c_n + problem.gap[i] / problem.timestep).abs()).max(tangential);
    }
    for (k, theta) in problem.bilateral_violation.iter().enumerate() {
        let [rate] = problem.bilateral_jacobian.multiply(k, &problem.free_velocity);
        scale = scale.max((rate + theta / problem.timestep).abs());
    }
    for j in 0..problem.friction_groups.len() {
        let [s_1, s_2] = problem.friction_groups.slip(j, &problem.free_velocity);
        let [t_1, t_2] = CoulombLaw::of_group(problem, j).tangential([0.0, s_1, s_2]);
        scale = scale.max(t_1.hypot(t_2));
    }
    scale
}

impl FrictionalProblem {
    /// `s_v`: the largest velocity without impulses, m/s.
    pub fn velocity_scale(&self) -> f64 {
        let d = self.dimension;
        let of_contact = |q: &[f64]| q[0].abs().max(if d == 3 { q[1].hypot(q[2]) } else { q[1].abs() });
        self.free_velocity.chunks_exact(d).map(of_contact).fold(0.0, f64::max)
    }

    /// Certifies impulses with the circular cone. The velocity is computed from them, so that the momentum balance holds
    /// by definition.
    ///
    /// - `impulse`: (normal, tangent 1, tangent 2) of each contact, N·s; the last is 0 in the plane
    pub fn certify_cone(&self, impulse: &[[f64; 3]]) -> Certificate {
        let (d, nc) = (self.dimension, self.friction.len());
        if impulse.len() != nc || impulse.iter().flatten().any(|x| !x.is_finite()) {
            return Certificate::everything_violated();
        }
        let g = (0..d * nc).map(|r| self.delassus[(r, r)]).fold(0.0, f64::max);
        let g = if g > 0.0 { g } else { 1.0 };
        let x: Vec<f64> = impulse.iter().flat_map(|p| p[..d].iter().copied()).collect();
        let mut raw = Certificate::default();
        for i in 0..nc {
            let mut u = [0.0; 3];
            for r in 0..d {
                let row = self.delassus.row(d * i + r);
                u[r] = self.free_velocity[d * i + r] + row.iter().zip(&x).map(|(w, x)| w * x).sum::<f64>();
            }
            contact_laws(&mut raw, &CoulombLaw::in_dimension(self.friction[i], d), impulse[i], u, u, g);
        }
        let s = self.velocity_scale();
        if s == 0.0 {
            return if raw.natural_map == 0.0 { raw } else { Certificate::everything_violated() };
        }
        raw.relative_to(s, g)
    }
}
