//! Lemke against the enumeration of all complementary bases on seeded random problems.

use signorini_lcp::{Enumeration, Lcp, Lemke, Matrix, Method, MixedLcp, infeasibility, solve_mixed};

use crate::support::{Random, assert_honest, assert_proof, gram, monotone, touching_contacts};

/// Solves with both methods; returns (Lemke solved it, enumeration solved it).
fn compare(problem: &Lcp, name: &str) -> (bool, bool) {
    let (mut lemke, mut enumeration) = (Lemke::default(), Enumeration::default());
    let solution = lemke.solve(problem, None);
    assert_honest(problem, &solution, lemke.tolerance(), name);
    let oracle = enumeration.solve(problem, None);
    assert_honest(problem, &oracle, enumeration.tolerance(), name);
    (solution.status.is_solved(), oracle.status.is_solved())
}

#[test]
fn p_matrices_have_one_solution_and_lemke_finds_it() {
    for seed in 0..200 {
        let mut random = Random(seed);
        let n = 1 + random.below(7);
        let mut A = random.matrix(n, n);
        for i in 0..n {
            A[(i, i)] = 1e-3 + A.row(i).iter().map(|a| a.abs()).sum::<f64>();
        }
        let problem = Lcp::new(A, random.vector(n)).unwrap();
        let solution = Lemke::default().solve(&problem, None);
        assert!(solution.status.is_solved(), "seed {seed}: {:?}", solution.status);
        let all = Enumeration::default().solution_set(&problem).unwrap().points;
        assert_eq!(all.len(), 1, "seed {seed}");
        let distance = all[0].z.iter().zip(&solution.z).fold(0.0f64, |max, (a, b)| max.max((a - b).abs()));
        assert!(distance < 1e-7, "seed {seed}: {distance}");
    }
}

#[test]
fn semidefinite_problems_are_solved_exactly_when_they_can_be() {
    let mut solvable = 0;
    for seed in 0..400 {
        let mut random = Random(1000 + seed);
        let n = 2 + random.below(6);
        let rank = 1 + random.below(n);
        let mut G = random.matrix(n, rank);
        if seed % 2 == 0 {
            // Small integers: exact ties and exactly singular blocks.
            G.data_mut().iter_mut().for_each(|x| *x = (3.0 * *x).round());
        }
        let mut b = random.vector(n);
        if seed % 3 == 0 {
            b.iter_mut().for_each(|x| *x = (2.0 * *x).round());
        }
        let (lemke, oracle) = compare(&Lcp::new(gram(&G), b).unwrap(), &format!("seed {seed}"));
        assert_eq!(lemke, oracle, "seed {seed}");
        solvable += usize::from(oracle);
    }
    assert!((50..350).contains(&solvable), "the family should mix both kinds: {solvable} of 400 solvable");
}

#[test]
fn strictly_copositive_problems_are_always_solved_by_lemke() {
    for seed in 0..200 {
        let mut random = Random(13_000 + seed);
        let n = 1 + random.below(7);
        // Nonnegative with a positive diagonal, plus positive semidefinite, plus skew-symmetric: not P0 as a rule.
        let A = monotone(&mut random, n, 1 + seed as usize % 2, false);
        let A = Matrix::from_fn(n, n, |i, j| A[(i, j)] + if i == j { 0.1 } else { 3.0 * random.signed().max(0.0) });
        let solved = compare(&Lcp::new(A, random.vector(n)).unwrap(), &format!("seed {seed}"));
        assert_eq!(solved, (true, true), "seed {seed}");
    }
}

#[test]
fn touching_contacts_are_always_solved() {
    for seed in 0..150 {
        let mut random = Random(2000 + seed);
        let (nc, m) = [(1, 4), (2, 2), (3, 2), (1, 8), (2, 4)][random.below(5)];
        let nv = 1 + random.below(6);
        let duplicates = if nc > 1 { random.below(nc) } else { 0 };
        let problem = touching_contacts(&mut random, nc, m, nv, duplicates);
        let solved = compare(&problem, &format!("seed {seed}"));
        assert_eq!(solved, (true, true), "seed {seed}: {nc} contacts, m = {m}, nv = {nv}, {duplicates} duplicates");
    }
}

