//! Multipliers that prove that gaps and bilateral rows contradict each other.

use signorini_contact::{ContactProblem, GapContradiction};
use signorini_lcp::Alternative;

/// What is tuned here.
struct Tuning {
    /// A proof whose residual is larger is none.
    accept: f64,
}

/// Chosen by: the tolerance of certificates.
const TUNING: Tuning = Tuning { accept: 1e-9 };

/// Proves that no velocity satisfies a problem's gap rows and bilateral rows together; nothing where they do not contradict each other,
/// or where rounding hides it.
///
/// - `suspects`: contacts whose rows are tried first, as a denial names them; all contacts are tried after them
///
/// Farkas' [alternative](Alternative): among `y ≥ 0` and `z = z₊ − z₋` the point nearest to `J_Nᵀ y + J_Bᵀ z = 0`, `(φᵀ y + Θᵀ z)/Δt = −1`. It is hit where
/// the rows contradict each other and missed where a velocity satisfies them.
pub fn gap_contradiction(problem: &ContactProblem, suspects: &[usize]) -> Option<GapContradiction> {
    let everything: Vec<usize> = (0..problem.contact_count()).collect();
    let first = (!suspects.is_empty() && suspects.iter().all(|&i| i < everything.len())).then_some(suspects);
    [first, Some(everything.as_slice())].into_iter().flatten().find_map(|contacts| {
        let proof = nearest(problem, contacts);
        (proof.residual(problem) <= TUNING.accept).then_some(proof)
    })
}

/// Where a column's multiplier belongs.
#[derive(Clone, Copy)]
enum Row {
    Gap(usize),
    Bilateral(usize, f64),
}

/// The multipliers of these contacts' gap rows and of all bilateral rows that come nearest to a proof.
fn nearest(problem: &ContactProblem, contacts: &[usize]) -> GapContradiction {
    let size = problem.nv() + 1;
    let (mut rows, mut alternative) = (Vec::new(), Alternative::default());
    alternative.begin(size);
    let mut push = |row: Row, sign: f64, indices: &[u32], entries: &mut dyn Iterator<Item = f64>, distance: f64| {
        let column = alternative.push();
        indices.iter().zip(entries).for_each(|(&k, e)| column[k as usize] = sign * e);
        column[size - 1] = sign * distance / problem.timestep;
        rows.push(row);
    };
    for &i in contacts {
        let (indices, entries) = problem.jacobian.group(i);
        push(Row::Gap(i), 1.0, indices, &mut entries.iter().map(|e| e[0]), problem.gap[i]);
    }
    for (k, &violation) in problem.bilateral_violation.iter().enumerate() {
        let (indices, entries) = problem.bilateral_jacobian.group(k);
        for sign in [1.0, -1.0] {
            push(Row::Bilateral(k, sign), sign, indices, &mut entries.iter().map(|e| e[0]), violation);
        }
    }
    let mut proof = GapContradiction {
        normal: vec![0.0; problem.contact_count()],
        bilateral: vec![0.0; problem.bilateral_violation.len()],
    };
    alternative.find();
    for (row, &multiplier) in rows.iter().zip(alternative.coefficients()) {
        match *row {
            Row::Gap(i) => proof.normal[i] += multiplier,
            Row::Bilateral(k, sign) => proof.bilateral[k] += sign * multiplier,
        }
    }
    proof
}
