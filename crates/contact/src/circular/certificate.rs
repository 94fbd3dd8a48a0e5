//! The certificate of a solution with the circular cone, computed from the data alone (formulation §§8 and 9).

use super::ConeSolution;
use super::law::CoulombLaw;
use crate::ContactProblem;
use crate::problem_file::FrictionalProblem;

/// Residuals of the laws of one step with the circular cone. Each is 0 for an exact solution, and none changes with the units
/// of mass, length or time: velocities are divided by `s_v`, the largest velocity of the data (`|c_N + φ/Δt|`, `‖c_T‖`,
/// bilateral rows, all at `v^f`), impulses by `s_v/g` with `g` the largest diagonal entry of `J M⁻¹ Jᵀ`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ConeCertificate {
    /// `‖M(v⁺ − v^f) − J_Nᵀλ_N − J_Tᵀλ_T − J_Bᵀλ_B − J_Fᵀλ_F‖_∞`: momentum balance of the claimed `v⁺` and impulses.
    pub momentum: f64,
    /// `‖gλ − P_K(gλ − u − μ‖u_T‖n)‖`, the natural map of formulation §9, with the velocities that the impulses give (and the
    /// bilateral rows with them). It is of first order in every error, the direction of friction included.
    pub natural_map: f64,
    /// `|min(g λ_N, φ/Δt + c_N)|`: Signorini's condition with the claimed `v⁺`.
    pub signorini: f64,
    /// `max(0, ‖λ_T‖ − μ λ_N)`: the friction bound; friction where none can act counts in full.
    pub friction: f64,
    /// `|c_Tᵀλ_T + μ λ_N ‖c_T‖|`: maximum dissipation, that is, friction opposite to the slip and of full size. Of second
    /// order in the angle between the two.
    pub dissipation: f64,
    /// `|∇Θ v⁺ + Θ/Δt|` with the claimed `v⁺`.
    pub bilateral: f64,
}

impl ConeCertificate {
    /// Every residual infinite: what is claimed cannot be judged.
    pub fn everything_violated() -> Self {
        let r = f64::INFINITY;
        Self { momentum: r, natural_map: r, signorini: r, friction: r, dissipation: r, bilateral: r }
    }

    /// The largest residual; NaN counts as infinite.
    pub fn worst(&self) -> f64 {
        let all = [self.momentum, self.natural_map, self.signorini, self.friction, self.dissipation, self.bilateral];
        all.into_iter().fold(0.0, |worst, r| if r.is_nan() { f64::INFINITY } else { r.max(worst) })
    }

    /// Whether every law holds within `tolerance`.
    pub fn holds(&self, tolerance: f64) -> bool {
        self.worst() <= tolerance
    }

    /// Keeps the larger of each residual.
    pub fn merge(&mut self, other: &Self) {
        keep(&mut self.momentum, other.momentum);
        keep(&mut self.natural_map, other.natural_map);
        keep(&mut self.signorini, other.signorini);
        keep(&mut self.friction, other.friction);
        keep(&mut self.dissipation, other.dissipation);
        keep(&mut self.bilateral, other.bilateral);
    }

    /// The same for a friction group with the bound `r`, its impulse and slips in the last two places. `s`: the data's velocity scale,
    /// by which the dissipation is measured where the bound is larger than what any impulse of the step needs.
    fn add_group(&mut self, law: &CoulombLaw, [lambda, given, claimed]: [[f64; 3]; 3], r: f64, g: f64, s: f64) {
        keep(&mut self.natural_map, law.group_natural_map(lambda, given, r, g));
        let (t, slip) = (law.tangential(lambda), law.tangential(claimed));
        let outside = (lambda[1] - t[0]).hypot(lambda[2] - t[1]);
        keep(&mut self.friction, (t[0].hypot(t[1]) - r).max(outside).max(0.0));
        let strength = s.max(g * r);
        let relative = if strength > 0.0 { s / strength } else { 1.0 };
        let power = slip[0] * t[0] + slip[1] * t[1];
        keep(&mut self.dissipation, (power + r * slip[0].hypot(slip[1])).abs() * relative);
    }

