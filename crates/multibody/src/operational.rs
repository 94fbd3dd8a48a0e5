//! The inertia that a task feels.

use crate::cholesky::BlockCholesky;
use crate::small_dense::{factorise, solve};

/// A pivot of `J M⁻¹ Jᵀ` below this share of its diagonal entry belongs to a direction in which the task cannot move.
const SINGULAR: f64 = 1e-12;

/// Operational-space inertia `Λ = (J M⁻¹ Jᵀ)⁻¹` of the rows `J`: `Λ ẍ` is the force along the rows that accelerates them by `ẍ`.
///
/// - `factor`: of the mass matrix ([`BlockDiagonal::factor`](crate::BlockDiagonal::factor))
/// - `jacobian`: `J`, `[rows, nv]` row by row
///
/// Gives `Λ`, `[rows, rows]` row by row, or nothing where the rows depend on each other: at a singular configuration no force
/// accelerates the task in some direction.
///
/// # Panics
/// If `jacobian` is no whole number of rows.
///
/// # Source
/// Khatib (1987), A unified approach for motion and force control of robot manipulators, IEEE Journal of Robotics and Automation 3.
pub fn operational_space_inertia(factor: &BlockCholesky, jacobian: &[f64]) -> Option<Vec<f64>> {
    let nv = factor.blocks().iter().map(|block| block.range().end).max().unwrap_or(0);
    let rows = jacobian.len().checked_div(nv).unwrap_or(0);
    assert_eq!(rows * nv, jacobian.len(), "the Jacobian needs rows of nv entries");
    let row = |i: usize| &jacobian[i * nv..(i + 1) * nv];
    let mut mobility = vec![0.0; rows * rows];
    for i in 0..rows {
        let mut solved = row(i).to_vec();
        factor.solve_in_place(&mut solved);
        for j in 0..=i {
            mobility[i * rows + j] = row(j).iter().zip(&solved).map(|(a, b)| a * b).sum();
        }
    }
    factorise(&mut mobility, rows, SINGULAR)?;
    let mut inertia = vec![0.0; rows * rows];
    for column in 0..rows {
        let mut x = vec![0.0; rows];
        x[column] = 1.0;
        solve(&mobility, &mut x);
        (0..rows).for_each(|i| inertia[i * rows + column] = x[i]);
    }
    Some(inertia)
}
