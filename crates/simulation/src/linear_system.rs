//! The step near a state as a linear complementarity system, for control through contact.
//!
//! With `x = (δq, v)`, where `q = q* ⊕ δq`, the control `u` and the impulses and multipliers `λ = (λ_N, α, β)` of the standard
//! LCP (formulation §4), a step is
//!
//! ```text
//! x⁺ = A x + B u + D λ + d,      0 ≤ λ ⟂ E x + F λ + H u + c ≥ 0.
//! ```
//!
//! `M`, `J_N`, `J_T` and the friction directions are those of the state; the gap is linear in `δq` with slope `J_N`; the free
//! velocity is linearised in `q`, `v` and `u`. At the state itself the system is the step, without any error.
//!
//! Bilateral rows hold their motions at any impulse and are no complementarity conditions: their impulses are eliminated. With `P` the
//! projection onto the velocities that they admit, in the metric of `M`, every column `k` of a velocity becomes `P k`, and `E`, `F` and `H`
//! are what the contacts' rows make of these.
//!
//! With `λ' = (γ, λ_n, λ_t)` in the order of Aydinoglu et al., and of DAIRLab's c3: `λ_n' = λ_N/Δt`, `λ_t' = α/Δt` are forces, `γ = β`, and their
//! normal rows are gaps, ours times Δt, their rows of friction bounds ours over Δt. The matrices are then the same; a test writes theirs down.

#![allow(non_snake_case)]

use signorini_contact::ContactProblem;
use signorini_lcp::{Lcp, LcpError, Matrix, Scaling};
use signorini_multibody::{
    ContactPoint, FreeMotion, Input, Kinematics, Model, State, forward_kinematics_into, free_motion_into,
    integrate_into,
};

use signorini_solver::BilateralBasis;

use crate::{Settings, SimulationError, Workspace, step};

/// Step of the central differences, relative to the size of what is changed (at least 1).
const DIFFERENCE: f64 = 1e-6;

/// `x⁺ = A x + B u + D λ + d`, `0 ≤ λ ⟂ E x + F λ + H u + c ≥ 0`.
///
/// `x = (δq, v)`, `[2 nv]`; `u`, `[nu]`, one per actuator; `λ = (λ_N, α, β)`, `[nλ]` with `nλ = 2 nc + m`.
///
/// # Source
/// A. Aydinoglu, A. Wei, W.-C. Huang, M. Posa, *Consensus Complementarity Control for Multi-Contact MPC*, IEEE Transactions on
/// Robotics (2024), the definition of a linear complementarity system, with the letters as there.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct LinearComplementaritySystem {
    /// `[2 nv, 2 nv]`.
    pub A: Matrix,
    /// `[2 nv, nu]`.
    pub B: Matrix,
    /// `[2 nv, nλ]`.
    pub D: Matrix,
    /// `[2 nv]`.
    pub d: Vec<f64>,
    /// `[nλ, 2 nv]`.
    pub E: Matrix,
    /// `[nλ, nλ]`: the matrix of the standard LCP.
    pub F: Matrix,
    /// `[nλ, nu]`.
    pub H: Matrix,
    /// `[nλ]`.
    pub c: Vec<f64>,
    /// The state about which it was made, `x* = (0, v*)`, `[2 nv]`.
    pub x: Vec<f64>,
    /// The control about which it was made, `[nu]`.
    pub u: Vec<f64>,
    /// The contact problem of the step from there.
    pub problem: ContactProblem,
    scaling: Scaling,
}

/// Which contacts a system has.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub enum LinearizedContacts {
    /// Those of the step: what could touch within it.
    #[default]
    OfStep,
    /// All points of shapes, and all limits, that are at most so far from touching: m, for limits of hinges rad. A plan over several steps
    /// needs those that are met later.
    Within(f64),
    /// These points, wherever they are, with the limits of the step.
    Points(Vec<ContactPoint>),
}

impl LinearComplementaritySystem {
    /// The LCP of a step from `x` with `u`, in `λ`.
    ///
    /// # Errors
    /// [`LcpError`] if a number is not finite.
    ///
    /// # Panics
    /// If a length is another one.
    pub fn lcp(&self, x: &[f64], u: &[f64]) -> Result<Lcp, LcpError> {
        Lcp::with_scaling(self.F.clone(), sum(&self.c, [(&self.E, x), (&self.H, u)]), self.scaling.clone())
    }

