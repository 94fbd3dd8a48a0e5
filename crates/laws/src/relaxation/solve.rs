//! The solver of the convex relaxation.

use super::certificate::impulse_of_multipliers;
use super::{RelaxationStatus, RelaxedSolution, certify_relaxation};
use crate::SelfStress;
use crate::polyhedral::{ConeNewton, Group, Groups, ImpulseCones, Objective};
use signorini_contact::ContactProblem;
use signorini_contact::projection::Cones;

/// ε of the first proximal problems, relative to each contact's Delassus block.
const FIRST_WEIGHT: f64 = 1e-4;
/// Where polishing did not suffice, the iterations go on from its result with this one, some times.
const LATER_WEIGHT: f64 = 1e-6;
const MAX_ROUNDS: u32 = 3;
/// It is lowered to this where the iterations converge slowly.
const SMALLEST_WEIGHT: f64 = 1e-9;
/// It is raised up to this to remove rounding at the end: an impulse is `u/ε`, with the rounding of `u`.
const LARGEST_WEIGHT: f64 = 1e-1;
/// Proximal iterations for one group at most.
const MAX_ITERATIONS: u32 = 60;
/// Iterations stop at this residual.
const POLISHED: f64 = 1e-13;
/// A residual that falls by less than this factor falls slowly.
const SLOW: f64 = 0.3;
/// Above this residual the iterations are far from a solution, or there is none.
const FAR: f64 = 1e-8;
/// Below this one the rest is rounding.
const NEAR: f64 = 1e-11;
/// How well impulses must balance to prove that rows contradict each other.
const BALANCED: f64 = 1e-9;

/// Anitescu's convex relaxation of the contact problem, solved exactly.
///
/// For each contact and direction k,
///
/// ```text
/// 0 ≤ α_k ⟂ c_N + φ/Δt + μ d_kᵀc_T ≥ 0,        impulse Σ_k α_k (n + μ d_k)
/// ```
///
/// (`0 ≤ λ_N ⟂ c_N + φ/Δt ≥ 0` without friction), with bilateral rows as they are. The matrix is symmetric and positive
/// semidefinite: these are the optimality conditions of the convex quadratic program
///
/// ```text
/// minimise ½ (v − v^f)ᵀ M (v − v^f)     subject to     c_N + φ/Δt + μ d_kᵀc_T ≥ 0,     ∇Θ v + Θ/Δt = 0,
/// ```
///
/// whose v⁺ is unique and exists wherever the rows are consistent: with `φ ≥ 0`, `Θ = 0` always (v = 0 satisfies them, and then
/// `‖v⁺‖_M ≤ ‖v^f‖_M`, no step adds energy); with `φ < 0` unless impulses of the friction cones hold each other in balance
/// against the gaps, as in a jam.
///
/// # What it is not
/// A solution of the contact laws. They ask a loaded contact for `c_N + φ/Δt = 0`; here a loaded contact that slides has
///
/// ```text
/// c_N + φ/Δt = μ max_k(−d_kᵀc_T)        (μ ‖c_T‖ for the circular cone):
/// ```
///
/// the gap opens with slip. A block that slides at speed v floats at the gap `μ v Δt` (5 mm at μ = 0.5, v = 1 m/s,
/// Δt = 10 ms), and one that lies on the plane and is suddenly struck along it is thrown up with the speed `μ v`, whatever Δt
/// is. Where nothing slides the two models agree. [`RelaxedSolution::contact_laws`] gives the residual of the true laws.
///
/// # Method
/// Augmented Lagrangian (proximal) iterations in velocity space: `λ ← P(λ − ρ(Jv + φ/Δt))` with the Euclidean projection `P`
/// onto each friction cone, so that redundant contacts are no obstacle; each inner problem by Newton's method with a line
/// search. Its fixed points are exact, the iterations end at rounding.
///
/// # Source
/// Anitescu, *Optimization-based simulation of nonsmooth rigid multibody dynamics*, Mathematical Programming 105 (2006);
/// Anitescu, Tasora, *An iterative approach for cone complementarity problems for nonsmooth dynamics*, Computational
/// Optimization and Applications 47 (2010). Augmented Lagrangian: Rockafellar (1976).
#[derive(Debug, Default)]
pub struct ConvexRelaxation {
    faces: ImpulseCones,
    groups: Groups,
    newton: ConeNewton,
    cones: Cones,
    impulse: Vec<[f64; 3]>,
    multiplier: Vec<[f64; 3]>,
    row_impulse: Vec<f64>,
    row_multiplier: Vec<f64>,
    /// Largest diagonal entry of each contact's block of `J M⁻¹ Jᵀ`, and of each row.
    delassus: Vec<f64>,
    row_delassus: Vec<f64>,
    weight: Vec<f64>,
    row_weight: Vec<f64>,
    x: Vec<f64>,
    velocity: Vec<f64>,
    velocity_scale: f64,
}

