//! Principal pivoting against enumeration, on the classes for which it is guaranteed and beyond.

use signorini_lcp::{
    Enumeration, Lcp, Lemke, Matrix, Method, Outcome, PrincipalPivoting, PrincipalPivotingSettings, Refusal, Start,
    Status, infeasibility,
};

use crate::support::{Random, assert_honest, gram, monotone, p_matrix, quadratic_program, touching_contacts};

/// Solved, or proved infeasible, without a refusal; returns whether solved.
fn decided(problem: &Lcp, name: &str) -> bool {
    let mut method = PrincipalPivoting::default();
    let solution = method.solve(problem, None);
    assert_honest(problem, &solution, method.tolerance(), name);
    // A point this far out cannot be written down more accurately.
    let far = solution.z.iter().any(|z| *z > 1e6);
    let settled = matches!(solution.status, Status::Solved | Status::Infeasible(_))
        || solution.status == Status::Inaccurate && far;
    assert!(settled, "{name}: {:?} {:?}", solution.status, solution.report);
    solution.status.is_solved()
}

#[test]
fn symmetric_semidefinite_problems_are_decided() {
    let mut solvable = 0;
    for seed in 0..400 {
        let mut random = Random(20_000 + seed);
        let n = 2 + random.below(7);
        let rank = 1 + random.below(n);
        let mut G = random.matrix(n, rank);
        if seed % 2 == 0 {
            G.data_mut().iter_mut().for_each(|x| *x = (3.0 * *x).round());
        }
        let mut b = random.vector(n);
        if seed % 3 == 0 {
            b.iter_mut().for_each(|x| *x = (2.0 * *x).round());
        }
        let problem = Lcp::new(gram(&G), b).unwrap();
        let oracle = Enumeration::default().solve(&problem, None).status.is_solved();
        assert_eq!(decided(&problem, &format!("seed {seed}")), oracle, "seed {seed}");
        solvable += usize::from(oracle);
    }
    assert!((50..350).contains(&solvable), "{solvable} of 400 solvable");
}

#[test]
fn monotone_problems_are_decided_however_many_ties() {
    let mut solvable = 0;
    for seed in 0..600 {
        let mut random = Random(21_000 + seed);
        let n = 2 + random.below(7);
        let rank = random.below(n);
        let A = monotone(&mut random, n, rank, seed % 2 == 0);
        let b = (0..n).map(|_| if seed % 4 < 2 { random.sign() } else { random.signed() }).collect();
        let problem = Lcp::new(A, b).unwrap();
        let solved = decided(&problem, &format!("seed {seed}"));
        // A monotone problem is solvable exactly when it is feasible (Cottle, Pang, Stone 2009, theorem 3.1.2).
        let proof = infeasibility(&problem.clone().into());
        assert_ne!(solved, proof.is_some(), "seed {seed}");
        solvable += usize::from(solved);
    }
    assert!((100..500).contains(&solvable), "{solvable} of 600 solvable");
}

#[test]
fn p_matrices_are_solved_at_their_one_solution() {
    for seed in 0..200 {
        let mut random = Random(22_000 + seed);
        let n = 1 + random.below(8);
        let problem = Lcp::new(p_matrix(&mut random, n), random.vector(n)).unwrap();
        let solution = PrincipalPivoting::default().solve(&problem, None);
        assert!(solution.status.is_solved(), "seed {seed}: {:?}", solution.status);
        let oracle = Enumeration::default().solve(&problem, None);
        let distance = oracle.z.iter().zip(&solution.z).fold(0.0f64, |max, (a, b)| max.max((a - b).abs()));
        assert!(distance < 1e-8, "seed {seed}: {distance}");
    }
}

#[test]
fn quadratic_programs_agree_with_lemke() {
    for seed in 0..150 {
        let mut random = Random(23_000 + seed);
        let (n, rows) = (1 + random.below(20), 1 + random.below(20));
        let rank = random.below(n + 1);
        let problem = quadratic_program(&mut random, n, rows, rank, seed % 3 != 0);
        let solved = decided(&problem, &format!("seed {seed}"));
        assert_eq!(solved, Lemke::default().solve(&problem, None).status.is_solved(), "seed {seed}");
    }
}

