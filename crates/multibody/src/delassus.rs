//! The inverse operational-space inertia of many points together, `J M⁻¹ Jᵀ`: the Delassus operator of the contacts.
//!
//! # Choice of the algorithm
//! With `A = LᵀL` factorised along the tree, every contact's rows are half-solved, `Y_i = L⁻ᵀ J_iᵀ`, in one sweep from the
//! contact's bodies to the root, and `J_i M⁻¹ J_jᵀ = Y_iᵀ Y_j` on the degrees of freedom that both have. For contacts at
//! depth d (degrees of freedom on the way to the root) this costs 3 d²/2 multiplications for a contact and 9 d' for a
//! pair, d' the common depth. The methods of extended forces (EFPA of Wensing, Featherstone, Orin 2012; KJR of Kreutz-Delgado,
//! Jain, Rodriguez 1991) need no factor and no d², but carry a 6 × 3 force matrix past every joint, about 18 · 6 d for a
//! contact, and 54 for a pair. On robots d is between 3 and 20 and d' about 6, the base: half-solves cost no more there, `L` is at hand
//! because the step needs it, and armature, implicit springs and dampers are in it at no cost. For chains of more than
//! about 50 joints with many contacts at the far end the other methods need fewer operations.

use crate::cholesky::BlockCholesky;
use crate::jacobian::JacobianRows;

/// Half-solved rows, `Y = L⁻ᵀ Jᵀ`; storage that is reused.
#[derive(Clone, Debug, Default)]
pub struct HalfSolvedRows {
    offsets: Vec<usize>,
    dofs: Vec<usize>,
    columns: Vec<[f64; 3]>,
}

/// The Delassus operator `G = J M⁻¹ Jᵀ` of several groups of three rows.
///
/// - `factor`: of `M` (or of the effective mass of a step)
/// - `rows`: `J_i`, one group per contact or point ([`contact_rows_into`](crate::contact_rows_into),
///   [`point_rows_into`](crate::point_rows_into))
/// - `out`: `G`, `[3 n, 3 n]` row by row, symmetric, 1/kg for linear rows
///
/// # Panics
/// If `out` does not have `9 n²` entries, or rows do not belong to the factor's model.
///
/// # Cost
/// 3 d²/2 multiplications for a contact with d degrees of freedom, 9 d' for a pair with d' in common; no allocation once
/// the storage has grown.
///
/// # Source
/// Featherstone (2010), Exploiting sparsity in operational-space dynamics, International Journal of Robotics Research 29.
pub fn delassus_into(factor: &BlockCholesky, rows: &[JacobianRows], work: &mut HalfSolvedRows, out: &mut [f64]) {
    let size = 3 * rows.len();
    assert_eq!(out.len(), size * size, "the operator needs 9 n² entries");
    work.half_solve(factor, rows);
    for i in 0..rows.len() {
        for j in 0..=i {
            let block = work.product(i, j);
            for a in 0..3 {
                for b in 0..3 {
                    out[(3 * i + a) * size + 3 * j + b] = block[a][b];
                    out[(3 * j + b) * size + 3 * i + a] = block[a][b];
                }
            }
        }
    }
}

impl HalfSolvedRows {
    fn half_solve(&mut self, factor: &BlockCholesky, rows: &[JacobianRows]) {
        self.offsets.clear();
        self.dofs.clear();
        self.columns.clear();
        self.offsets.push(0);
        for group in rows {
            let start = self.dofs.len();
            self.dofs.extend_from_slice(&group.dofs);
            self.columns.extend_from_slice(&group.columns);
            factor.half_solve_sparse(&self.dofs[start..], &mut self.columns[start..]);
            self.offsets.push(self.dofs.len());
        }
    }

    /// `Y_iᵀ Y_j`, over the degrees of freedom that are in both lists.
    fn product(&self, i: usize, j: usize) -> [[f64; 3]; 3] {
        let (mut p, mut q) = (self.offsets[i], self.offsets[j]);
        let (p_end, q_end) = (self.offsets[i + 1], self.offsets[j + 1]);
        let mut sum = [[0.0; 3]; 3];
        while p < p_end && q < q_end {
            match self.dofs[p].cmp(&self.dofs[q]) {
                std::cmp::Ordering::Less => p += 1,
                std::cmp::Ordering::Greater => q += 1,
                std::cmp::Ordering::Equal => {
                    let (x, y) = (self.columns[p], self.columns[q]);
                    for a in 0..3 {
                        for b in 0..3 {
                            sum[a][b] += x[a] * y[b];
                        }
                    }
                    (p, q) = (p + 1, q + 1);
                }
            }
        }
        sum
    }
}