impl ConvexRelaxation {
    /// Solves the relaxation of a problem into `solution`, whose memory is reused.
    ///
    /// `tolerance`: the certificate's worst residual up to which the status is `Solved`. Friction groups are refused
    /// ([`RelaxationStatus::Unsupported`]).
    ///
    /// # Cost
    /// Ten to twenty factorisations of size `n_v` for each group of coupled bodies, always from zero impulses.
    pub fn solve_into(&mut self, problem: &ContactProblem, tolerance: f64, solution: &mut RelaxedSolution) {
        solution.prepare(problem);
        if let Err(unsupported) = problem.check_without_groups() {
            solution.status = RelaxationStatus::Unsupported(unsupported);
            solution.certificate = certify_relaxation(problem, solution);
            return;
        }
        self.prepare(problem);
        let groups = std::mem::take(&mut self.groups);
        for group in groups.all() {
            solution.report.groups += 1;
            let proof = self.solve_group(problem, group, solution);
            if let Some(proof) = proof {
                solution.status = RelaxationStatus::Inconsistent { proof };
                break;
            }
        }
        self.groups = groups;
        solution.report.factorizations = self.newton.factorizations;
        self.fill_multipliers(problem, solution);
        solution.certificate = certify_relaxation(problem, solution);
        if solution.status == RelaxationStatus::Solved && !solution.certificate.holds(tolerance) {
            solution.status = immovable_contradiction(problem).unwrap_or(RelaxationStatus::Inaccurate);
        }
    }

    /// Solves the relaxation of a problem; see [`solve_into`](Self::solve_into).
    pub fn solve(&mut self, problem: &ContactProblem, tolerance: f64) -> RelaxedSolution {
        let mut solution = RelaxedSolution::default();
        self.solve_into(problem, tolerance, &mut solution);
        solution
    }

    fn prepare(&mut self, problem: &ContactProblem) {
        let (nc, nb) = (problem.contact_count(), problem.bilateral_violation.len());
        self.cones.prepare(problem);
        self.faces.prepare(problem, |_| Some(|_| true));
        self.groups.find(problem, &self.faces);
        self.newton.factorizations = 0;
        self.velocity_scale = problem.velocity_scale();
        for x in [&mut self.impulse, &mut self.multiplier] {
            x.clear();
            x.resize(nc, [0.0; 3]);
        }
        for x in [&mut self.row_impulse, &mut self.row_multiplier, &mut self.row_weight] {
            x.clear();
            x.resize(nb, 0.0);
        }
        self.weight.clear();
        self.weight.resize(nc, 0.0);
        self.x.clone_from(&problem.free_velocity);
        self.velocity.clear();
        self.velocity.resize(problem.nv(), 0.0);
        self.delassus.clear();
        for i in 0..nc {
            let diagonal = problem.delassus_diagonal(i, &mut self.velocity);
            self.delassus.push(diagonal.into_iter().fold(0.0, f64::max));
        }
        self.row_delassus.clear();
        for k in 0..nb {
            self.row_delassus.push(problem.bilateral_delassus(k, &mut self.velocity));
        }
    }

    /// Solves one group into `solution`, or proves that its rows contradict each other.
    fn solve_group(
        &mut self,
        problem: &ContactProblem,
        group: Group,
        solution: &mut RelaxedSolution,
    ) -> Option<SelfStress> {
        let mut epsilon = FIRST_WEIGHT;
        let (mut polishing, mut rounds) = (false, 0);
        let (mut best, mut last) = (f64::INFINITY, f64::INFINITY);
        for iteration in 0..MAX_ITERATIONS {
            self.iterate(problem, group, epsilon);
            solution.report.iterations += 1;
            let residual = self.residual(problem, &group);
            if residual < best {
                best = residual;
                self.keep(&group, solution);
            }
            if best <= POLISHED {
                break;
            }
            if residual > SLOW * last {
                let may_contradict = iteration > 2 && best > FAR;
                let proof = may_contradict.then(|| self.contradiction(problem, &group)).flatten();
                if proof.is_some() {
                    return proof;
                }
                let falls = residual < last;
                if !polishing && (best > FAR || (falls && best > NEAR)) {
                    epsilon *= if falls && epsilon > SMALLEST_WEIGHT { 0.1 } else { 1.0 };
                } else if epsilon < LARGEST_WEIGHT {
                    polishing = true;
                    epsilon *= 10.0;
                    self.restore(&group, solution);
                } else if best > NEAR && rounds < MAX_ROUNDS {
                    (polishing, rounds, epsilon) = (false, rounds + 1, LATER_WEIGHT);
                    self.restore(&group, solution);
                    last = f64::INFINITY;
                    continue;
                } else {
                    break;
                }
            }
            last = residual;
        }
        None
    }

