//! Is there any `z ≥ 0` with `A z + b ≥ 0`? A proof when there is none.

use crate::{Farkas, Lcp, Matrix, Method};

/// Largest `Aᵀy` accepted as zero, for `A` of size 1 and relative to the sum of the multipliers.
const ROUNDING: f64 = 1e-10;

/// Looks for a proof that the problem is infeasible: `y ≥ 0`, `Aᵀy ≤ 0`, `bᵀy < 0`.
///
/// A ray of Lemke's method says that the method found no solution; this says whether the inequalities already
/// exclude one (squeezed) or only complementarity does (jammed). The proof with the least `|y|` is the solution of
///
/// ```text
/// 0 ≤ y ⟂ y + A u + b t ≥ 0,   0 ≤ u ⟂ −Aᵀy ≥ 0,   0 ≤ t ⟂ −bᵀy − 1 ≥ 0,
/// ```
///
/// whose matrix is positive semidefinite. `None` means that `method` found none; with a method that solves every
/// feasible positive semidefinite problem, like [`Lemke`](crate::Lemke), the problem is then feasible.
///
/// # Cost
/// That of a problem with `2n + 1` pairs.
///
/// # Source
/// Farkas (1902); Cottle, Pang, Stone (2009), §2.8 and theorem 3.1.2.
pub fn infeasibility(problem: &Lcp, method: &mut dyn Method) -> Option<Farkas> {
    let n = problem.len();
    let (s, t) = (problem.scaling().z(), problem.scaling().w());
    let largest = |x: &mut dyn Iterator<Item = f64>| x.fold(0.0f64, |max, x| max.max(x.abs()));
    let b_size = largest(&mut problem.b().iter().copied());
    if b_size == 0.0 {
        return None;
    }
    let in_one_unit = Matrix::from_fn(n, n, |i, j| t[i] * problem.A()[(i, j)] / s[j]);
    let A_size = match largest(&mut in_one_unit.data().iter().copied()) {
        0.0 => 1.0,
        size => size,
    };
    let A = |i: usize, j: usize| in_one_unit[(i, j)] / A_size;
    let b = |i: usize| t[i] * problem.b()[i] / b_size;
    let matrix = Matrix::from_fn(2 * n + 1, 2 * n + 1, |i, j| match (i / n.max(1), j / n.max(1)) {
        (0, 0) => f64::from(u8::from(i == j)),
        (0, 1) => A(i, j - n),
        (0, _) => b(i),
        (1, 0) => -A(j, i - n),
        (2, 0) => -b(j),
        _ => 0.0,
    });
    let mut right_hand_side = vec![0.0; 2 * n + 1];
    right_hand_side[2 * n] = -1.0;
    let dual = Lcp::new(matrix, right_hand_side).ok()?;
    let y = method.solve(&dual, None).z[..n].to_vec();
    let sum: f64 = y.iter().sum();
    let column = |j: usize| (0..n).map(|i| A(i, j) * y[i]).sum::<f64>();
    let negative = (0..n).map(|i| b(i) * y[i]).sum::<f64>() <= -0.5;
    let proved = negative && (0..n).all(|j| column(j) <= ROUNDING * sum);
    proved.then(|| Farkas { y: (0..n).map(|i| y[i] * t[i]).collect() })
}
