//! The semismooth Newton methods: P-matrices, semidefinite ones, and honesty elsewhere.

use signorini_lcp::{Enumeration, Lcp, Matrix, Method, NewtonMap, SemismoothNewton, SemismoothNewtonSettings, Status};

use crate::support::{Random, assert_honest, gram, monotone, p_matrix, quadratic_program};

const MAPS: [NewtonMap; 2] = [NewtonMap::FischerBurmeister, NewtonMap::Minimum];

fn newton(map: NewtonMap) -> SemismoothNewton {
    SemismoothNewton::new(SemismoothNewtonSettings::default().with_map(map)).unwrap()
}

#[test]
fn p_matrices_are_solved_at_their_one_solution() {
    for map in MAPS {
        for seed in 0..150 {
            let mut random = Random(40_000 + seed);
            let n = 1 + random.below(8);
            let problem = Lcp::new(p_matrix(&mut random, n), random.vector(n)).unwrap();
            let solution = newton(map).solve(&problem, None);
            assert!(solution.status.is_solved(), "{map:?} seed {seed}: {:?}", solution.status);
            let oracle = Enumeration::default().solve(&problem, None);
            let distance = oracle.z.iter().zip(&solution.z).fold(0.0f64, |max, (a, b)| max.max((a - b).abs()));
            assert!(distance < 1e-8, "{map:?} seed {seed}: {distance}");
        }
    }
}

#[test]
fn large_p_matrices_take_few_steps() {
    for map in MAPS {
        for seed in 0..5 {
            let mut random = Random(41_000 + seed);
            let n = 100;
            let mut A = gram(&random.matrix(n, n));
            (0..n).for_each(|i| A[(i, i)] += 1.0);
            let problem = Lcp::new(A, random.vector(n)).unwrap();
            let solution = newton(map).solve(&problem, None);
            assert!(
                solution.status.is_solved() && solution.iterations <= 30,
                "{map:?} seed {seed}: {:?}",
                solution.report
            );
        }
    }
}

#[test]
fn solvable_semidefinite_problems_are_mostly_solved_and_never_claimed_wrongly() {
    for map in MAPS {
        let (mut solvable, mut solved) = (0, 0);
        for seed in 0..300 {
            let mut random = Random(42_000 + seed);
            let n = 2 + random.below(6);
            let rank = random.below(n + 1);
            let A = if seed % 2 == 0 { gram(&random.matrix(n, rank)) } else { monotone(&mut random, n, rank, false) };
            let problem = Lcp::new(A, random.vector(n)).unwrap();
            let mut method = newton(map);
            let solution = method.solve(&problem, None);
            assert_honest(&problem, &solution, method.tolerance(), &format!("{map:?} seed {seed}"));
            let oracle = Enumeration::default().solve(&problem, None).status.is_solved();
            solvable += usize::from(oracle);
            solved += usize::from(solution.status.is_solved());
            assert!(oracle || !solution.status.is_solved(), "{map:?} seed {seed}");
        }
        assert!(solved * 100 >= solvable * 98, "{map:?}: {solved} of {solvable}");
    }
}

#[test]
fn quadratic_programs_are_solved() {
    for map in MAPS {
        for seed in 0..60 {
            let mut random = Random(43_000 + seed);
            let (n, rows) = (1 + random.below(10), 1 + random.below(10));
            let problem = quadratic_program(&mut random, n, rows, n, true);
            let mut method = newton(map);
            let solution = method.solve(&problem, None);
            assert_honest(&problem, &solution, method.tolerance(), &format!("{map:?} seed {seed}"));
            assert!(solution.status.is_solved(), "{map:?} seed {seed}: {:?} {:?}", solution.status, solution.report);
        }
    }
}

#[test]
fn a_stationary_point_that_is_no_solution_is_called_so() {
    // φ(z, −z − 1) has no zero: Ψ has its minimum where the gradient vanishes.
    let problem = Lcp::new(Matrix::new(1, 1, vec![-1.0]).unwrap(), vec![-1.0]).unwrap();
    for map in MAPS {
        let solution = newton(map).solve(&problem, None);
        assert!(matches!(solution.status, Status::Stationary { gradient } if gradient < 1e-4), "{:?}", solution.status);
    }
}

#[test]
fn arbitrary_matrices_are_solved_or_admitted() {
    for map in MAPS {
        let mut solved = 0;
        for seed in 0..300 {
            let mut random = Random(44_000 + seed);
            let n = 1 + random.below(7);
            let mut entry = || if seed % 2 == 0 { random.sign() } else { random.signed() };
            let A = Matrix::from_fn(n, n, |_, _| entry());
            let b = (0..n).map(|_| entry()).collect();
            let problem = Lcp::new(A, b).unwrap();
            let mut method = newton(map);
            let solution = method.solve(&problem, None);
            assert_honest(&problem, &solution, method.tolerance(), &format!("{map:?} seed {seed}"));
            solved += usize::from(solution.status.is_solved());
        }
        assert!(solved > 120, "{map:?}: {solved}");
    }
}

#[test]
fn a_warm_basis_is_taken_as_the_start() {
    let mut random = Random(45_000);
    let problem = Lcp::new(p_matrix(&mut random, 12), random.vector(12)).unwrap();
    let cold = newton(NewtonMap::FischerBurmeister).solve(&problem, None);
    let warm = newton(NewtonMap::FischerBurmeister).solve(&problem, Some(&cold.basis));
    assert!(cold.iterations > 0 && warm.iterations == 0 && warm.status.is_solved());
}
