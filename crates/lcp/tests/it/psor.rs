//! Projected relaxation: convergence where theory promises it, refusals with their place elsewhere.

use signorini_lcp::{Enumeration, Lcp, Lemke, Matrix, Method, Psor, PsorSettings, Refusal, Status};

use crate::support::{Random, assert_honest, gram, p_matrix, touching_contacts};

fn psor(relaxation: f64, subspace: bool) -> Psor {
    Psor::new(PsorSettings::default().with_relaxation(relaxation).with_subspace(subspace)).unwrap()
}

fn refusal(method: &mut Psor, A: Matrix) -> Refusal {
    let n = A.rows();
    match method.solve(&Lcp::new(A, vec![-1.0; n]).unwrap(), None).status {
        Status::Refused(refusal) => refusal,
        status => panic!("{status:?}"),
    }
}

fn from_rows(rows: &[&[f64]]) -> Matrix {
    Matrix::new(rows.len(), rows.len(), rows.concat()).unwrap()
}

#[test]
fn symmetric_positive_definite_problems_are_solved() {
    for seed in 0..60 {
        let mut random = Random(30_000 + seed);
        let n = 1 + random.below(12);
        let mut A = gram(&random.matrix(n, n));
        (0..n).for_each(|i| A[(i, i)] += 0.1);
        let problem = Lcp::new(A, random.vector(n)).unwrap();
        let oracle = Lemke::default().solve(&problem, None);
        for (relaxation, subspace) in [(1.0, true), (1.0, false), (1.5, true), (1.5, false), (0.3, true)] {
            let mut method = psor(relaxation, subspace);
            let solution = method.solve(&problem, None);
            let name = format!("seed {seed}, relaxation {relaxation}, subspace {subspace}");
            assert_honest(&problem, &solution, method.tolerance(), &name);
            assert!(solution.status.is_solved(), "{name}: {:?}", solution.residual);
            let distance = oracle.z.iter().zip(&solution.z).fold(0.0f64, |max, (a, b)| max.max((a - b).abs()));
            assert!(distance < 1e-7, "{name}: {distance}");
        }
    }
}

#[test]
fn the_subspace_step_saves_sweeps_and_reaches_rounding() {
    let (mut with, mut without) = (0, 0);
    for seed in 0..30 {
        let mut random = Random(31_000 + seed);
        let n = 10;
        let mut A = gram(&random.matrix(n, n));
        (0..n).for_each(|i| A[(i, i)] += 0.05);
        let problem = Lcp::new(A, random.vector(n)).unwrap();
        let exact = psor(1.0, true).solve(&problem, None);
        assert!(exact.residual.value < 1e-13, "seed {seed}: {:?}", exact.residual);
        with += exact.iterations;
        without += psor(1.0, false).solve(&problem, None).iterations;
    }
    assert!(2 * with < without, "{with} sweeps with the subspace step, {without} without");
}

#[test]
fn singular_semidefinite_problems_are_solved_when_they_can_be() {
    let mut solvable = 0;
    for seed in 0..100 {
        let mut random = Random(32_000 + seed);
        let n = 2 + random.below(6);
        let rank = 1 + random.below(n);
        let problem = Lcp::new(gram(&random.matrix(n, rank)), random.vector(n)).unwrap();
        let mut method = Psor::default();
        let solution = method.solve(&problem, None);
        assert_honest(&problem, &solution, method.tolerance(), &format!("seed {seed}"));
        let oracle = Enumeration::default().solve(&problem, None).status.is_solved();
        assert_eq!(solution.status.is_solved(), oracle, "seed {seed}: {:?} {:?}", solution.status, solution.residual);
        assert!(oracle || solution.status == Status::IterationLimit, "seed {seed}: {:?}", solution.status);
        solvable += usize::from(oracle);
    }
    assert!((20..90).contains(&solvable), "{solvable} of 100 solvable");
}

#[test]
fn dominant_matrices_are_solved_symmetric_or_not() {
    for seed in 0..60 {
        let mut random = Random(33_000 + seed);
        let n = 2 + random.below(10);
        let mut A = random.matrix(n, n);
        for i in 0..n {
            A[(i, i)] = 1.01 * (0..n).filter(|j| *j != i).map(|j| A[(i, j)].abs()).sum::<f64>();
        }
        // Dominant only after its columns are scaled back.
        let scales: Vec<f64> = (0..n).map(|_| 4f64.powf(random.signed())).collect();
        let A = Matrix::from_fn(n, n, |i, j| A[(i, j)] * scales[j]);
        let problem = Lcp::new(A, random.vector(n)).unwrap();
        let mut method = Psor::default();
        let solution = method.solve(&problem, None);
        assert_honest(&problem, &solution, method.tolerance(), &format!("seed {seed}"));
        assert!(solution.status.is_solved(), "seed {seed}: {:?}", solution.status);
        let known = Lemke::default().solve(&problem, None);
        let distance = known.z.iter().zip(&solution.z).fold(0.0f64, |max, (a, b)| max.max((a - b).abs()));
        assert!(distance < 1e-7, "seed {seed}: {distance}");
    }
}