#[test]
fn a_matrix_that_is_not_sufficient_is_refused_at_its_place() {
    let refusal = |rows: &[f64], b: &[f64]| {
        let problem = Lcp::new(Matrix::new(b.len(), b.len(), rows.to_vec()).unwrap(), b.to_vec()).unwrap();
        match PrincipalPivoting::default().solve(&problem, None).status {
            Status::Refused(refusal) => refusal,
            status => panic!("{status:?}"),
        }
    };
    // w₁ = −z₁ − 1: the driving variable only makes it worse.
    assert!(matches!(refusal(&[-1.0], &[-1.0]), Refusal::NotSufficient { row: 0, col: 0, value } if value < 0.0));
    // z₂ grows for w₂ < 0 and drives w₁ to 0, whose diagonal is negative.
    let blocked = refusal(&[-1.0, -1.0, 0.0, 1.0], &[1.0, -5.0]);
    assert!(matches!(blocked, Refusal::NotSufficient { row: 0, col: 0, .. }), "{blocked}");
    // The same with a zero diagonal and a mirror entry of the same sign.
    let same_sign = refusal(&[0.0, -1.0, -1.0, 1.0], &[1.0, -5.0]);
    assert!(matches!(same_sign, Refusal::NotSufficient { row: 1, col: 0, .. }), "{same_sign}");
    // z₁ grows forever, and row 1 does not prove anything: its other entry is positive.
    let unproved = refusal(&[0.0, 1.0, 1.0, 0.0], &[-1.0, 1.0]);
    assert!(matches!(unproved, Refusal::NotSufficient { row: 0, col: 1, value } if value > 0.0), "{unproved}");
    assert!(unproved.to_string().contains("(0, 1)"), "{unproved}");
}

#[test]
fn nothing_false_is_claimed_on_arbitrary_matrices() {
    let mut solved = 0;
    for seed in 0..600 {
        let mut random = Random(24_000 + seed);
        let n = 1 + random.below(7);
        let mut entry = || if seed % 2 == 0 { random.sign() } else { random.signed() };
        let A = Matrix::from_fn(n, n, |_, _| entry());
        let b = (0..n).map(|_| entry()).collect();
        let problem = Lcp::new(A, b).unwrap();
        let mut method = PrincipalPivoting::default();
        let solution = method.solve(&problem, None);
        assert_honest(&problem, &solution, method.tolerance(), &format!("seed {seed}"));
        solved += usize::from(solution.status.is_solved());
        let oracle = Enumeration::default().solve(&problem, None);
        assert!(!matches!(solution.status, Status::Infeasible(_)) || !oracle.status.is_solved(), "seed {seed}");
    }
    assert!(solved > 150, "{solved} solved");
}

#[test]
fn a_similar_problem_needs_fewer_pivots_from_the_last_basis() {
    let (mut cold, mut warm) = (0, 0);
    for seed in 0..40 {
        let mut random = Random(25_000 + seed);
        let n = 20;
        let problem = Lcp::new(p_matrix(&mut random, n), random.vector(n)).unwrap();
        let b = problem.b().iter().map(|b| b + 0.02 * random.signed()).collect();
        let next = Lcp::with_scaling(problem.A().clone(), b, problem.scaling().clone()).unwrap();
        let mut method = PrincipalPivoting::default();
        let basis = method.solve(&problem, None).basis;
        let from_basis = method.solve(&next, Some(&basis));
        assert!(from_basis.status.is_solved(), "seed {seed}");
        assert_eq!(from_basis.report.attempts[0].start, Start::Advanced);
        warm += from_basis.iterations;
        cold += method.solve(&next, None).iterations;
    }
    assert!(4 * warm < cold, "{warm} warm, {cold} cold");
}

#[test]
fn contact_problems_are_solved_or_refused() {
    // Copositive, not sufficient: no promise, but often enough it gets through.
    let mut solved = 0;
    for seed in 0..60 {
        let mut random = Random(26_000 + seed);
        let problem = touching_contacts(&mut random, 3, 4, 6, 1);
        let mut method = PrincipalPivoting::default();
        let solution = method.solve(&problem, None);
        assert_honest(&problem, &solution, method.tolerance(), &format!("seed {seed}"));
        assert!(!matches!(solution.status, Status::Infeasible(_)), "seed {seed}: all have a solution");
        solved += usize::from(solution.status.is_solved());
    }
    assert!(solved > 0, "{solved} of 60 solved");
}

#[test]
fn the_pivot_limit_is_an_outcome() {
    let n = 200;
    let A = p_matrix(&mut Random(27_000), n);
    let problem = Lcp::new(A, vec![-1.0; n]).unwrap();
    let settings = PrincipalPivotingSettings::default().with_pivots_per_pair(1);
    let solution = PrincipalPivoting::new(settings).unwrap().solve(&problem, None);
    let attempt = &solution.report.attempts[0];
    assert!(attempt.pivots <= n + 101, "{attempt:?}");
    assert_eq!(attempt.outcome == Outcome::IterationLimit, !solution.status.is_solved());
}
