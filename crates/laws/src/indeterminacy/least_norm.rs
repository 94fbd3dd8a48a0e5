//! A declared choice among indeterminate impulses: the least norm.

use super::faces::{admissible_impulses, generalized_impulse, project_impulses};
use crate::polyhedral::{ConeNewton, Group, Groups, ImpulseCones, Objective};
use signorini_contact::certificate::{Scratch, certify_afresh};
use signorini_contact::projection::{Cones, Mode};
use signorini_contact::recovery::recover_into;
use signorini_contact::{ContactProblem, ContactSolution, SolveStatus, UnsupportedFriction};

/// δ of the proximal term relative to the Delassus scale: small, because each outer iteration removes its effect by about
/// this factor over the smallest eigenvalue of the loaded rows.
const PROXIMAL_WEIGHT: f64 = 1e-7;
/// Outer iterations at most.
const MAX_ITERATIONS: u32 = 40;
/// δ is lowered where the balance improves by less than this factor.
const SLOW: f64 = 0.1;
/// Below this a balance that does not improve is as good as rounding lets it be.
const SETTLED: f64 = 1e-11;
/// The balance `Jᵀλ = p` is exact to rounding below this, relative to the sum of its absolute terms.
const ROUNDING: f64 = 1e-15;

/// What became of the impulses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum LeastNormOutcome {
    /// They are those of least norm.
    #[default]
    Chosen,
    /// Nothing was done: the solution is not `Solved`, or not one of this problem.
    NotSolved,
    /// The solution keeps its own impulses: those of least norm were not found to the tolerance.
    Kept,
    /// The problem has friction groups, whose impulses are not chosen: nothing was done.
    Unsupported(UnsupportedFriction),
}

/// What a choice among impulses did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct LeastNormReport {
    /// What became of the impulses.
    pub outcome: LeastNormOutcome,
    /// Norm of the impulses before, N·s.
    pub norm_before: f64,
    /// Norm of the impulses in the solution afterwards, N·s.
    pub norm: f64,
    /// `‖Jᵀλ − p‖_∞` over the largest sum of the absolute values of its terms: how well the impulses chosen give the same `v⁺`.
    pub balance: f64,
    /// Groups of bodies that loaded contacts and bilateral rows tie together.
    pub groups: u32,
    /// Outer (proximal) iterations.
    pub iterations: u32,
    /// LU factorisations.
    pub factorizations: u32,
}

/// Replaces the impulses of a solution by those of least norm, with memory that is kept: no allocation after warm-up.
///
/// Of all impulses that solve the LCP with the solution's `v⁺` ([`force_distributions`](crate::force_distributions) describes
/// the set), the choice is the unique minimiser of
///
/// ```text
/// Σ_i ‖(λ_N, λ_T)_i‖² + Σ_k λ_B,k²      subject to      λ_i ∈ K_i(v⁺),   J_Nᵀλ_N + J_Tᵀλ_T + J_Bᵀλ_B = p,
/// ```
///
/// where `K_i(v⁺)` is the face of contact i's friction cone that complementarity admits and `p` the generalized impulse of the
/// solution. Contact impulses enter in N·s, bilateral rows as the numbers they are: in N·s, or in N·m·s, as if a moment acted
/// on a lever of 1 m (and so do joint limits in N·m·s, which are contacts of the problem). The choice is therefore independent
/// of the order of contacts and rows, of a rotation of tangent frames together with their directions, and of an orthogonal
/// change of bilateral rows of one unit; duplicated contacts share equally. It is not independent of scaling a bilateral row.
///
/// # Method
/// The dual is a convex piecewise quadratic in `n_v` velocities y, `½‖P_K(Jy)‖² − pᵀy` with `λ = P_K(Jy)`: Newton's method with
/// a proximal term. Every iterate is admissible and of least norm for its own p exactly, so that only the balance has to
/// converge. Its cost is a few factorisations of size `n_v` for each group of bodies.
///
/// # Source
/// Least-norm duality: Mangasarian, *Least-norm linear programming solution as an unconstrained minimization problem* (1983);
/// proximal point method: Rockafellar, *Monotone operators and the proximal point algorithm* (1976).
#[derive(Debug, Default)]
pub struct LeastNorm {
    faces: ImpulseCones,
    groups: Groups,
    newton: ConeNewton,
    cones: Cones,
    earlier: ContactSolution,
    scratch: Scratch,
    target: Vec<f64>,
    x: Vec<f64>,
    center: Vec<f64>,
    balance: Vec<f64>,
    column: Vec<f64>,
    zeros: Vec<[f64; 3]>,
    row_zeros: Vec<f64>,
    ones: Vec<f64>,
}