#[test]
fn refusals_name_the_hypothesis_and_its_place() {
    let mut method = Psor::default();
    let zero = refusal(&mut method, from_rows(&[&[1.0, 0.5], &[0.5, 0.0]]));
    assert_eq!(zero, Refusal::Diagonal { row: 1, value: 0.0 });
    let negative = refusal(&mut method, from_rows(&[&[-1.0, 0.5], &[0.5, 1.0]]));
    assert!(matches!(negative, Refusal::Diagonal { row: 0, value } if value < 0.0), "{negative}");
    // Symmetric with the eigenvalues 3 and −1.
    let indefinite = refusal(&mut method, from_rows(&[&[1.0, 2.0], &[2.0, 1.0]]));
    assert!(matches!(indefinite, Refusal::Indefinite { value, .. } if (value + 3.0).abs() < 1e-12), "{indefinite}");
    // Z₃-symmetric rotation: P, but neither symmetric nor dominant.
    let rotation = from_rows(&[&[1.0, 0.0, -3.0], &[3.0, 1.0, 0.0], &[0.0, 3.0, 1.0]]);
    let neither = refusal(&mut method, rotation);
    assert!(matches!(neither, Refusal::NeitherSymmetricNorDominant { .. }), "{neither}");
    // |A| has the Jacobi norm 1/2: up to 4/3.
    let dominant = from_rows(&[&[2.0, -1.0], &[1.0, 2.0]]);
    let relaxation = refusal(&mut psor(1.5, true), dominant.clone());
    assert!(
        matches!(relaxation, Refusal::Relaxation { limit, .. } if (limit - 4.0 / 3.0).abs() < 1e-12),
        "{relaxation}"
    );
    assert!(psor(1.3, true).solve(&Lcp::new(dominant, vec![-1.0, -1.0]).unwrap(), None).status.is_solved());
}

#[test]
fn a_symmetric_matrix_is_recognised_in_any_scaling() {
    for seed in 0..60 {
        let mut random = Random(34_000 + seed);
        let n = 3 + random.below(7);
        let rank = 1 + random.below(n - 2);
        let symmetric = gram(&random.matrix(n, rank));
        let mut power = || 10f64.powi(random.below(7) as i32 - 3);
        let (rows, cols): (Vec<f64>, Vec<f64>) = (0..n).map(|_| (power(), power())).unzip();
        let mut A = Matrix::from_fn(n, n, |i, j| rows[i] * symmetric[(i, j)] * cols[j]);
        let status = |A: &Matrix| Psor::default().solve(&Lcp::new(A.clone(), vec![-1.0; n]).unwrap(), None).status;
        assert!(!matches!(status(&A), Status::Refused(_)), "seed {seed}: {:?}", status(&A));
        // Singular, hence not H₊; with every entry coupled no scaling repairs a single one.
        A[(1, 0)] *= 1.01;
        let refused = matches!(status(&A), Status::Refused(Refusal::NeitherSymmetricNorDominant { .. }));
        assert!(refused, "seed {seed}: {:?}", status(&A));
    }
}

#[test]
fn general_p_matrices_and_contact_problems_are_refused() {
    for seed in 0..40 {
        let mut random = Random(35_000 + seed);
        let n = 4 + random.below(6);
        let A = p_matrix(&mut random, n);
        let neither = refusal(&mut Psor::default(), A);
        assert!(matches!(neither, Refusal::NeitherSymmetricNorDominant { .. }), "seed {seed}: {neither}");
        let contacts = touching_contacts(&mut random, 2, 4, 6, 0);
        let bound = contacts.len() - 2;
        let status = Psor::default().solve(&contacts, None).status;
        assert!(
            matches!(status, Status::Refused(Refusal::Diagonal { row, .. }) if row == bound),
            "seed {seed}: {status:?}"
        );
    }
}

#[test]
fn the_sweep_limit_is_a_status_and_a_warm_start_saves_sweeps() {
    let mut random = Random(36_000);
    let n = 30;
    let mut A = gram(&random.matrix(n, n));
    (0..n).for_each(|i| A[(i, i)] += 1e-6);
    let problem = Lcp::new(A, vec![-1.0; n]).unwrap();
    let mut short = Psor::new(PsorSettings::default().with_sweeps(3)).unwrap();
    let solution = short.solve(&problem, None);
    assert_eq!((solution.status, solution.iterations), (Status::IterationLimit, 3));
    let basis = Lemke::default().solve(&problem, None).basis;
    let warm = short.solve(&problem, Some(&basis));
    assert!(warm.status.is_solved() && warm.iterations == 0, "{:?}", warm.report);
}
