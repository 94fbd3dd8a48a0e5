//! The certificate: what a solution must show, computed from the data alone (formulation §8).
//!
//! Nothing here knows how the solution was found. Every residual is relative to the data's own scales, so that it does not
//! change with the units of mass, length or time.

use crate::momentum::needs_terms;
use crate::residuals::{LackingRow, keep, larger, natural};
use crate::{ContactProblem, ContactSolution};

pub use crate::momentum::Scratch;
pub use crate::residuals::Certificate;

/// The square of a smaller number is not a normal number.
const NO_SQUARE: f64 = 1e-154;

/// Bits of which the highest is set where one of the numbers is not finite: its exponent has all bits set, and one more carries into
/// the place of the sign.
#[inline]
fn carries(x: &[f64]) -> u64 {
    const EXPONENT: u64 = 0x7ff << 52;
    x.iter().fold(0, |bits, x| bits | ((x.to_bits() & EXPONENT) + (1 << 52)))
}

/// The smaller of two numbers, in one instruction; the second where one of them is none.
#[inline]
fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// Certifies a claimed solution `(v⁺, λ_N, α, β, λ_B)` with the `α` and `β` of its friction groups; only these of `solution` are read.
///
/// - `problem`: the data.
/// - `solution`: arrays of the problem's sizes; a missing entry, or one that is not finite, makes every residual infinite.
///
/// # Source
/// The formulation, §8.
pub fn certify(problem: &ContactProblem, solution: &ContactSolution) -> Certificate {
    certify_afresh(problem, solution, &mut Scratch::default())
}

/// The same in memory at hand.
pub fn certify_afresh(problem: &ContactProblem, solution: &ContactSolution, scratch: &mut Scratch) -> Certificate {
    let scales = scratch.scales(problem, problem.velocity_scale());
    certify_with(problem, solution, &scales, scratch)
}

/// The certificate with the problem's scales at hand.
pub fn certify_with(
    problem: &ContactProblem,
    solution: &ContactSolution,
    scales: &Scales,
    scratch: &mut Scratch,
) -> Certificate {
    certify_rows(problem, solution, scales, scratch, |_, _| {})
}

/// The same; `visit` is told every row and what its natural map lacks, m/s.
#[inline]
pub(crate) fn certify_rows(
    problem: &ContactProblem,
    solution: &ContactSolution,
    scales: &Scales,
    scratch: &mut Scratch,
    mut visit: impl FnMut(LackingRow, f64),
) -> Certificate {
    let (nv, nc) = (problem.nv(), problem.contact_count());
    let sizes_fit = solution.velocity.len() == nv
        && solution.lambda_n.len() == nc
        && solution.alpha.len() == problem.direction_count()
        && solution.beta.len() == nc
        && solution.bilateral.len() == problem.bilateral_violation.len()
        && solution.group_alpha.len() == problem.friction_groups.direction_count()
        && solution.group_beta.len() == problem.friction_groups.len();
    let of_contacts = carries(&solution.lambda_n) | carries(&solution.alpha) | carries(&solution.beta);
    let of_groups = carries(&solution.group_alpha) | carries(&solution.group_beta);
    let bits = carries(&solution.velocity) | of_contacts | carries(&solution.bilateral) | of_groups;
    scratch.carried = f64::INFINITY;
    if !sizes_fit || bits >> 63 != 0 {
        return Certificate::everything_violated();
    }
    scratch.resize(nv);
    scratch.add_polygon_forces(problem, solution);
    let mut momentum = scratch.balance(problem, &solution.velocity, scales.velocity);
    if needs_terms(momentum) {
        scratch.add_polygon_terms(problem, solution);
        momentum = scratch.balance_beside_terms(problem, scales.velocity);
    }
    let mut certificate = Certificate { momentum, ..Default::default() };
    let (mut carried, mut largest) = (0.0, 0.0);
    let mut take = |row: LackingRow, apart: f64, certificate: &mut Certificate| {
        carried = larger(apart, carried);
        // Until here the natural map is that of this row alone.
        let own = std::mem::take(&mut certificate.natural_map);
        visit(row, own);
        largest = larger(own, largest);
    };
    for i in 0..nc {
        let apart = contact_laws(problem, solution, i, &scratch.both, scales, &mut certificate);
        take(LackingRow::Contact(i), apart, &mut certificate);
    }
    for j in 0..problem.friction_groups.len() {
        let apart = group_laws(problem, solution, j, &scratch.both, scales, &mut certificate);
        take(LackingRow::FrictionGroup(j), apart, &mut certificate);
    }
    for k in 0..solution.bilateral.len() {
        let apart = bilateral_law(problem, k, &scratch.both, &mut certificate);
        take(LackingRow::Bilateral(k), apart, &mut certificate);
    }
    certificate.natural_map = largest;
    scratch.carried = if scales.velocity < NO_SQUARE { 0.0 } else { carried / scales.velocity };
    scales.normalise(problem, &solution.velocity, certificate)
}