    /// `x⁺ = A x + B u + D λ + d`, `[2 nv]`.
    ///
    /// # Panics
    /// If a length is another one.
    pub fn next(&self, x: &[f64], u: &[f64], lambda: &[f64]) -> Vec<f64> {
        let free = sum(&self.d, [(&self.A, x), (&self.B, u)]);
        let mut pushed = vec![0.0; free.len()];
        self.D.multiply_into(lambda, &mut pushed);
        pushed.iter().zip(free).map(|(p, f)| p + f).collect()
    }
}

/// The linear complementarity system of a step from `state` with `input`, with the contacts of the step.
///
/// # Errors
/// As [`linear_complementarity_system_with`].
///
/// # Cost
/// As there.
pub fn linear_complementarity_system(
    model: &Model,
    state: &State,
    input: &Input,
    settings: &Settings,
) -> Result<LinearComplementaritySystem, SimulationError> {
    linear_complementarity_system_with(model, state, input, settings, &LinearizedContacts::OfStep)
}

/// The linear complementarity system of a step from `state` with `input`, with the contacts that are asked for.
///
/// # Errors
/// As [`step`](crate::step()); [`SimulationError::Setting`] for a distance that is negative or not finite.
///
/// # Cost
/// `2 (2 nv + nu)` evaluations of the free motion, and a dense LCP; everything is allocated anew.
pub fn linear_complementarity_system_with(
    model: &Model,
    state: &State,
    input: &Input,
    settings: &Settings,
    contacts: &LinearizedContacts,
) -> Result<LinearComplementaritySystem, SimulationError> {
    let problem = problem_with(model, state, input, settings, contacts)?;
    let mut constraints = Constraints::new(&problem, settings.stabilization);
    let whole = problem.clone();
    let problem = without_bilateral_rows(problem);
    let (nv, nu, dt) = (model.nv, model.actuators.len(), problem.timestep);
    let lcp = problem.standard_lcp()?;
    let mut u = input.control.clone();
    u.resize(nu, 0.0);
    let x: Vec<f64> = std::iter::repeat_n(0.0, nv).chain(state.v.iter().copied()).collect();
    let mut slopes = free_velocity_slopes(model, state, &input.clone().with_control(u.clone()), dt)?;
    constraints.project(&mut slopes, true);

    let mixed = problem.mixed_lcp()?;
    let rows = Matrix::from_fn(lcp.len(), nv, |i, k| mixed.A()[(nv + i, k)]);
    let mut to_velocity = velocity_columns(&problem, &rows);
    let unconstrained = product(&rows, &to_velocity);
    constraints.project(&mut to_velocity, false);
    // What the constraints take from the couplings of contacts; nothing else in F has to do with velocities.
    let mut F = lcp.A().clone();
    if !constraints.is_empty() {
        let constrained = product(&rows, &to_velocity);
        F = Matrix::from_fn(F.rows(), F.cols(), |i, k| F[(i, k)] + (constrained[(i, k)] - unconstrained[(i, k)]));
    }
    let mut free_velocity = problem.free_velocity.clone();
    let correction = constraints.correction(&free_velocity, |k| whole.bilateral_violation[k] / dt);
    free_velocity.iter_mut().zip(&correction).for_each(|(v, c)| *v += c);
    let corrected: Vec<f64> = lcp
        .b()
        .iter()
        .enumerate()
        .map(|(i, b)| b + (0..nv).map(|k| rows[(i, k)] * correction[k]).sum::<f64>())
        .collect();
    let of_velocity = product(&rows, &slopes);
    let gap_slope = |i: usize, k: usize| match problem.gap.get(i) {
        Some(&phi) => rows[(i, k)] / dt * if phi < 0.0 { settings.stabilization } else { 1.0 },
        None => 0.0,
    };
    let A = with_positions(dt, &Matrix::from_fn(nv, 2 * nv, |i, k| slopes[(i, k)]), true);
    let B = with_positions(dt, &Matrix::from_fn(nv, nu, |i, k| slopes[(i, 2 * nv + k)]), false);
    let D = with_positions(dt, &to_velocity, false);
    let E = Matrix::from_fn(lcp.len(), 2 * nv, |i, k| of_velocity[(i, k)] + if k < nv { gap_slope(i, k) } else { 0.0 });
    let H = Matrix::from_fn(lcp.len(), nu, |i, k| of_velocity[(i, 2 * nv + k)]);
    let free = free_velocity.iter().map(|v| dt * v).chain(free_velocity.iter().copied()).collect();
    let d = remainder(free, [(&A, &x), (&B, &u)]);
    let c = remainder(corrected, [(&E, &x), (&H, &u)]);
    let scaling = lcp.scaling().clone();
    Ok(LinearComplementaritySystem { A, B, D, d, E, F, H, c, x, u, problem: whole, scaling })
}

