//! Proofs that there is no solution: against all complementary bases one by one, and judged by the data.

use signorini_lcp::linalg::Lu;
use signorini_lcp::{
    Enumeration, Existence, Lcp, Matrix, Method, MixedLcp, PairCase, Status, decide, exclude, infeasibility,
};

use crate::support::Random;

/// A general problem, by turns with integers, which have ties.
fn random_problem(random: &mut Random, n: usize, integer: bool) -> (Matrix, Vec<f64>) {
    let mut entry = || if integer { random.sign() } else { random.signed() };
    let A = Matrix::from_fn(n, n, |_, _| entry());
    let b = (0..n).map(|_| entry() - 0.2).collect();
    (A, b)
}

#[test]
fn the_search_agrees_with_all_bases() {
    let mut counts = [0, 0, 0];
    for seed in 0..600 {
        let mut random = Random(40_000 + seed);
        let n = 1 + random.below(7);
        let (A, b) = random_problem(&mut random, n, seed % 2 == 0);
        let problem = Lcp::new(A.clone(), b).unwrap();
        let solvable = Enumeration::default().solve(&problem, None).status.is_solved();
        match exclude(&problem.clone().into(), 10_000) {
            Existence::Solved(z) => {
                assert!(solvable && problem.residual(&z).within(1e-9), "seed {seed}");
                counts[0] += 1;
            }
            Existence::Excluded(proof) => {
                assert!(!solvable && proof.residual(&problem.clone().into()) < 1e-9, "seed {seed}");
                assert_eq!(proof.is_infeasible(), infeasibility(&problem.into()).is_some(), "seed {seed}");
                counts[if proof.is_infeasible() { 1 } else { 2 }] += 1;
                // Nothing is proved where a case is missing, and nothing of a problem that z = 0 solves.
                let mut less = proof.clone();
                less.cases.pop();
                assert_eq!(less.residual(&MixedLcp::from(Lcp::new(A.clone(), vec![-1.0; n]).unwrap())), f64::INFINITY);
                let solved = MixedLcp::from(Lcp::new(A, vec![1.0; n]).unwrap());
                assert!(proof.residual(&solved) > 1e-6, "seed {seed}");
            }
            other => panic!("seed {seed}: {other:?}"),
        }
    }
    assert!(counts.iter().all(|count| *count > 30), "{counts:?}");
}

/// Whether a basis of a mixed problem solves it, by elimination: the oracle where no matrix of a basis is singular.
fn has_basis(problem: &MixedLcp) -> bool {
    let n = problem.len();
    (0..1u32 << n).any(|code| {
        let active: Vec<usize> = (0..n).filter(|&i| problem.free()[i] || code >> i & 1 == 1).collect();
        let mut lu = Lu::default();
        let matrix = lu.start(active.len());
        for (r, &i) in active.iter().enumerate() {
            for (c, &j) in active.iter().enumerate() {
                matrix[r * active.len() + c] = problem.A()[(i, j)];
            }
        }
        if lu.factorize() < 1e-9 {
            return false;
        }
        let mut x: Vec<f64> = active.iter().map(|&i| -problem.b()[i]).collect();
        lu.solve(&mut x);
        let mut z = vec![0.0; n];
        active.iter().zip(x).for_each(|(&i, x)| z[i] = x);
        problem.residual(&z).within(1e-9)
    })
}

#[test]
fn mixed_problems_are_decided_too() {
    let mut counts = [0, 0];
    for seed in 0..300 {
        let mut random = Random(41_000 + seed);
        let n = 2 + random.below(5);
        let (A, b) = random_problem(&mut random, n, false);
        let free: Vec<bool> = (0..n).map(|i| i == 0 || random.below(3) == 0).collect();
        let problem = MixedLcp::new(A, b, free).unwrap();
        let found = exclude(&problem, 10_000);
        assert_eq!(matches!(found, Existence::Solved(_)), has_basis(&problem), "seed {seed}: {found:?}");
        counts[usize::from(has_basis(&problem))] += 1;
        if let Existence::Excluded(proof) = found {
            assert!(proof.residual(&problem) < 1e-9, "seed {seed}");
            // A free variable is in no pair.
            let mut claimed = proof.clone();
            claimed.cases[0].pairs[0] = PairCase::NoW;
            assert_eq!(claimed.residual(&problem), f64::INFINITY, "seed {seed}");
        } else {
            assert!(matches!(found, Existence::Solved(z) if problem.residual(&z).within(1e-9)), "seed {seed}");
        }
    }
    assert!(counts.iter().all(|count| *count > 40), "{counts:?}");
}

#[test]
fn what_lemke_leaves_open_is_decided() {
    // w₂ = z₂ + 1 > 0, so z₂ = 0, and w₁ = z₂ − 1 < 0; without complementarity z₂ = 1 would do.
    let jammed = Lcp::new(Matrix::new(2, 2, vec![0.0, 1.0, 0.0, 1.0]).unwrap(), vec![-1.0, 1.0]).unwrap();
    let mut solution = signorini_lcp::Lemke::default().solve(&jammed, None);
    let proof = decide(&jammed.clone().into(), &mut solution).expect("a proof");
    assert_eq!(solution.status, Status::NoSolution);
    assert!(proof.cases.len() == 2 && !proof.is_infeasible() && proof.residual(&jammed.into()) == 0.0, "{proof:?}");
    // One that is not copositive, and has a solution.
    let game = Matrix::new(2, 2, vec![-1.0, 2.0, 3.0, -1.0]).unwrap();
    let problem = Lcp::new(game, vec![-1.0, -2.0]).unwrap();
    let mut solution = signorini_lcp::Lemke::default().solve(&problem, None);
    assert_eq!(decide(&problem.clone().into(), &mut solution), None);
    assert!(solution.status.is_solved() && problem.residual(&solution.z).within(1e-10), "{solution:?}");
}

/// A tree of `k` cases has `2k − 1` nodes, all of which are looked at: one fewer leaves the answer open.
#[test]
fn the_search_looks_at_so_many_cases_and_no_more() {
    let mut split = 0;
    for seed in 0..100 {
        let mut random = Random(44_000 + seed);
        let n = 2 + random.below(4);
        let (A, b) = random_problem(&mut random, n, true);
        let problem = MixedLcp::from(Lcp::new(A, b).unwrap());
        let Existence::Excluded(proof) = exclude(&problem, 10_000) else { continue };
        let nodes = 2 * proof.cases.len() - 1;
        assert_eq!(exclude(&problem, nodes), Existence::Excluded(proof), "seed {seed}");
        assert_eq!(exclude(&problem, nodes - 1), Existence::Undecided, "seed {seed}");
        split += usize::from(nodes > 1);
    }
    assert!(split > 5, "{split}");
}
