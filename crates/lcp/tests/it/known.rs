//! Every method on the shared set of cases.

use signorini_lcp::{Enumeration, Lemke, MethodKind};

use crate::cases;
use crate::support::{assert_honest, assert_proof, solves};

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
        let proof = case.problem.infeasibility(&mut Lemke::default());
        assert_eq!(proof.is_some(), infeasible.contains(&case.name), "{}: {proof:?}", case.name);
        if let Some(proof) = proof {
            assert_proof(&case.problem, &proof, case.name);
        }
    }
}