/// The contact problem of a step, or of the contacts that are asked for instead.
fn problem_with(
    model: &Model,
    state: &State,
    input: &Input,
    settings: &Settings,
    contacts: &LinearizedContacts,
) -> Result<ContactProblem, SimulationError> {
    let mut ws = Workspace::new(model, settings)?;
    if let LinearizedContacts::OfStep = contacts {
        step(model, state, input, settings, &mut ws, &mut state.clone())?;
        return Ok(ws.problem().clone());
    }
    state.check(model)?;
    ws.begin(model, state, input, settings.timestep.unwrap_or(model.timestep))?;
    match contacts {
        LinearizedContacts::Within(distance) => {
            if !(*distance >= 0.0 && distance.is_finite()) {
                let (setting, expected) = ("distance of contacts", "finite and not negative");
                return Err(SimulationError::Setting { setting, expected, found: *distance });
            }
            ws.reach.by_pairs = false;
            ws.reach.reach.iter_mut().for_each(|reach| (reach.linear, reach.angular) = (*distance, 0.0));
            ws.find_points(model);
            ws.candidates.all.retain(|point| point.gap <= *distance);
        }
        LinearizedContacts::Points(points) => {
            ws.candidates.all.clear();
            ws.candidates.all.extend_from_slice(points);
        }
        LinearizedContacts::OfStep => {}
    }
    ws.candidates.choose_all();
    ws.build_problem(model, state, input);
    if let LinearizedContacts::Within(distance) = contacts {
        let still = vec![0.0; model.nv];
        let Workspace { builder, kinematics, .. } = &mut ws;
        builder.add_limits(model, kinematics, state, &still, |_, gap| gap <= *distance);
    }
    Ok(ws.problem().clone())
}

fn without_bilateral_rows(mut problem: ContactProblem) -> ContactProblem {
    problem.bilateral_violation.clear();
    problem.bilateral_jacobian.clear();
    problem
}

/// The bilateral rows of a problem, as what they make of velocities.
struct Constraints {
    basis: BilateralBasis,
    problem: ContactProblem,
    /// What `Θ/Δt` changes by per unit that a degree of freedom moves along a row.
    rate: f64,
}

impl Constraints {
    fn new(problem: &ContactProblem, stabilization: f64) -> Self {
        let mut basis = BilateralBasis::default();
        basis.factor(&problem.bilateral_jacobian, &problem.mass_factor);
        Self { basis, problem: problem.clone(), rate: stabilization / problem.timestep }
    }

    fn is_empty(&self) -> bool {
        self.problem.bilateral_violation.is_empty()
    }

    /// What the rows add to a velocity: the least change in the metric of M that brings `B v` to minus the extra rates.
    fn correction(&mut self, velocity: &[f64], extra: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut change = vec![0.0; velocity.len()];
        if !self.is_empty() {
            let rows = &self.problem.bilateral_jacobian;
            let rates = (0..rows.len()).map(|k| rows.multiply(k, velocity)[0] + extra(k));
            self.basis.solve_into(&rates.collect::<Vec<_>>(), &self.problem.mass_factor, &mut change);
        }
        change
    }

