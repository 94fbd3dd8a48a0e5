//! Groups of bodies that bilateral rows alone tie together.

use signorini_laws::{LeastNorm, LeastNormOutcome};
use signorini_solver::ContactSolver;
use signorini_testkit::Random;
use signorini_testkit::reference::random_problem;

/// Every row twice, in problems of changing size with one memory: of least norm both copies have half of what their sum is, and the sum, of
/// independent rows, is what it was.
#[test]
fn copies_of_a_row_share_its_impulse_whatever_was_solved_before() {
    let mut random = Random::new(7);
    let mut least_norm = LeastNorm::default();
    for case in 0..60 {
        let rows = 1 + random.below(3);
        let mut problem = random_problem(&mut random, 0, rows);
        if problem.nv() < rows {
            continue;
        }
        for k in 0..rows {
            let (columns, entries) = problem.bilateral_jacobian.group(k);
            let row: Vec<(u32, [f64; 1])> = columns.iter().copied().zip(entries.iter().copied()).collect();
            problem.push_bilateral(row, problem.bilateral_violation[k]);
        }
        let mut solution = ContactSolver::default().solve(&problem, None);
        let sums: Vec<f64> = (0..rows).map(|k| solution.bilateral[k] + solution.bilateral[rows + k]).collect();
        let size = sums.iter().fold(0.0, |size: f64, sum| size.max(sum.abs()));
        let report = least_norm.apply(&problem, &mut solution, 1e-9);
        assert_eq!(report.outcome, LeastNormOutcome::Chosen, "{case}: {report:?}");
        for (k, sum) in sums.iter().enumerate() {
            for found in [solution.bilateral[k], solution.bilateral[rows + k]] {
                assert!((found - 0.5 * sum).abs() < 1e-7 * size, "{case}: row {k}: {found} is not half of {sum}");
            }
        }
    }
}
