//! Starting from a basis of a similar problem.

use signorini_lcp::{Basis, Lcp, Lemke, LemkeSettings, Method, Outcome, Start};

use crate::support::{Random, assert_honest, gram, touching_contacts};

#[test]
fn the_basis_of_the_solution_solves_without_pivots() {
    for seed in 0..50 {
        let mut random = Random(7000 + seed);
        let problem = touching_contacts(&mut random, 4, 4, 6, 1);
        let mut lemke = Lemke::default();
        let cold = lemke.solve(&problem, None);
        let warm = lemke.solve(&problem, Some(&cold.basis));
        assert!(warm.status.is_solved(), "seed {seed}");
        assert_eq!(warm.iterations, 0, "seed {seed}");
        assert_eq!(warm.report.attempts.len(), 1, "seed {seed}");
        assert_eq!(warm.report.attempts[0].start, Start::Warm);
        assert_eq!(warm.basis, cold.basis, "seed {seed}");
    }
}

#[test]
fn a_similar_problem_needs_fewer_pivots() {
    let (mut cold_pivots, mut warm_pivots) = (0, 0);
    for seed in 0..50 {
        let mut random = Random(8000 + seed);
        let problem = touching_contacts(&mut random, 8, 4, 12, 2);
        let b = problem.b().iter().map(|b| b * (1.0 + 0.02 * random.signed())).collect();
        let next = Lcp::with_scaling(problem.A().clone(), b, problem.scaling().clone()).unwrap();
        let mut lemke = Lemke::default();
        let basis = lemke.solve(&problem, None).basis;
        let warm = lemke.solve(&next, Some(&basis));
        assert_honest(&next, &warm, lemke.tolerance(), &format!("seed {seed}"));
        let cold = lemke.solve(&next, None);
        assert_eq!(warm.status.is_solved(), cold.status.is_solved(), "seed {seed}: {:?}", warm.report);
        warm_pivots += warm.iterations;
        cold_pivots += cold.iterations;
    }
    assert!(warm_pivots * 2 < cold_pivots, "{warm_pivots} warm, {cold_pivots} cold");
}

#[test]
fn any_basis_is_a_valid_start() {
    for seed in 0..100 {
        let mut random = Random(9000 + seed);
        let problem = touching_contacts(&mut random, 3, 4, 6, 1);
        let basis = Basis { z_basic: (0..problem.len()).map(|_| random.below(2) == 1).collect() };
        let mut lemke = Lemke::default();
        let solution = lemke.solve(&problem, Some(&basis));
        assert_honest(&problem, &solution, lemke.tolerance(), &format!("seed {seed}"));
        assert!(solution.status.is_solved(), "seed {seed}: {:?}", solution.report);
    }
}

#[test]
fn a_singular_basis_with_a_consistent_system_is_accepted() {
    // Four identical rows, all active: only the sum of z is determined.
    let mut random = Random(1);
    let row = random.vector(3);
    let A = gram(&signorini_lcp::Matrix::from_fn(4, 3, |_, j| row[j]));
    let problem = Lcp::new(A, vec![-1.0; 4]).unwrap();
    let mut lemke = Lemke::default();
    let solution = lemke.solve(&problem, Some(&Basis { z_basic: vec![true; 4] }));
    assert!(solution.status.is_solved() && solution.iterations == 0, "{:?}", solution.report);
    assert!(solution.z.iter().all(|z| *z > 0.0), "near the least norm all take part: {:?}", solution.z);
}

#[test]
fn a_basis_of_another_size_is_left_out_of_the_report() {
    let problem = touching_contacts(&mut Random(2), 2, 4, 6, 0);
    let solution = Lemke::default().solve(&problem, Some(&Basis::slack(3)));
    assert!(solution.status.is_solved());
    assert!(matches!(solution.report.attempts[0].start, Start::Cold { covering: 0 }));
}

#[test]
fn the_pivot_limit_is_an_outcome() {
    let mut random = Random(3);
    let n = 300;
    let A = gram(&random.matrix(n, n));
    let problem = Lcp::new(A, vec![-1.0; n]).unwrap();
    let settings = LemkeSettings::default().with_pivots_per_pair(1).with_covering_vectors(1);
    let mut lemke = Lemke::new(settings).unwrap();
    let solution = lemke.solve(&problem, None);
    assert_honest(&problem, &solution, lemke.tolerance(), "limited");
    assert!(solution.report.attempts.iter().all(|attempt| attempt.pivots <= n + 100));
    let stopped = solution.report.attempts[0].outcome == Outcome::IterationLimit;
    assert!(stopped || solution.status.is_solved(), "{:?}", solution.report);
}
