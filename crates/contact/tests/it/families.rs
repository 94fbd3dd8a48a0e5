//! Random problems of every family, checked against the formulation in dense matrices.

use std::collections::BTreeMap;

use signorini_contact::{ContactProblem, ContactSolution, ContactSolver, SolveStatus};
use signorini_testkit::{Family, Gap, Parameters, Random};

use crate::reference::{keep, worst_violation};

fn problem(seed: u64) -> (Family, Parameters, ContactProblem) {
    let mut random = Random::new(20_000 + seed);
    let family = Family::ALL[seed as usize % Family::ALL.len()];
    let parameters = Parameters::random(&mut random);
    let problem = family.small(&mut random, &parameters);
    (family, parameters, problem)
}

/// Gaps that are not negative: a solution exists (formulation §4).
fn solvable(parameters: &Parameters) -> bool {
    matches!(parameters.gap, Gap::Zero | Gap::Positive)
}

/// What is wrong with an outcome, if anything.
fn fault(problem: &ContactProblem, parameters: &Parameters, solution: &ContactSolution) -> Option<String> {
    match &solution.status {
        SolveStatus::Solved => {
            let violation = worst_violation(problem, solution);
            (violation > 1e-8).then(|| format!("claims Solved, violates the laws by {violation:e}"))
        }
        status if solvable(parameters) => Some(format!("{status:?}, residual {:.1e}", solution.certificate.worst())),
        SolveStatus::Ray { contacts } | SolveStatus::Infeasible { contacts } if contacts.is_empty() => {
            Some(format!("{:?} names no contact", solution.status))
        }
        _ => None,
    }
}

#[test]
fn no_solution_is_claimed_falsely_and_none_missed_that_must_exist() {
    let mut solver = ContactSolver::default();
    let mut table: BTreeMap<String, [usize; 4]> = BTreeMap::new();
    let mut faults = Vec::new();
    for seed in 0..640 {
        let (family, parameters, problem) = problem(seed);
        let solution = solver.solve(&problem, None);
        let row = table.entry(format!("{family:?}")).or_default();
        row[0] += 1;
        row[match &solution.status {
            SolveStatus::Solved => 1,
            SolveStatus::Ray { .. } | SolveStatus::Infeasible { .. } => 2,
            _ => 3,
        }] += 1;
        if let Some(fault) = fault(&problem, &parameters, &solution) {
            keep(&problem, &format!("family_{family:?}_{seed}"));
            faults.push(format!("seed {seed} {family:?} {parameters:?}: {fault}"));
        }
    }
    println!("{:12} {:>5} {:>6} {:>6} {:>10}", "family", "all", "solved", "denied", "inaccurate");
    for (name, [all, solved, denied, other]) in table {
        println!("{name:12} {all:5} {solved:6} {denied:6} {other:10}");
    }
    assert!(faults.is_empty(), "{}\n{}", faults.len(), faults.join("\n"));
}