impl LeastNorm {
    /// Chooses the impulses; `solution` keeps its velocity and is certified again.
    ///
    /// `tolerance`: the new certificate's worst residual must be at most this, or at most what it was; otherwise the solution
    /// stays as it is and the report says [`Kept`](LeastNormOutcome::Kept).
    pub fn apply(
        &mut self,
        problem: &ContactProblem,
        solution: &mut ContactSolution,
        tolerance: f64,
    ) -> LeastNormReport {
        let norm_before = norm(solution);
        let mut report = LeastNormReport { norm_before, norm: norm_before, ..LeastNormReport::default() };
        if solution.status != SolveStatus::Solved || !fits(problem, solution) {
            report.outcome = LeastNormOutcome::NotSolved;
            return report;
        }
        if let Err(unsupported) = problem.check_without_groups() {
            report.outcome = LeastNormOutcome::Unsupported(unsupported);
            return report;
        }
        self.earlier.copy_warm_part(solution);
        let residual = solution.certificate.worst();
        admissible_impulses(problem, &solution.velocity, residual, &mut self.faces);
        project_impulses(&self.faces, &mut solution.impulse);
        generalized_impulse(problem, &solution.impulse, &solution.bilateral, &mut self.target);
        self.prepare(problem);
        self.find_impulses(problem, solution, &mut report);
        self.update_modes(solution);
        self.complete(problem, solution);
        if !solution.certificate.holds(tolerance.max(residual)) {
            report.outcome = LeastNormOutcome::Kept;
            self.undo(problem, solution);
        }
        report.norm = norm(solution);
        report
    }

    /// Gives a solution back the impulses that it had before they were [chosen](Self::apply), where these miss a law that the
    /// certificate does not speak of. `problem`, `solution`: those of the last choice.
    pub fn undo(&mut self, problem: &ContactProblem, solution: &mut ContactSolution) {
        solution.copy_warm_part(&self.earlier);
        self.complete(problem, solution);
    }

    fn prepare(&mut self, problem: &ContactProblem) {
        let (nv, nc, nb) = (problem.nv(), problem.contact_count(), problem.bilateral_violation.len());
        self.groups.find(problem, &self.faces);
        self.cones.prepare(problem);
        for x in [&mut self.x, &mut self.center, &mut self.balance, &mut self.column] {
            x.clear();
            x.resize(nv, 0.0);
        }
        self.zeros.clear();
        self.zeros.resize(nc, [0.0; 3]);
        self.row_zeros.clear();
        self.row_zeros.resize(nb, 0.0);
        self.ones.clear();
        self.ones.resize(nc.max(nb), 1.0);
    }

    fn find_impulses(
        &mut self,
        problem: &ContactProblem,
        solution: &mut ContactSolution,
        report: &mut LeastNormReport,
    ) {
        self.newton.factorizations = 0;
        for group in self.groups.all() {
            report.groups += 1;
            let scale = delassus_scale(problem, &group, &mut self.column);
            let mut inertia = PROXIMAL_WEIGHT * scale;
            let mut residual = f64::INFINITY;
            self.newton.forget();
            for _ in 0..MAX_ITERATIONS {
                for &dof in group.dofs {
                    self.center[dof as usize] = self.x[dof as usize];
                }
                let objective = Objective {
                    problem,
                    cones: &self.faces,
                    group,
                    inertia,
                    center: &self.center,
                    linear: &self.target,
                    multiplier: &self.zeros,
                    row_multiplier: &self.row_zeros,
                    weight: &self.ones,
                    row_weight: &self.ones,
                    stabilized: false,
                    smallest_decrement: 1e-32 * report.norm_before * report.norm_before * scale / inertia,
                };
                self.newton.minimize(&objective, &mut self.x, &mut solution.impulse, &mut solution.bilateral);
                report.iterations += 1;
                let last = residual;
                residual = balance(problem, &group, solution, &self.target, &mut self.balance, &mut self.column);
                if residual <= ROUNDING || (residual >= last && residual < SETTLED) {
                    break;
                }
                if residual > SLOW * last {
                    inertia *= 0.1;
                    self.newton.forget();
                }
            }
            report.balance = report.balance.max(residual);
        }
        report.factorizations = self.newton.factorizations;
    }

