//! Problems of `benchmarks/random_steps` that were hard at some time: those in `tests/data/random_steps/solvable` must be solved; those
//! in `rounded` have solutions with impulses so large that their last digits are velocities above the tolerance. The numbers in a name
//! are the seed and the step.

use std::path::PathBuf;

use signorini_contact::problem_file::{ProblemFile, read};
use signorini_contact::{ContactProblem, SolveStatus, WarmStart};
use signorini_solver::ContactSolver;

use signorini_testkit::reference::worst_violation;

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

#[test]
fn cases_beyond_double_precision_are_solved_to_rounding_and_never_denied() {
    for (name, problem) in cases("rounded") {
        let solution = ContactSolver::default().solve(&problem, None);
        let is_honest = match solution.status {
            SolveStatus::Solved => solution.certificate.holds(1e-9),
            SolveStatus::Inaccurate => !solution.certificate.holds(1e-9),
            _ => false,
        };
        assert!(is_honest, "{name}: {:?}", solution.status);
        let largest = solution.lambda_n.iter().chain(&solution.alpha).fold(0.0, |a: f64, p| a.max(p.abs()));
        let rounding = 4.0 * f64::EPSILON * problem.delassus_scale() * largest / problem.velocity_scale();
        let violation = worst_violation(&problem, &solution);
        assert!(violation <= rounding.max(1e-8), "{name}: {violation:e}, rounding {rounding:e}");
    }
}