/// `v^f + M⁻¹(J_Nᵀλ_N + J_TᵀDα + J_Bᵀλ_B + J_FᵀD_Fα_F)`.
pub fn velocity_from_impulses(problem: &ContactProblem, solution: &ContactSolution) -> Vec<f64> {
    let mut scratch = Scratch::default();
    scratch.resize(problem.nv());
    scratch.add_polygon_forces(problem, solution);
    take_velocity(problem, &mut scratch.force);
    scratch.force
}

/// Writes the velocity that the impulses of contacts, groups and bilateral rows give, before `α` is known.
pub fn take_velocity_before_recovery(problem: &ContactProblem, solution: &mut ContactSolution, scratch: &mut Scratch) {
    scratch.resize(problem.nv());
    let ContactSolution { impulse, group_impulse, bilateral, velocity, .. } = solution;
    scratch.add_forces(problem, |i| impulse[i], bilateral, |j| group_impulse[j]);
    take_velocity(problem, &mut scratch.force);
    velocity.clone_from(&scratch.force);
}

/// The [velocity from impulses](velocity_from_impulses), these summed in the reverse order.
pub fn velocity_summed_backwards(problem: &ContactProblem, solution: &ContactSolution) -> Vec<f64> {
    let mut force = vec![0.0; problem.nv()];
    for j in (0..problem.friction_groups.len()).rev() {
        let impulse = problem.friction_groups.impulse(j, &solution.group_alpha);
        problem.friction_groups.jacobian.add_transposed(j, impulse, &mut force);
    }
    for (k, p) in solution.bilateral.iter().enumerate().rev() {
        problem.bilateral_jacobian.add_transposed(k, [*p], &mut force);
    }
    for i in (0..problem.contact_count()).rev() {
        let [t_1, t_2] = tangential_impulse(problem, solution, i);
        problem.jacobian.add_transposed(i, [solution.lambda_n[i], t_1, t_2], &mut force);
    }
    take_velocity(problem, &mut force);
    force
}

/// Turns the sum of impulses in generalized coordinates into the velocity that they give.
fn take_velocity(problem: &ContactProblem, force: &mut [f64]) {
    problem.mass_factor.solve_in_place(force);
    force.iter_mut().zip(&problem.free_velocity).for_each(|(v, f)| *v += f);
}

/// The scales of the data.
#[derive(Clone, Copy, Debug, Default)]
pub struct Scales {
    /// `g`: largest diagonal entry of `J M⁻¹ Jᵀ` over normals and directions, 1/kg.
    pub(crate) delassus: f64,
    /// `s_v = max|b|`, m/s.
    pub velocity: f64,
}

impl Scales {
    /// The scales of a problem whose largest Delassus entry ([`ContactProblem::delassus_scale`]) and velocity scale
    /// ([`ContactProblem::velocity_scale`]) are known.
    pub fn new(delassus: f64, velocity: f64) -> Self {
        Self { delassus: if delassus > 0.0 { delassus } else { 1.0 }, velocity }
    }