    /// Modes for the next warm start of contacts that are loaded or unloaded now.
    fn update_modes(&self, solution: &mut ContactSolution) {
        for (i, mode) in solution.solver_modes.iter_mut().take(solution.impulse.len()).enumerate() {
            let (now, before) = (solution.impulse[i], self.earlier.impulse[i]);
            if now[0] <= 0.0 {
                *mode = Mode::Open;
            } else if before[0] <= 0.0 {
                *mode = self.cones.mode_at(i, now);
            }
        }
    }

    /// Multipliers and certificate of the solution's impulses and velocity.
    fn complete(&mut self, problem: &ContactProblem, solution: &mut ContactSolution) {
        recover_into(problem, &self.cones, problem.velocity_scale(), solution);
        solution.certificate = certify_afresh(problem, solution, &mut self.scratch);
    }
}

/// Replaces the impulses of a solution by those of least norm; see [`LeastNorm`], which keeps its memory.
pub fn least_norm_impulses(
    problem: &ContactProblem,
    solution: &mut ContactSolution,
    tolerance: f64,
) -> LeastNormReport {
    LeastNorm::default().apply(problem, solution, tolerance)
}

/// Whether a solution has the problem's sizes.
fn fits(problem: &ContactProblem, solution: &ContactSolution) -> bool {
    let nc = problem.contact_count();
    let lengths = [solution.lambda_n.len(), solution.beta.len(), solution.impulse.len(), solution.modes.len()];
    lengths == [nc; 4]
        && solution.velocity.len() == problem.nv()
        && solution.alpha.len() == problem.direction_count()
        && solution.bilateral.len() == problem.bilateral_violation.len()
}

/// Euclidean norm of all impulses.
fn norm(solution: &ContactSolution) -> f64 {
    let contacts = solution.impulse.iter().flatten();
    contacts.chain(&solution.bilateral).map(|x| x * x).sum::<f64>().sqrt()
}

/// The largest diagonal entry of `J M⁻¹ Jᵀ` over the rows of a group; 1 where it is 0.
fn delassus_scale(problem: &ContactProblem, group: &Group, scratch: &mut [f64]) -> f64 {
    scratch.fill(0.0);
    let mut scale = 0.0_f64;
    for &i in group.contacts {
        scale = problem.delassus_diagonal(i as usize, scratch).into_iter().fold(scale, f64::max);
    }
    for &k in group.rows {
        scale = scale.max(problem.bilateral_delassus(k as usize, scratch));
    }
    if scale > 0.0 { scale } else { 1.0 }
}

/// `‖Jᵀλ − p‖_∞` over the largest sum of absolute terms, on the degrees of freedom of a group.
fn balance(
    problem: &ContactProblem,
    group: &Group,
    solution: &ContactSolution,
    target: &[f64],
    sum: &mut [f64],
    terms: &mut [f64],
) -> f64 {
    for &dof in group.dofs {
        sum[dof as usize] = -target[dof as usize];
        terms[dof as usize] = target[dof as usize].abs();
    }
    for &i in group.contacts {
        let lambda = solution.impulse[i as usize];
        problem.jacobian.add_transposed(i as usize, lambda, sum);
        let (columns, entries) = problem.jacobian.group(i as usize);
        for (&c, e) in columns.iter().zip(entries) {
            terms[c as usize] += (0..3).map(|r| (e[r] * lambda[r]).abs()).sum::<f64>();
        }
    }
    for &k in group.rows {
        let lambda = solution.bilateral[k as usize];
        problem.bilateral_jacobian.add_transposed(k as usize, [lambda], sum);
        let (columns, entries) = problem.bilateral_jacobian.group(k as usize);
        for (&c, e) in columns.iter().zip(entries) {
            terms[c as usize] += (e[0] * lambda).abs();
        }
    }
    let dofs = group.dofs.iter().map(|&dof| dof as usize);
    let (worst, largest) = dofs.fold((0.0_f64, 0.0_f64), |(w, l), d| (w.max(sum[d].abs()), l.max(terms[d])));
    if worst == 0.0 { 0.0 } else { worst / largest }
}