    /// Adds one contact's laws, in velocities and impulses: impulse, velocity that the impulses give, claimed velocity.
    fn add_contact(&mut self, law: &CoulombLaw, lambda: [f64; 3], given: [f64; 3], claimed: [f64; 3], g: f64) {
        keep(&mut self.natural_map, law.natural_map(lambda, given, g));
        let (z, w) = (g * lambda[0], claimed[0]);
        keep(&mut self.signorini, if z.is_nan() || w.is_nan() { f64::NAN } else { z.min(w).abs() });
        let (t, bound) = (law.tangential(lambda), law.friction() * lambda[0]);
        let outside = (lambda[1] - t[0]).hypot(lambda[2] - t[1]);
        keep(&mut self.friction, (t[0].hypot(t[1]) - bound).max(outside).max(0.0));
        let slip = law.tangential(claimed);
        let power = slip[0] * t[0] + slip[1] * t[1];
        keep(&mut self.dissipation, (power + bound * slip[0].hypot(slip[1])).abs());
    }
}

fn keep(largest: &mut f64, value: f64) {
    *largest = if value.is_nan() { f64::INFINITY } else { largest.max(value) };
}

/// Memory of the certificate.
#[derive(Clone, Debug, Default)]
pub struct ConeScratch {
    force: Vec<f64>,
    given: Vec<f64>,
    momentum: Vec<f64>,
    column: Vec<f64>,
}

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
pub fn certify_cone(problem: &ContactProblem, solution: &ConeSolution) -> ConeCertificate {
    certify_cone_with(problem, solution, &mut ConeScratch::default())
}

/// [`certify_cone`] in memory at hand.
pub fn certify_cone_with(
    problem: &ContactProblem,
    solution: &ConeSolution,
    scratch: &mut ConeScratch,
) -> ConeCertificate {
    let (nv, nc, groups) = (problem.nv(), problem.contact_count(), &problem.friction_groups);
    let contacts = solution.velocity.iter().chain(&solution.bilateral).chain(solution.impulse.iter().flatten());
    let mut numbers = contacts.chain(solution.group_impulse.iter().flatten());
    if !solution.fits(problem) || numbers.any(|x| !x.is_finite()) || problem.check_circular().is_err() {
        return ConeCertificate::everything_violated();
    }
    let mut g = 0.0_f64;
    scratch.column.clear();
    scratch.column.resize(nv, 0.0);
    for i in 0..nc {
        g = problem.delassus_diagonal(i, &mut scratch.column).into_iter().fold(g, f64::max);
    }
    for j in 0..groups.len() {
        g = problem.group_delassus(j, &mut scratch.column).into_iter().fold(g, f64::max);
    }
    let g = if g > 0.0 { g } else { 1.0 };
    let mut raw = ConeCertificate { momentum: scratch.balance_momentum(problem, solution), ..Default::default() };
    for i in 0..nc {
        let gap_rate = problem.gap[i] / problem.timestep;
        let slack = |v: &[f64]| {
            let [n, t_1, t_2] = problem.contact_velocity(i, v);
            [n + gap_rate, t_1, t_2]
        };
        let law = CoulombLaw::of(problem, i);
        raw.add_contact(&law, solution.impulse[i], slack(&scratch.given), slack(&solution.velocity), g);
    }
    let s = if groups.is_empty() { 0.0 } else { cone_velocity_scale(problem) };
    for (j, [f_1, f_2]) in solution.group_impulse.iter().enumerate() {
        let slip = |v: &[f64]| {
            let [s_1, s_2] = groups.slip(j, v);
            [0.0, s_1, s_2]
        };
        let r = groups.bound[j].at(|contact| solution.impulse[contact][0]);
        let own = [[0.0, *f_1, *f_2], slip(&scratch.given), slip(&solution.velocity)];
        raw.add_group(&CoulombLaw::of_group(problem, j), own, r, g, s);
    }
    for (k, theta) in problem.bilateral_violation.iter().enumerate() {
        let rate = |v: &[f64]| problem.bilateral_jacobian.multiply(k, v)[0] + theta / problem.timestep;
        keep(&mut raw.natural_map, rate(&scratch.given).abs());
        keep(&mut raw.bilateral, rate(&solution.velocity).abs());
    }
    normalise(problem, solution, raw, g)
}

