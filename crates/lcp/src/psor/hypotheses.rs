//! What the theory of projected relaxation asks of a matrix.

use crate::equilibrate::Scaled;
use crate::linalg::Lu;
use crate::{Matrix, Refusal};

/// Diagonal entries of the equilibrated matrix below this count as zero.
const NO_DIAGONAL: f64 = 1e-12;
/// Differences of mirrored entries up to this count as rounding, for a unit diagonal.
const SYMMETRIC: f64 = 1e-10;
/// What elimination may leave below zero on the diagonal per row, for a unit diagonal.
const SEMIDEFINITE: f64 = 1e-12;
/// Entries beside a vanishing diagonal up to this count as rounding.
const BESIDE_ZERO: f64 = 1e-9;

/// Refuses a matrix for which no theorem promises convergence with this relaxation.
///
/// Accepted are matrices that a positive scaling of rows makes symmetric positive semidefinite with a positive
/// diagonal, and H₊-matrices. The iterates do not depend on scalings of rows or columns, hence neither does the test.
pub(super) fn check(scaled: &Scaled, relaxation: f64) -> Result<(), Refusal> {
    let n = scaled.n;
    for row in 0..n {
        let value = scaled.column(row)[row];
        if value <= NO_DIAGONAL {
            return Err(Refusal::Diagonal { row, value });
        }
    }
    let root: Vec<f64> = (0..n).map(|i| scaled.column(i)[i].sqrt()).collect();
    let unit = Matrix::from_fn(n, n, |i, j| scaled.column(j)[i] / (root[i] * root[j]));
    match symmetrized(&unit) {
        Ok(symmetric) => semidefinite(symmetric),
        Err((row, col)) => dominant(&unit, relaxation, row, col),
    }
}

/// `E⁻¹ S E` with the diagonal `E > 0` that makes it symmetric, or the place of an entry that stays unlike its mirror
/// image.
///
/// `E` is carried along a spanning tree of the strongest couplings `S_ij S_ji`, which no scaling changes.
///
/// Source: Prim (1957).
fn symmetrized(unit: &Matrix) -> Result<Matrix, (usize, usize)> {
    let n = unit.rows();
    let mut e = vec![1.0; n];
    let mut strongest = vec![(0.0f64, 0usize); n];
    let mut outside: Vec<usize> = (0..n).collect();
    while let Some(place) =
        (0..outside.len()).max_by(|&p, &q| strongest[outside[p]].0.total_cmp(&strongest[outside[q]].0))
    {
        let j = outside.swap_remove(place);
        let (coupling, i) = strongest[j];
        if coupling > 0.0 {
            e[j] = e[i] * (unit[(j, i)] / unit[(i, j)]).sqrt();
        }
        for &k in &outside {
            let coupling = unit[(j, k)] * unit[(k, j)];
            if coupling > strongest[k].0 {
                strongest[k] = (coupling, j);
            }
        }
    }
    let scaled = Matrix::from_fn(n, n, |i, j| unit[(i, j)] * e[j] / e[i]);
    for i in 0..n {
        for j in 0..i {
            let size = scaled[(i, j)].abs().max(scaled[(j, i)].abs()).max(1.0);
            if (scaled[(i, j)] - scaled[(j, i)]).abs() > SYMMETRIC * size {
                return Err((i, j));
            }
        }
    }
    Ok(scaled)
}

/// Cholesky elimination with the largest diagonal first.
///
/// Source: Higham (2002), §10.3.
fn semidefinite(mut S: Matrix) -> Result<(), Refusal> {
    let n = S.rows();
    let tolerance = SEMIDEFINITE * n as f64;
    let mut rest: Vec<usize> = (0..n).collect();
    while let Some(place) = (0..rest.len()).max_by(|&p, &q| {
        let diagonal = |p: usize| S[(rest[p], rest[p])];
        diagonal(p).total_cmp(&diagonal(q))
    }) {
        let k = rest.swap_remove(place);
        let pivot = S[(k, k)];
        if pivot <= tolerance {
            rest.push(k);
            break;
        }
        for &i in &rest {
            let factor = S[(i, k)] / pivot;
            if factor != 0.0 {
                for &j in &rest {
                    S[(i, j)] -= factor * S[(k, j)];
                }
            }
        }
    }
    for &i in &rest {
        let diagonal = S[(i, i)];
        if diagonal < -tolerance {
            return Err(Refusal::Indefinite { row: i, value: diagonal });
        }
        // Beside a vanishing diagonal an entry s gives the eigenvalue −|s|.
        let beside = rest.iter().filter(|&&j| j != i).fold(0.0f64, |max, &j| max.max(S[(i, j)].abs()));
        if beside > BESIDE_ZERO {
            return Err(Refusal::Indefinite { row: i, value: -beside });
        }
    }
    Ok(())
}

/// Whether `u > 0` exists with `a_ii u_i > Σ |a_ij| u_j` in every row, and the relaxation fits to it.
///
/// `u` solves the comparison matrix against its diagonal; the Jacobi matrix of `|A|` then has the norm `1 − 1/max u` in
/// the norm with the weights `u`.
///
/// Source: Ahn (1981); Cottle, Pang, Stone (2009), §3.3 and §5.3.
fn dominant(unit: &Matrix, relaxation: f64, row: usize, col: usize) -> Result<(), Refusal> {
    let n = unit.rows();
    let mut lu = Lu::default();
    for (k, x) in lu.start(n).iter_mut().enumerate() {
        let entry = unit.data()[k];
        *x = if k / n == k % n { entry } else { -entry.abs() };
    }
    let mut u = vec![1.0; n];
    if lu.factorize() == 0.0 {
        return Err(Refusal::NeitherSymmetricNorDominant { row, col, dominance: row });
    }
    lu.solve(&mut u);
    let by_size = |i: &usize, j: &usize| u[*i].total_cmp(&u[*j]);
    let (least, largest) = ((0..n).min_by(by_size).unwrap_or(0), (0..n).max_by(by_size).unwrap_or(0));
    if !(u[least] > 0.0 && u[largest].is_finite()) {
        return Err(Refusal::NeitherSymmetricNorDominant { row, col, dominance: least });
    }
    let limit = 2.0 / (2.0 - 1.0 / u[largest]);
    if relaxation > 1.0 && relaxation >= limit {
        return Err(Refusal::Relaxation { row: largest, limit });
    }
    Ok(())
}