    /// One proximal iteration: new impulses from the ones at hand.
    fn iterate(&mut self, problem: &ContactProblem, group: Group, epsilon: f64) {
        self.newton.forget();
        for &i in group.contacts {
            self.multiplier[i as usize] = self.impulse[i as usize];
            self.weight[i as usize] = 1.0 / (epsilon * self.delassus[i as usize]);
        }
        for &k in group.rows {
            self.row_multiplier[k as usize] = self.row_impulse[k as usize];
            self.row_weight[k as usize] = 1.0 / (epsilon * self.row_delassus[k as usize]);
        }
        let delassus = group.contacts.iter().map(|&i| self.delassus[i as usize]);
        let delassus = delassus.chain(group.rows.iter().map(|&k| self.row_delassus[k as usize])).fold(0.0, f64::max);
        let largest =
            group.contacts.iter().flat_map(|&i| self.impulse[i as usize]).fold(0.0, |l: f64, x| l.max(x.abs()));
        // What rounding leaves of the rows (times 1/ε) and of the momentum balance, as energies.
        let rounding = self.velocity_scale.powi(2) / epsilon + (delassus * largest).powi(2);
        let objective = Objective {
            problem,
            cones: &self.faces,
            group,
            inertia: 1.0,
            center: &problem.free_velocity,
            linear: &[],
            multiplier: &self.multiplier,
            row_multiplier: &self.row_multiplier,
            weight: &self.weight,
            row_weight: &self.row_weight,
            stabilized: true,
            smallest_decrement: 1e-32 * rounding / delassus,
        };
        self.newton.minimize(&objective, &mut self.x, &mut self.impulse, &mut self.row_impulse);
    }

    /// Natural map of the cone complementarity at the velocity that the impulses give, relative to `max|b|`.
    fn residual(&mut self, problem: &ContactProblem, group: &Group) -> f64 {
        self.velocity_from(problem, group, &problem.free_velocity);
        // One scale for the whole problem, as the certificate has it.
        let largest = self.delassus.iter().copied().fold(0.0, f64::max);
        let mut worst = 0.0_f64;
        for &i in group.contacts {
            let i = i as usize;
            let (g, lambda) = (largest, self.impulse[i]);
            let mut u = problem.contact_velocity(i, &self.velocity);
            u[0] += problem.gap[i] / problem.timestep;
            let moved = self.faces.project(i, std::array::from_fn(|r| lambda[r] - u[r] / g)).0;
            worst = (0..3).map(|r| g * (lambda[r] - moved[r]).abs()).fold(worst, f64::max);
        }
        for &k in group.rows {
            let [rate] = problem.bilateral_jacobian.multiply(k as usize, &self.velocity);
            worst = worst.max((rate + problem.bilateral_violation[k as usize] / problem.timestep).abs());
        }
        if worst == 0.0 { 0.0 } else { worst / self.velocity_scale }
    }

    /// `velocity = start + M⁻¹(Jᵀλ + J_Bᵀλ_B)` on the group.
    fn velocity_from(&mut self, problem: &ContactProblem, group: &Group, start: &[f64]) {
        for &dof in group.dofs {
            self.velocity[dof as usize] = 0.0;
        }
        for &i in group.contacts {
            problem.jacobian.add_transposed(i as usize, self.impulse[i as usize], &mut self.velocity);
        }
        for &k in group.rows {
            problem.bilateral_jacobian.add_transposed(k as usize, [self.row_impulse[k as usize]], &mut self.velocity);
        }
        for &block in group.blocks {
            let range = problem.mass.blocks()[block as usize].range();
            problem.mass_factor.solve_block_in_place(block as usize, &mut self.velocity[range]);
        }
        for &dof in group.dofs {
            self.velocity[dof as usize] += start.get(dof as usize).copied().unwrap_or(0.0);
        }
    }

    fn keep(&self, group: &Group, solution: &mut RelaxedSolution) {
        for &i in group.contacts {
            solution.impulse[i as usize] = self.impulse[i as usize];
        }
        for &k in group.rows {
            solution.bilateral[k as usize] = self.row_impulse[k as usize];
        }
        for &dof in group.dofs {
            solution.velocity[dof as usize] = self.velocity[dof as usize];
        }
    }