#[test]
fn larger_redundant_contacts_are_solved() {
    for seed in 0..60 {
        let mut random = Random(3000 + seed);
        let (nc, m) = (4 + random.below(12), 4 + 4 * random.below(2));
        let nv = 2 + random.below(10);
        let duplicates = random.below(nc / 2);
        let problem = touching_contacts(&mut random, nc, m, nv, duplicates);
        let mut lemke = Lemke::default();
        let solution = lemke.solve(&problem, None);
        assert_honest(&problem, &solution, lemke.tolerance(), &format!("seed {seed}"));
        assert!(solution.status.is_solved(), "seed {seed}: {:?} {:?}", solution.status, solution.report);
    }
}

#[test]
fn lemke_claims_nothing_false_on_arbitrary_matrices() {
    let (mut by_lemke, mut by_oracle) = (0, 0);
    for seed in 0..600 {
        let mut random = Random(4000 + seed);
        let n = 1 + random.below(7);
        let integer = seed % 2 == 0;
        let mut entry = || {
            if integer { random.sign() } else { random.signed() }
        };
        let A = Matrix::from_fn(n, n, |_, _| entry());
        let b = (0..n).map(|_| entry()).collect();
        let (lemke, oracle) = compare(&Lcp::new(A, b).unwrap(), &format!("seed {seed}"));
        by_lemke += usize::from(lemke);
        by_oracle += usize::from(oracle);
    }
    assert!(by_lemke > 200 && by_oracle > 300, "solved: {by_lemke} by Lemke, {by_oracle} by enumeration");
}

#[test]
fn ill_conditioned_problems_are_solved_or_admitted() {
    for n in 2..=14 {
        let hilbert = Matrix::from_fn(n, n, |i, j| 1.0 / (i + j + 1) as f64);
        let b = (0..n).map(|i| if i % 3 == 0 { -1.0 } else { 0.1 }).collect();
        let problem = Lcp::new(hilbert, b).unwrap();
        let mut lemke = Lemke::default();
        let solution = lemke.solve(&problem, None);
        assert_honest(&problem, &solution, lemke.tolerance(), &format!("Hilbert {n}"));
    }
}

#[test]
fn every_semidefinite_problem_is_either_solved_or_proved_infeasible() {
    for seed in 0..200 {
        let mut random = Random(11_000 + seed);
        let n = 2 + random.below(10);
        let rank = 1 + random.below(n);
        let problem = Lcp::new(gram(&random.matrix(n, rank)), random.vector(n)).unwrap();
        let mut lemke = Lemke::default();
        let solved = lemke.solve(&problem, None).status.is_solved();
        let proof = infeasibility(&problem.clone().into());
        assert_ne!(solved, proof.is_some(), "seed {seed}");
        proof.iter().for_each(|proof| assert_proof(&problem, proof, &format!("seed {seed}")));
    }
}

#[test]
fn extreme_magnitudes_are_solved_or_admitted() {
    let mut solved = 0;
    for seed in 0..300 {
        let mut random = Random(12_000 + seed);
        let n = 1 + random.below(5);
        let range = [3.0, 30.0, 300.0][random.below(3)];
        let mut entry = || random.sign() * 10f64.powf(range * random.signed());
        let A = Matrix::from_fn(n, n, |_, _| entry());
        let b: Vec<f64> = (0..n).map(|_| entry()).collect();
        let free = (0..n).map(|i| i % 2 == 0).collect();
        let mixed = MixedLcp::new(A.clone(), b.clone(), free).unwrap();
        let problem = Lcp::new(A, b).unwrap();
        let mut lemke = Lemke::default();
        for solution in [lemke.solve(&problem, None), Enumeration::default().solve(&problem, None)] {
            assert_eq!(solution.residual, problem.residual(&solution.z), "seed {seed}");
            let within = solution.residual.within(lemke.tolerance());
            assert_eq!(solution.status.is_solved(), within, "seed {seed}: {:?}", solution.status);
            solved += usize::from(within);
        }
        let solution = solve_mixed(&mixed, &mut lemke, None);
        let within = mixed.residual(&solution.z).within(lemke.tolerance());
        assert_eq!(solution.status.is_solved(), within, "seed {seed}: {:?}", solution.status);
    }
    assert!(solved > 100, "solved: {solved}");
}
