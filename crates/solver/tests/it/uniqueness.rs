//! Whether a problem has one velocity only, decided from its data.

use signorini_contact::{ContactProblem, FrictionBound};
use signorini_testkit::Dense;

/// Whether `v⁺` is unique by one of two arguments:
///
/// 1. No bound depends on a contact: `v⁺` is then the minimiser of a strictly convex quadratic function over a polyhedron, or of
///    one plus the support functions of constant bounds.
/// 2. All rows are independent and friction is weak. For given bounds `s = λ_N` the impulses `x(s)` minimise `½ xᵀW x + qᵀx` over
///    a polyhedron whose offsets are linear in `s`; on each piece `dx` is the element of least W-norm with the offsets of `ds`, and the
///    one that moves each friction impulse along its face's affine hull, of norm at most `c |ds|`, has them, too. So
///    `‖dx‖ ≤ c √(λ_max/λ_min) ‖ds‖`, with `c² = max_i (μ_i² + Σ c_j²)` over the contact's groups, and where this is below 1 the
///    map `s → λ_N(x(s))` has one fixed point. `W = J M⁻¹ Jᵀ` with the bilateral rows eliminated.
pub fn is_unique(problem: &ContactProblem) -> bool {
    let couplings: Vec<f64> = (0..problem.contact_count()).map(|i| coupling(problem, i)).collect();
    let strongest = couplings.iter().fold(0.0, |a: f64, c| a.max(*c));
    strongest == 0.0 || condition(problem, &couplings).is_some_and(|condition| strongest * condition.sqrt() < 0.9)
}

/// `√(μ_i² + Σ c_j²)`.
fn coupling(problem: &ContactProblem, i: usize) -> f64 {
    let own = if problem.directions_of(i).is_empty() { 0.0 } else { problem.friction[i] };
    let of_group = |bound: &FrictionBound| bound.normal().filter(|(contact, _)| *contact == i).map_or(0.0, |n| n.1);
    problem.friction_groups.bound.iter().map(of_group).fold(own, f64::hypot)
}

/// A bound on `λ_max/λ_min` of `W`; nothing where rows are dependent.
fn condition(problem: &ContactProblem, couplings: &[f64]) -> Option<f64> {
    let nv = problem.nv();
    let mut rows: Vec<Vec<f64>> = Vec::new();
    let mut push = |columns: &[u32], entry: &dyn Fn(usize) -> f64| {
        let mut row = vec![0.0; nv];
        columns.iter().enumerate().for_each(|(k, &c)| row[c as usize] = entry(k));
        rows.push(row);
    };
    let nb = problem.bilateral_violation.len();
    for k in 0..nb {
        let (columns, entries) = problem.bilateral_jacobian.group(k);
        push(columns, &|e| entries[e][0]);
    }
    for (i, coupling) in couplings.iter().enumerate() {
        let (columns, entries) = problem.jacobian.group(i);
        (0..if *coupling > 0.0 && !problem.directions_of(i).is_empty() { 3 } else { 1 })
            .for_each(|r| push(columns, &|e| entries[e][r]));
    }
    for j in 0..problem.friction_groups.len() {
        let (columns, entries) = problem.friction_groups.jacobian.group(j);
        let line = entries.iter().all(|e| e[1] == 0.0);
        (0..if line { 1 } else { 2 }).for_each(|r| push(columns, &|e| entries[e][r]));
    }
    let n = rows.len();
    let jacobian = Dense { rows: n, columns: nv, data: rows.concat() };
    let mass = Dense::from_fn(nv, nv, |i, j| problem.mass.get(i, j));
    let factor = cholesky(&jacobian.times(&mass.inverse()).times(&jacobian.transposed()))?;
    // With the bilateral rows first, the rest of the factor is that of the Schur complement.
    let rest = Dense::from_fn(n - nb, n - nb, |i, j| factor[(nb + i, nb + j)]);
    let squares = |m: &Dense| m.data.iter().map(|x| x * x).sum::<f64>();
    // λ_max ≤ tr(L Lᵀ), 1/λ_min ≤ tr((L Lᵀ)⁻¹).
    Some(squares(&rest) * squares(&rest.inverse()))
}

/// `L` of `L Lᵀ`; nothing where a pivot is lost in rounding.
fn cholesky(a: &Dense) -> Option<Dense> {
    let n = a.rows;
    let largest = (0..n).map(|i| a[(i, i)]).fold(0.0, f64::max);
    let mut l = Dense::zeros(n, n);
    for i in 0..n {
        for j in 0..=i {
            let rest = a[(i, j)] - (0..j).map(|k| l[(i, k)] * l[(j, k)]).sum::<f64>();
            if i == j && rest <= 1e-9 * largest {
                return None;
            }
            l[(i, j)] = if i == j { rest.sqrt() } else { rest / l[(j, j)] };
        }
    }
    Some(l)
}