    fn restore(&mut self, group: &Group, solution: &RelaxedSolution) {
        for &i in group.contacts {
            self.impulse[i as usize] = solution.impulse[i as usize];
        }
        for &k in group.rows {
            self.row_impulse[k as usize] = solution.bilateral[k as usize];
        }
    }

    /// Where the rows contradict each other, the changes of the impulses tend to a proof of it.
    fn contradiction(&mut self, problem: &ContactProblem, group: &Group) -> Option<SelfStress> {
        let (impulse, row_impulse) = (self.impulse.clone(), self.row_impulse.clone());
        let mut size = 0.0_f64;
        for &i in group.contacts {
            let i = i as usize;
            let change = std::array::from_fn(|r| self.impulse[i][r] - self.multiplier[i][r]);
            self.impulse[i] = self.faces.project(i, change).0;
            size = self.impulse[i].iter().fold(size, |s, x| s.max(x.abs()));
        }
        for &k in group.rows {
            self.row_impulse[k as usize] -= self.row_multiplier[k as usize];
            size = size.max(self.row_impulse[k as usize].abs());
        }
        self.velocity_from(problem, group, &[]);
        let proof = self.proof(problem, group, size);
        (self.impulse, self.row_impulse) = (impulse, row_impulse);
        proof
    }

    /// The impulses at hand as a proof of contradiction, if they are one. `velocity`: what they would move.
    fn proof(&self, problem: &ContactProblem, group: &Group, size: f64) -> Option<SelfStress> {
        let mut stress = SelfStress {
            impulse: vec![[0.0; 3]; problem.contact_count()],
            bilateral: vec![0.0; problem.bilateral_violation.len()],
        };
        let (mut work, mut terms, mut moved) = (0.0, 0.0_f64, 0.0_f64);
        for &i in group.contacts {
            let i = i as usize;
            stress.impulse[i] = self.impulse[i].map(|x| x / size);
            let own = stress.impulse[i][0] * problem.gap[i];
            (work, terms) = (work + own, terms + own.abs());
            let c = problem.contact_velocity(i, &self.velocity);
            moved = c.iter().fold(moved, |m, x| m.max(x.abs() / (size * self.delassus[i])));
        }
        for &k in group.rows {
            let k = k as usize;
            stress.bilateral[k] = self.row_impulse[k] / size;
            let own = stress.bilateral[k] * problem.bilateral_violation[k];
            (work, terms) = (work + own, terms + own.abs());
            let [rate] = problem.bilateral_jacobian.multiply(k, &self.velocity);
            moved = moved.max(rate.abs() / (size * self.row_delassus[k]));
        }
        (size > 0.0 && moved <= BALANCED && work < -1e-6 * terms).then_some(stress)
    }

    /// `α` of the relaxed rows from the impulses: those that enclose `λ_T`, and the rest of `λ_N` over all directions alike;
    /// then the impulses from `α`, so that both agree where large ones cancel.
    fn fill_multipliers(&self, problem: &ContactProblem, solution: &mut RelaxedSolution) {
        for i in 0..problem.contact_count() {
            let range = problem.direction_offsets[i]..problem.direction_offsets[i + 1];
            let (impulse, alpha) = (solution.impulse[i], &mut solution.alpha[range]);
            if self.cones.friction(i) > 0.0 {
                alpha.fill(0.0);
                self.cones.decompose(i, impulse, alpha);
                alpha.iter_mut().for_each(|a| *a /= self.cones.friction(i));
            }
            let share = (impulse[0] - alpha.iter().sum::<f64>()).max(0.0) / alpha.len() as f64;
            alpha.iter_mut().for_each(|a| *a += share);
            solution.impulse[i] = impulse_of_multipliers(problem, solution, i);
        }
    }
}

/// Rows that no degree of freedom moves and that are violated prove the contradiction by themselves.
fn immovable_contradiction(problem: &ContactProblem) -> Option<RelaxationStatus> {
    let mut proof = SelfStress {
        impulse: vec![[0.0; 3]; problem.contact_count()],
        bilateral: vec![0.0; problem.bilateral_violation.len()],
    };
    let contact = |i: &usize| problem.jacobian.group(*i).0.is_empty() && problem.gap[*i] < 0.0;
    let row = |k: &usize| problem.bilateral_jacobian.group(*k).0.is_empty() && problem.bilateral_violation[*k] != 0.0;
    if let Some(i) = (0..problem.contact_count()).find(contact) {
        proof.impulse[i][0] = 1.0;
    } else {
        let k = (0..problem.bilateral_violation.len()).find(row)?;
        proof.bilateral[k] = -problem.bilateral_violation[k].signum();
    }
    Some(RelaxationStatus::Inconsistent { proof })
}
