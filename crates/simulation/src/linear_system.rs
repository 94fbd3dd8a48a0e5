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

#![allow(non_snake_case)]

use signorini_contact::ContactProblem;
use signorini_lcp::Matrix;
use signorini_multibody::{
    FreeMotion, Input, Kinematics, Model, State, forward_kinematics_into, free_motion_into, integrate_into,
};

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
}

/// The linear complementarity system of a step from `state` with `input`.
///
/// # Errors
/// As [`step`](crate::step()); [`SimulationError::Problem`] if the problem has bilateral rows, which are no complementarity
/// conditions.
///
/// # Cost
/// `2 (2 nv + nu)` evaluations of the free motion, and a dense LCP; everything is allocated anew.
pub fn linear_complementarity_system(
    model: &Model,
    state: &State,
    input: &Input,
    settings: &Settings,
) -> Result<LinearComplementaritySystem, SimulationError> {
    let mut workspace = Workspace::new(model, settings)?;
    step(model, state, input, settings, &mut workspace, &mut state.clone())?;
    let problem = workspace.problem().clone();
    let (nv, nu, dt) = (model.nv, model.actuators.len(), problem.timestep);
    let lcp = problem.standard_lcp()?;
    let mut u = input.control.clone();
    u.resize(nu, 0.0);
    let x: Vec<f64> = std::iter::repeat_n(0.0, nv).chain(state.v.iter().copied()).collect();
    let slopes = free_velocity_slopes(model, state, &input.clone().with_control(u.clone()), dt)?;

    let mixed = problem.mixed_lcp()?;
    let rows = Matrix::from_fn(lcp.len(), nv, |i, k| mixed.A()[(nv + i, k)]);
    let to_velocity = velocity_columns(&problem, &rows);
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
    let free = problem.free_velocity.iter().map(|v| dt * v).chain(problem.free_velocity.iter().copied()).collect();
    let d = remainder(free, [(&A, &x), (&B, &u)]);
    let c = remainder(lcp.b().to_vec(), [(&E, &x), (&H, &u)]);
    Ok(LinearComplementaritySystem { A, B, D, d, E, F: lcp.A().clone(), H, c, x, u, problem })
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