    /// What the last digits of a solution's impulses make in a velocity, relative to `s_v`. Friction is little more than what bounds it.
    pub fn rounding(&self, solution: &ContactSolution) -> f64 {
        let size = |impulses: &[f64]| impulses.iter().fold(0.0, |a, p| larger(p.abs(), a));
        let largest = larger(larger(size(&solution.lambda_n), size(&solution.group_alpha)), size(&solution.bilateral));
        if self.velocity > 0.0 { f64::EPSILON * self.delassus * largest / self.velocity } else { 0.0 }
    }

    /// Divides the raw residuals by their scales, but the momentum, which has its own of each body; where the data are zero the solution is zero and so are the residuals. Zero is
    /// what has no square: rest that is approached step by step ends there.
    pub(crate) fn normalise(&self, problem: &ContactProblem, velocity: &[f64], raw: Certificate) -> Certificate {
        if self.velocity < NO_SQUARE {
            let unchanged = |(v, f): (&f64, &f64)| (v - f).abs() < NO_SQUARE;
            let still = raw.natural_map < NO_SQUARE && velocity.iter().zip(&problem.free_velocity).all(unchanged);
            let r = if still { 0.0 } else { f64::INFINITY };
            return Certificate { momentum: r, natural_map: r, ..Default::default() };
        }
        raw.relative_to(self.velocity, self.delassus)
    }
}

impl Scratch {
    /// The scales of a problem whose velocity scale is known.
    pub(crate) fn scales(&mut self, problem: &ContactProblem, velocity: f64) -> Scales {
        self.column.clear();
        self.column.resize(problem.nv(), 0.0);
        Scales::new(problem.delassus_scale_with(&mut self.column), velocity)
    }

    fn add_polygon_forces(&mut self, problem: &ContactProblem, solution: &ContactSolution) {
        let (of_contact, of_group) = polygon_impulses(problem, solution);
        self.add_forces(problem, of_contact, &solution.bilateral, of_group);
    }

    fn add_polygon_terms(&mut self, problem: &ContactProblem, solution: &ContactSolution) {
        let (of_contact, of_group) = polygon_impulses(problem, solution);
        self.add_terms(problem, of_contact, &solution.bilateral, of_group);
    }
}

/// The impulses of each contact (normal, two tangents) and of each friction group.
fn polygon_impulses<'a>(
    problem: &'a ContactProblem,
    solution: &'a ContactSolution,
) -> (impl Fn(usize) -> [f64; 3] + 'a, impl Fn(usize) -> [f64; 2] + 'a) {
    let of_contact = |i| {
        let [t_1, t_2] = tangential_impulse(problem, solution, i);
        [solution.lambda_n[i], t_1, t_2]
    };
    (of_contact, |j| problem.friction_groups.impulse(j, &solution.group_alpha))
}

/// `λ_T = D α` of contact `i`.
pub fn tangential_impulse(problem: &ContactProblem, solution: &ContactSolution, i: usize) -> [f64; 2] {
    let alpha = &solution.alpha[problem.direction_offsets[i]..problem.direction_offsets[i + 1]];
    problem.directions_of(i).iter().zip(alpha).fold([0.0; 2], |[x, y], (d, a)| [x + d[0] * a, y + d[1] * a])
}

/// At least the distance of two tangential velocities along any direction.
#[inline]
fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).abs()
}