/// Divides raw residuals by the scales of the data; where the data are zero the solution is zero and so are the residuals.
fn normalise(problem: &ContactProblem, solution: &ConeSolution, raw: ConeCertificate, g: f64) -> ConeCertificate {
    let s = cone_velocity_scale(problem);
    if s == 0.0 {
        let still = raw.natural_map == 0.0 && solution.velocity == problem.free_velocity;
        return if still { ConeCertificate::default() } else { ConeCertificate::everything_violated() };
    }
    let mass = problem.mass.data().iter().fold(0.0, |a: f64, m| a.max(m.abs()));
    let fastest = problem.free_velocity.iter().fold(0.0, |a: f64, v| a.max(v.abs()));
    ConeCertificate {
        momentum: if raw.momentum == 0.0 { 0.0 } else { raw.momentum / (mass * s.max(1e-6 * fastest)) },
        natural_map: raw.natural_map / s,
        signorini: raw.signorini / s,
        friction: raw.friction * g / s,
        dissipation: raw.dissipation * g / (s * s),
        bilateral: raw.bilateral / s,
    }
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

impl ConeScratch {
    /// `‖M(v⁺ − v^f) − Jᵀλ − J_Bᵀλ_B − J_Fᵀλ_F‖_∞`; leaves in `given` the velocity that the impulses give.
    fn balance_momentum(&mut self, problem: &ContactProblem, solution: &ConeSolution) -> f64 {
        let nv = problem.nv();
        for x in [&mut self.force, &mut self.given, &mut self.momentum] {
            x.clear();
            x.resize(nv, 0.0);
        }
        for (i, p) in solution.impulse.iter().enumerate() {
            problem.jacobian.add_transposed(i, *p, &mut self.force);
        }
        for (k, p) in solution.bilateral.iter().enumerate() {
            problem.bilateral_jacobian.add_transposed(k, [*p], &mut self.force);
        }
        for (j, p) in solution.group_impulse.iter().enumerate() {
            problem.friction_groups.jacobian.add_transposed(j, *p, &mut self.force);
        }
        for ((d, v), f) in self.given.iter_mut().zip(&solution.velocity).zip(&problem.free_velocity) {
            *d = v - f;
        }
        problem.mass.multiply_into(&self.given, &mut self.momentum);
        let differences = self.momentum.iter().zip(&self.force).map(|(p, f)| (p - f).abs());
        let residual = differences.fold(0.0, |a, d| if d.is_nan() { f64::INFINITY } else { f64::max(a, d) });
        self.given.copy_from_slice(&self.force);
        problem.mass_factor.solve_in_place(&mut self.given);
        self.given.iter_mut().zip(&problem.free_velocity).for_each(|(v, f)| *v += f);
        residual
    }
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
    pub fn certify_cone(&self, impulse: &[[f64; 3]]) -> ConeCertificate {
        let (d, nc) = (self.dimension, self.friction.len());
        if impulse.len() != nc || impulse.iter().flatten().any(|x| !x.is_finite()) {
            return ConeCertificate::everything_violated();
        }
        let g = (0..d * nc).map(|r| self.delassus[(r, r)]).fold(0.0, f64::max);
        let g = if g > 0.0 { g } else { 1.0 };
        let x: Vec<f64> = impulse.iter().flat_map(|p| p[..d].iter().copied()).collect();
        let mut raw = ConeCertificate::default();
        for i in 0..nc {
            let mut u = [0.0; 3];
            for r in 0..d {
                let row = self.delassus.row(d * i + r);
                u[r] = self.free_velocity[d * i + r] + row.iter().zip(&x).map(|(w, x)| w * x).sum::<f64>();
            }
            raw.add_contact(&CoulombLaw::in_dimension(self.friction[i], d), impulse[i], u, u, g);
        }
        let s = self.velocity_scale();
        if s == 0.0 {
            return if raw.natural_map == 0.0 { raw } else { ConeCertificate::everything_violated() };
        }
        ConeCertificate {
            natural_map: raw.natural_map / s,
            signorini: raw.signorini / s,
            friction: raw.friction * g / s,
            dissipation: raw.dissipation * g / (s * s),
            ..ConeCertificate::default()
        }
    }
}