    /// Corrects columns of velocities; `by_configuration`: whether the first of them are those by `δq`, which violates the rows.
    fn project(&mut self, columns: &mut Matrix, by_configuration: bool) {
        if self.is_empty() {
            return;
        }
        let nv = columns.rows();
        for c in 0..columns.cols() {
            let column: Vec<f64> = (0..nv).map(|k| columns[(k, c)]).collect();
            let mut unit = vec![0.0; nv];
            if by_configuration && c < nv {
                unit[c] = self.rate;
            }
            let extra: Vec<f64> = {
                let rows = &self.problem.bilateral_jacobian;
                (0..rows.len()).map(|k| rows.multiply(k, &unit)[0]).collect()
            };
            let change = self.correction(&column, |k| extra[k]);
            (0..nv).for_each(|k| columns[(k, c)] += change[k]);
        }
    }
}

/// `∂v^f/∂(δq, v, u)`, `[nv, 2 nv + nu]`, by central differences.
fn free_velocity_slopes(model: &Model, state: &State, input: &Input, dt: f64) -> Result<Matrix, SimulationError> {
    let (nv, nu) = (model.nv, model.actuators.len());
    let (mut kinematics, mut smooth) = (Kinematics::new(model), FreeMotion::new(model));
    let mut slopes = Matrix::zeros(nv, 2 * nv + nu);
    for k in 0..2 * nv + nu {
        let size = if k < nv {
            1.0
        } else if k < 2 * nv {
            state.v[k - nv].abs().max(1.0)
        } else {
            input.control[k - 2 * nv].abs().max(1.0)
        };
        let h = DIFFERENCE * size;
        for sign in [1.0, -1.0] {
            let (mut state, mut input) = (state.clone(), input.clone());
            if k < nv {
                let mut direction = vec![0.0; nv];
                direction[k] = sign;
                let q = state.q.clone();
                integrate_into(model, &q, &direction, h, &mut state.q);
            } else if k < 2 * nv {
                state.v[k - nv] += sign * h;
            } else {
                input.control[k - 2 * nv] += sign * h;
            }
            kinematics.place_mocap(model, &input);
            forward_kinematics_into(model, &state.q, &state.v, &mut kinematics);
            free_motion_into(model, &kinematics, &state, &input, dt, &mut smooth)?;
            for (i, v) in smooth.free_velocity.iter().enumerate() {
                slopes[(i, k)] += sign * v / (2.0 * h);
            }
        }
    }
    Ok(slopes)
}

/// `M⁻¹ Rᵀ` for the rows `R` of the impulses, `[nv, nλ]`; the columns of `β` are zero.
fn velocity_columns(problem: &ContactProblem, rows: &Matrix) -> Matrix {
    let mut columns = Matrix::zeros(rows.cols(), rows.rows());
    for i in 0..rows.rows() {
        let mut column = rows.row(i).to_vec();
        problem.mass_factor.solve_in_place(&mut column);
        column.iter().enumerate().for_each(|(k, x)| columns[(k, i)] = *x);
    }
    columns
}

/// The rows of `δq⁺ = δq + Δt v⁺` above those of `v⁺`; `own`: with the identity for `δq`.
fn with_positions(dt: f64, velocity: &Matrix, own: bool) -> Matrix {
    let nv = velocity.rows();
    Matrix::from_fn(2 * nv, velocity.cols(), |i, k| match i.checked_sub(nv) {
        Some(i) => velocity[(i, k)],
        None => dt * velocity[(i, k)] + if own && i == k { 1.0 } else { 0.0 },
    })
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    Matrix::from_fn(a.rows(), b.cols(), |i, k| (0..a.cols()).map(|j| a[(i, j)] * b[(j, k)]).sum())
}

/// `value` less the sum of the products.
fn remainder(mut value: Vec<f64>, products: [(&Matrix, &Vec<f64>); 2]) -> Vec<f64> {
    for (matrix, x) in products {
        let mut out = vec![0.0; value.len()];
        matrix.multiply_into(x, &mut out);
        value.iter_mut().zip(out).for_each(|(v, p)| *v -= p);
    }
    value
}

/// `constant + Σ A_i x_i`.
fn sum(constant: &[f64], products: [(&Matrix, &[f64]); 2]) -> Vec<f64> {
    let mut total = constant.to_vec();
    let mut product = vec![0.0; constant.len()];
    for (matrix, x) in products {
        matrix.multiply_into(x, &mut product);
        total.iter_mut().zip(&product).for_each(|(t, p)| *t += p);
    }
    total
}
