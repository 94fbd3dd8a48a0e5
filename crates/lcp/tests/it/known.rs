//! Every method on the shared set of cases.

use signorini_lcp::{Enumeration, Lcp, Lemke, LemkeSettings, Matrix, Method, MethodKind, Status, infeasibility};

use crate::cases;
use crate::support::{Random, assert_honest, assert_proof, gram, monotone, solves};

#[test]
fn the_known_answers_are_answers() {
    for case in cases::all() {
        for z in &case.solutions {
            assert!(solves(&case.problem, z, 1e-12), "{}: {z:?} does not solve it", case.name);
            assert!(case.problem.residual(z).value <= 1e-12, "{}: residual of {z:?}", case.name);
        }
        for z in &case.non_solutions {
            assert!(!solves(&case.problem, z, 1e-2), "{}: {z:?} solves it", case.name);
            assert!(case.problem.residual(z).value > 1e-2, "{}: residual of {z:?}", case.name);
        }
    }
}

#[test]
fn lemke_with_the_memory_and_settings_of_another_problem_answers_as_a_new_one() {
    let mut used = Lemke::default();
    for settings in [LemkeSettings::default().with_covering_vectors(9), LemkeSettings::default()] {
        for case in cases::all() {
            used.set(settings.clone()).unwrap();
            let again = used.solve(&case.problem, None);
            let afresh = Lemke::new(settings.clone()).unwrap().solve(&case.problem, None);
            assert_eq!(
                (again.z, again.status, again.iterations),
                (afresh.z, afresh.status, afresh.iterations),
                "{}",
                case.name
            );
        }
    }
    assert!(used.set(LemkeSettings::default().with_tie(1.0)).is_err());
    assert_eq!(used.tolerance(), LemkeSettings::default().tolerance, "refused settings are not taken");
}

#[test]
fn every_method_solves_what_has_a_solution_and_nothing_else() {
    for kind in MethodKind::all() {
        let mut method = kind.build().unwrap();
        for case in cases::all() {
            let name = format!("{kind} on {}", case.name);
            let solution = method.solve(&case.problem, None);
            assert_honest(&case.problem, &solution, method.tolerance(), &name);
            let solvable = !case.solutions.is_empty();
            let refused = case.beyond.contains(&kind.to_string().as_str());
            assert_eq!(solution.status.is_solved(), solvable && !refused, "{name}: {:?}", solution.status);
            if solution.status.is_solved() && case.complete {
                let near = |known: &Vec<f64>| known.iter().zip(&solution.z).all(|(a, b)| (a - b).abs() < 1e-9);
                assert!(case.solutions.iter().any(near), "{name}: unknown solution {:?}", solution.z);
            }
        }
    }
}

#[test]
fn enumeration_finds_exactly_the_known_solutions() {
    for case in cases::all().into_iter().filter(|case| case.complete) {
        let set = Enumeration::default().solution_set(&case.problem).unwrap();
        assert!(set.is_finite(), "{}: {:?}", case.name, set.continua);
        let found = set.points;
        assert_eq!(found.len(), case.solutions.len(), "{}: {:?}", case.name, found);
        for known in &case.solutions {
            let near = |z: &[f64]| known.iter().zip(z).all(|(a, b)| (a - b).abs() < 1e-9);
            assert!(found.iter().any(|solution| near(&solution.z)), "{}: {known:?} not found", case.name);
        }
    }
}

#[test]
fn infeasibility_is_proved_where_there_is_any() {
    let infeasible = ["zero matrix, negative b", "negative matrix, negative b", "squeezed"];
    for case in cases::all() {
        let proof = infeasibility(&case.problem.clone().into());
        assert_eq!(proof.is_some(), infeasible.contains(&case.name), "{}: {proof:?}", case.name);
        if let Some(proof) = proof {
            assert_proof(&case.problem, &proof, case.name);
        }
    }
}

#[test]
fn the_hard_families_of_murty_and_fathi_are_solved() {
    for n in [4, 8, 16, 32] {
        // Murty (1988), chapter 6: an exponential number of pivots for some rules; z = e_n. Fathi (1979): its
        // transpose times itself, symmetric positive definite with a condition that grows with n; z = e_1.
        let murty = Matrix::from_fn(n, n, |i, j| if i == j { 1.0 } else { 2.0 * f64::from(u8::from(j > i)) });
        let fathi = gram(&murty.transposed());
        for (name, A, place) in [("Murty", murty, n - 1), ("Fathi", fathi, 0)] {
            let problem = Lcp::new(A, vec![-1.0; n]).unwrap();
            for kind in MethodKind::all() {
                if kind.to_string() == "enumeration" && n > 8 {
                    continue;
                }
                let mut method = kind.build().unwrap();
                let solution = method.solve(&problem, None);
                let label = format!("{kind} on {name}, n = {n}");
                assert_honest(&problem, &solution, method.tolerance(), &label);
                assert!(solution.status.is_solved(), "{label}: {:?}", solution.report);
                for (i, z) in solution.z.iter().enumerate() {
                    assert!((z - f64::from(u8::from(i == place))).abs() < 1e-8, "{label}: z[{i}] = {z}");
                }
            }
        }
    }
}

/// A ray of a monotone problem is a proof (Cottle, Pang, Stone 2009, theorem 4.4.9) in the units in which its matrix is monotone: those of
/// bodies of very different size, which no equilibration keeps.
#[test]
fn monotone_problems_without_a_solution_are_proved_to_have_none() {
    let (mut proved, mut solved) = (0, 0);
    for seed in 0..400 {
        let mut random = Random(46_000 + seed);
        let n = 2 + random.below(6);
        let rank = random.below(n);
        let K = monotone(&mut random, n, rank, seed % 2 == 0);
        let units: Vec<f64> = (0..n).map(|_| 2.0_f64.powi(random.below(25) as i32 - 12)).collect();
        let A = Matrix::from_fn(n, n, |i, j| units[i] * K[(i, j)] * units[j]);
        let b = units.iter().map(|unit| unit * (random.signed() - 0.3)).collect();
        let problem = Lcp::new(A, b).unwrap();
        let is_infeasible = infeasibility(&problem.clone().into()).is_some();
        let solution = Lemke::default().solve(&problem, None);
        assert_honest(&problem, &solution, 1e-10, &format!("seed {seed}"));
        match solution.status {
            Status::Infeasible(_) => {
                assert!(is_infeasible, "seed {seed}");
                proved += 1;
            }
            Status::Solved => {
                assert!(!is_infeasible, "seed {seed}");
                solved += 1;
            }
            other => panic!("seed {seed}: {other:?}"),
        }
    }
    assert!(proved > 80 && solved > 80, "{proved} proved, {solved} solved");
}
