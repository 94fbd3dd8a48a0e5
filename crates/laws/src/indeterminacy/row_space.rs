//! The row space of a matrix, by orthogonalisation with pivoting.

use signorini_contact::vector::inner;

/// Rows shorter than this after orthogonalisation depend on the others; all rows begin with length 1.
const DEPENDENT: f64 = 1e-9;

/// An equation `aᵀx = b`.
#[derive(Clone, Debug)]
pub(super) struct Row {
    pub a: Vec<f64>,
    pub b: f64,
}

/// An orthonormal basis of the row space, with the right-hand sides carried along: the same solutions, full row rank.
///
/// # Source
/// Modified Gram–Schmidt with reorthogonalisation; Golub, Van Loan, *Matrix Computations* (2013), §5.2.
pub(super) fn orthonormal(mut rows: Vec<Row>) -> Vec<Row> {
    rows.retain_mut(|row| normalise(row, 0.0));
    let mut basis: Vec<Row> = Vec::new();
    while let Some(longest) = (0..rows.len()).max_by(|&i, &j| length(&rows[i]).total_cmp(&length(&rows[j]))) {
        let mut next = rows.swap_remove(longest);
        basis.iter().for_each(|earlier| remove(&mut next, earlier));
        if !normalise(&mut next, DEPENDENT) {
            break;
        }
        rows.iter_mut().for_each(|row| remove(row, &next));
        basis.push(next);
    }
    basis
}

/// The length of the part of `x` outside the space spanned by an orthonormal basis.
pub(super) fn distance(basis: &[Row], x: &[f64]) -> f64 {
    let mut rest = Row { a: x.to_vec(), b: 0.0 };
    for _ in 0..2 {
        basis.iter().for_each(|row| remove(&mut rest, row));
    }
    length(&rest)
}

fn length(row: &Row) -> f64 {
    inner(&row.a, &row.a).sqrt()
}

/// Removes the part of `row` along a unit row.
fn remove(row: &mut Row, unit: &Row) {
    let along = inner(&row.a, &unit.a);
    row.a.iter_mut().zip(&unit.a).for_each(|(x, u)| *x -= along * u);
    row.b -= along * unit.b;
}

/// Gives a row the length 1; `false` if it is not longer than `least`.
fn normalise(row: &mut Row, least: f64) -> bool {
    let length = length(row);
    if length <= least {
        return false;
    }
    row.a.iter_mut().for_each(|x| *x /= length);
    row.b /= length;
    true
}
