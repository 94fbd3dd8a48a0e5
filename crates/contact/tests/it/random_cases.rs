//! Problems of `benchmarks/random_steps` that were hard at some time: those in `tests/data/random_steps/solvable` must be solved. The
//! numbers in a name are the seed and the step.

use std::path::PathBuf;

use signorini_contact::problem_file::{ProblemFile, read};
use signorini_contact::{ContactProblem, ContactSolver, SolveStatus, WarmStart};

use crate::reference::worst_violation;

fn cases(folder: &str) -> Vec<(String, ContactProblem)> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/random_steps").join(folder);
    let files = std::fs::read_dir(folder).expect("a folder of cases").map(|entry| entry.expect("readable").path());
    let problem = |path: PathBuf| match read(&path).expect("a problem") {
        ProblemFile::Contact(problem) => (path.display().to_string(), *problem),
        _ => panic!("{}: not a contact problem", path.display()),
    };
    let cases: Vec<_> = files.map(problem).collect();
    assert!(!cases.is_empty());
    cases
}

#[test]
fn solvable_cases_are_solved_cold_and_warm() {
    for (name, problem) in cases("solvable") {
        let cold = ContactSolver::default().solve(&problem, None);
        let warm = ContactSolver::default().solve(&problem, Some(&WarmStart::from_solution(&cold)));
        for solution in [cold, warm] {
            assert_eq!(solution.status, SolveStatus::Solved, "{name}: {:?}", solution.certificate);
            let violation = worst_violation(&problem, &solution);
            assert!(violation <= 1e-8, "{name}: {violation:e}");
        }
    }
}
