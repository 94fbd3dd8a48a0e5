//! Random problems of every family, checked against the formulation in dense matrices.

use std::collections::BTreeMap;

use signorini_contact::{ContactProblem, ContactSolver, SolveStatus};
use signorini_testkit::{Family, Gap, Parameters, Random};

use crate::reference::worst_violation;

fn problem(seed: u64) -> (Family, Parameters, ContactProblem) {
    let mut random = Random::new(20_000 + seed);
    let family = Family::ALL[seed as usize % Family::ALL.len()];
    let parameters = Parameters::random(&mut random);
    let problem = family.small(&mut random, &parameters);
    (family, parameters, problem)
}

fn solvable(family: Family, parameters: &Parameters) -> bool {
    let _ = family;
    matches!(parameters.gap, Gap::Zero | Gap::Positive)
}

#[test]
fn no_solution_is_claimed_falsely_and_none_missed_that_must_exist() {
    let mut solver = ContactSolver::default();
    let mut table: BTreeMap<String, [usize; 5]> = BTreeMap::new();
    let mut failures = Vec::new();
    for seed in 0..640 {
        let (family, parameters, problem) = problem(seed);
        let solution = solver.solve(&problem, None);
        let row = table.entry(format!("{family:?}")).or_default();
        row[0] += 1;
        match &solution.status {
            SolveStatus::Solved => {
                row[1] += 1;
                let violation = worst_violation(&problem, &solution);
                if violation > 1e-8 {
                    failures.push(format!("seed {seed} {family:?}: claims Solved, violates the laws by {violation:e}"));
                }
            }
            SolveStatus::Ray { contacts } | SolveStatus::Infeasible { contacts } => {
                row[2] += 1;
                if contacts.is_empty() {
                    failures.push(format!("seed {seed} {family:?}: {:?} names no contact", solution.status));
                }
            }
            _ => row[3] += 1,
        }
        if solvable(family, &parameters) && solution.status != SolveStatus::Solved {
            row[4] += 1;
            failures.push(format!(
                "seed {seed} {family:?} {parameters:?}: {:?}, residual {:.1e}",
                solution.status,
                solution.certificate.worst()
            ));
        }
        if let (Ok(dir), Some(true)) =
            (std::env::var("SAVE"), failures.last().map(|f| f.starts_with(&format!("seed {seed} "))))
        {
            signorini_contact::problem_file::write_contact(format!("{dir}/family_{family:?}_{seed}.npz"), &problem)
                .unwrap();
        }
    }
    println!("{:12} {:>5} {:>6} {:>10} {:>10} {:>6}", "family", "all", "solved", "ray/infeas", "inaccurate", "missed");
    for (name, [all, solved, rays, other, missed]) in table {
        println!("{name:12} {all:5} {solved:6} {rays:10} {other:10} {missed:6}");
    }
    assert!(failures.is_empty(), "{}\n{}", failures.len(), failures.join("\n"));
}