/// Raw residuals of contact `i`. `both`: the velocity that the impulses give and the claimed one. Returns how far they are apart
/// along the contact's rows.
pub(crate) fn contact_laws(
    problem: &ContactProblem,
    solution: &ContactSolution,
    i: usize,
    both: &[[f64; 2]],
    scales: &Scales,
    raw: &mut Certificate,
) -> f64 {
    let (g, lambda) = (scales.delassus, solution.lambda_n[i]);
    let gap_rate = problem.gap[i] / problem.timestep;
    let [[computed_n, claimed_n], t_1, t_2] = problem.jacobian.multiply_pairs(i, both);
    let [computed, claimed] = [[t_1[0], t_2[0]], [t_1[1], t_2[1]]];
    keep(&mut raw.natural_map, natural(g * lambda, computed_n + gap_rate));
    keep(&mut raw.signorini, natural(g * lambda, claimed_n + gap_rate));
    let range = problem.direction_offsets[i]..problem.direction_offsets[i + 1];
    let friction = Friction {
        directions: &problem.directions[range.clone()],
        alpha: &solution.alpha[range],
        beta: solution.beta[i],
        bound: problem.friction[i] * lambda,
    };
    friction.laws(computed, claimed, scales, raw);
    let tangential = if friction.directions.is_empty() { 0.0 } else { distance(computed, claimed) };
    larger((computed_n - claimed_n).abs(), tangential)
}

/// The same of friction group `j`.
#[inline]
pub(crate) fn group_laws(
    problem: &ContactProblem,
    solution: &ContactSolution,
    j: usize,
    both: &[[f64; 2]],
    scales: &Scales,
    raw: &mut Certificate,
) -> f64 {
    let groups = &problem.friction_groups;
    let friction = Friction {
        directions: groups.directions_of(j),
        alpha: &solution.group_alpha[groups.direction_range(j)],
        beta: solution.group_beta[j],
        bound: groups.bound_at(j, &solution.lambda_n),
    };
    let ([a, b], [u_1, u_2]) = (groups.jacobian.multiply_pairs(j, both), groups.target[j]);
    let [computed, claimed] = [0, 1].map(|l| [a[l] - u_1, b[l] - u_2]);
    friction.laws(computed, claimed, scales, raw);
    distance(computed, claimed)
}

/// The same of bilateral row `k`.
#[inline]
pub(crate) fn bilateral_law(problem: &ContactProblem, k: usize, both: &[[f64; 2]], raw: &mut Certificate) -> f64 {
    let stabilization = problem.bilateral_violation[k] / problem.timestep;
    let [[computed, claimed]] = problem.bilateral_jacobian.multiply_pairs(k, both);
    keep(&mut raw.bilateral, (claimed + stabilization).abs());
    keep(&mut raw.natural_map, (computed + stabilization).abs());
    (computed - claimed).abs()
}

/// The friction of one contact or friction group.
struct Friction<'a> {
    directions: &'a [[f64; 2]],
    alpha: &'a [f64],
    beta: f64,
    /// `μ λ_N` or the bound of the group.
    bound: f64,
}

impl Friction<'_> {
    /// Raw residuals of the friction law with the slip velocity that the impulses give (`computed`) and that of the claimed
    /// `v⁺`.
    fn laws(&self, computed: [f64; 2], claimed: [f64; 2], scales: &Scales, raw: &mut Certificate) {
        let g = scales.delassus;
        let (mut sum, mut least) = (0.0, 0.0_f64);
        let (mut power, mut support) = (0.0, f64::MIN);
        // The impulses are numbers; a velocity that is none leaves its mark in `checked`.
        let (mut worst, mut checked) = (0.0, 0.0);
        for (d, &a) in self.directions.iter().zip(self.alpha) {
            let w = d[0] * computed[0] + d[1] * computed[1] + self.beta;
            checked += w;
            worst = larger(worst, smaller(g * a, w).abs());
            sum += a;
            least = smaller(least, a);
            let rate = d[0] * claimed[0] + d[1] * claimed[1];
            power += a * rate;
            support = larger(support, -rate);
        }
        keep(&mut raw.natural_map, if checked.is_nan() { f64::NAN } else { worst });
        let room = self.bound - sum;
        keep(&mut raw.natural_map, natural(self.beta, g * room));
        keep(&mut raw.friction, -room);
        keep(&mut raw.friction, -least);
        if !self.alpha.is_empty() {
            let strength = scales.velocity.max(g * self.bound);
            let relative = if strength > 0.0 { scales.velocity / strength } else { 1.0 };
            keep(&mut raw.dissipation, (power + self.bound * support) * relative);
        }
    }
}
