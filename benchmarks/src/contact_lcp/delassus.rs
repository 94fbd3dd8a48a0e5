//! Contact problems that are given in impulse space only.
#![allow(non_snake_case)] // matrices keep the letters of the formulas

use std::error::Error;

use signorini::contact::problem_file::FrictionalProblem;
use signorini::contact::{ContactProblem, FrictionPolygon};
use signorini::multibody::BlockDiagonal;

/// Larger problems are left out: their factor would not fit into memory.
const MOST_ROWS: usize = 3000;

/// A pivot below this fraction of the largest diagonal entry is rounding.
const NEGLIGIBLE: f64 = 1e-13;

/// A tangential free velocity that no motion has, beyond this fraction of the largest free velocity, makes no contact problem.
const INCONSISTENT: f64 = 1e-6;

/// A contact problem with the Delassus operator `W` and the free contact velocities `q` of the given one: `M = 1`, `J = L` with
/// `W = L Lᵀ` by Cholesky with diagonal pivoting, `v^f` from `q` on the rows of the pivots, and `φ/Δt` for what that leaves of
/// the normal part of `q`.
///
/// `W` is made symmetric first, and what makes it indefinite (rounding in printed digits) is dropped. So the problem may differ
/// from the file's by that much; all solvers get the same one. Nothing where no motion has the tangential part of `q`.
///
/// # Errors
/// For more than 3,000 rows, and numbers that make no problem.
pub(super) fn contact_problem(
    given: &FrictionalProblem,
    directions: usize,
) -> Result<Option<ContactProblem>, Box<dyn Error>> {
    let (dimension, nc, q) = (given.dimension, given.friction.len(), &given.free_velocity);
    let rows = dimension * nc;
    if rows > MOST_ROWS {
        return Err(format!("{rows} rows are more than {MOST_ROWS}").into());
    }
    let (factor, pivots) = factor(given);
    let rank = pivots.len();
    let mut rest = q.clone();
    let mut free_velocity = vec![0.0; rank];
    for k in 0..rank {
        free_velocity[k] = rest[pivots[k]] / factor[k][pivots[k]];
        rest.iter_mut().zip(&factor[k]).for_each(|(r, l)| *r -= l * free_velocity[k]);
    }
    let largest = q.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
    let tangential = (0..rows).filter(|r| r % dimension != 0).map(|r| rest[r].abs()).fold(0.0, f64::max);
    if tangential > INCONSISTENT * largest {
        return Ok(None);
    }
    let mut identity = vec![0.0; rank * rank];
    (0..rank).for_each(|k| identity[k * (rank + 1)] = 1.0);
    let mut problem = ContactProblem::new(BlockDiagonal::from_dense(rank, &identity)?, free_velocity, 1.0)?;
    let polygon = FrictionPolygon::regular(if dimension == 2 { 2 } else { directions }, 0.0)?;
    for i in 0..nc {
        let entry = |k: usize, r: usize| if r < dimension { factor[k][dimension * i + r] } else { 0.0 };
        let columns = (0..rank).map(|k| (k as u32, std::array::from_fn(|r| entry(k, r))));
        let columns = columns.filter(|(_, e): &(u32, [f64; 3])| e.iter().any(|x| *x != 0.0));
        problem.push_contact(columns, rest[dimension * i], given.friction[i], &polygon);
    }
    problem.check()?;
    Ok(Some(problem))
}

/// The columns of `L` and the row of each one's pivot, for the symmetric part of `W`.
fn factor(given: &FrictionalProblem) -> (Vec<Vec<f64>>, Vec<usize>) {
    let (W, rows) = (&given.delassus, given.free_velocity.len());
    let mut left: Vec<f64> = (0..rows).map(|i| W[(i, i)]).collect();
    let largest = left.iter().copied().fold(0.0, f64::max);
    let (mut columns, mut pivots): (Vec<Vec<f64>>, Vec<usize>) = (Vec::new(), Vec::new());
    while let Some(pivot) = (0..rows).max_by(|&i, &j| left[i].total_cmp(&left[j])) {
        if left[pivot] <= NEGLIGIBLE * largest || pivots.contains(&pivot) {
            break;
        }
        let mut column: Vec<f64> = (0..rows).map(|i| 0.5 * (W[(i, pivot)] + W[(pivot, i)])).collect();
        for earlier in columns.iter().filter(|earlier| earlier[pivot] != 0.0) {
            let weight = earlier[pivot];
            column.iter_mut().zip(earlier).for_each(|(x, l)| *x -= weight * l);
        }
        pivots.iter().for_each(|&done| column[done] = 0.0);
        let size = left[pivot].sqrt();
        column[pivot] = left[pivot];
        column.iter_mut().for_each(|x| *x /= size);
        left.iter_mut().zip(&column).for_each(|(d, l)| *d -= l * l);
        left[pivot] = 0.0;
        columns.push(column);
        pivots.push(pivot);
    }
    (columns, pivots)
}

#[cfg(test)]
mod tests {
    use super::*;
    use signorini::lcp::Matrix;

    /// A box on four contacts: the factor must give back `W` and `q`, which has rank 6 and 12 rows.
    #[test]
    fn the_standard_lcp_is_that_of_the_given_operator() {
        let motions: Vec<[f64; 6]> = (0..12)
            .map(|row| {
                let (x, y) = ([-1.0, 1.0, 1.0, -1.0][row / 3], [-1.0, -1.0, 1.0, 1.0][row / 3]);
                [[0.0, 0.0, 1.0, y, -x, 0.0], [1.0, 0.0, 0.0, 0.0, -0.5, -y], [0.0, 1.0, 0.0, 0.5, 0.0, x]][row % 3]
            })
            .collect();
        let velocity = [0.3, -0.2, -1.0, 0.1, 0.4, -0.6];
        let dot = |a: &[f64; 6], b: &[f64; 6]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let given = FrictionalProblem {
            delassus: Matrix::from_fn(12, 12, |i, j| dot(&motions[i], &motions[j])),
            free_velocity: motions.iter().map(|row| dot(row, &velocity)).collect(),
            friction: vec![0.5; 4],
            dimension: 3,
        };
        let problem = contact_problem(&given, 8).unwrap().unwrap();
        assert_eq!(problem.nv(), 6);
        let (found, expected) = (problem.standard_lcp().unwrap(), given.polygonal_lcp(8).unwrap());
        let off = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off(found.A().data(), expected.A().data()) < 1e-12);
        assert!(off(found.b(), expected.b()) < 1e-12);
        let mut torn = given.clone();
        torn.free_velocity[4] += 0.1;
        assert!(contact_problem(&torn, 8).unwrap().is_none(), "no rigid motion has these velocities");
    }
}
