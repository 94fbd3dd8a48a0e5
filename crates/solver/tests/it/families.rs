//! Random problems of every family, checked against the formulation in dense matrices.

use std::collections::BTreeMap;

use signorini_contact::{ContactProblem, ContactSolution, SolveStatus};
use signorini_lcp::{Enumeration, Method};
use signorini_solver::ContactSolver;
use signorini_testkit::{Family, Gap, Motion, Parameters, Random, families, suite};

use signorini_testkit::reference::{keep, random_problem, worst_violation};

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

/// A problem of at most two contacts with four directions, its gaps negative.
fn tiny(seed: u64) -> ContactProblem {
    let mut random = Random::new(30_000 + seed);
    let problem = match seed % 3 {
        0 => {
            let friction = random.choice(&[0.1, 0.5, 1.0, 2.0]);
            let motion = random.choice(&[Motion::Rest, Motion::Impact, Motion::Random]);
            let parameters = Parameters { friction, gap: Gap::Negative, motion, ..Parameters::default() };
            let half_angle = random.between(0.15, 1.0);
            families::wedge(&mut random, &parameters, half_angle, 1)
        }
        _ => {
            let nc = 1 + random.below(2);
            let mut problem = random_problem(&mut random, nc, 0);
            problem.gap.iter_mut().for_each(|gap| *gap = -*gap);
            problem
        }
    };
    problem.with_directions(4).expect("an even number")
}

/// All complementary bases of tiny problems, one after another: where there is no solution none is claimed, and what is called
/// infeasible is.
#[test]
fn outcomes_agree_with_enumeration() {
    let mut solver = ContactSolver::default();
    let mut counts = [0; 4];
    for seed in 0..300 {
        let problem = tiny(seed);
        let exists =
            Enumeration::default().solve(&problem.standard_lcp().expect("finite data"), None).status.is_solved();
        let solution = solver.solve(&problem, None);
        match (&solution.status, exists) {
            (SolveStatus::Solved, true) => counts[0] += 1,
            (SolveStatus::Infeasible { .. } | SolveStatus::Ray { .. }, false) => counts[1] += 1,
            (SolveStatus::Ray { .. }, true) => counts[2] += 1,
            (SolveStatus::Solved | SolveStatus::Infeasible { .. }, _) => {
                keep(&problem, &format!("enumeration_{seed}"));
                panic!("seed {seed}: {:?}, but enumeration says solvable: {exists}", solution.status)
            }
            _ => counts[3] += 1,
        }
    }
    let [solved, denied, ray, other] = counts;
    println!("{solved} solved, {denied} rightly denied, {ray} ended on a ray though solvable, {other} other");
    assert!(solved >= 150 && denied >= 20, "the problems are not what they should be: {counts:?}");
    assert!(ray + other == 0, "{counts:?}");
}

/// Boxes squeezed between walls that demand more room than there is: the iterations' own impulses are the proof.
#[test]
fn squeezes_are_denied_without_lemke() {
    let list = suite::entries();
    let mut denied = 0;
    for seed in 0..4 * list.len() {
        let entry = list[seed % list.len()];
        if entry.group == "squeeze" {
            let solution = ContactSolver::default().solve(&entry.problem(seed as u32), None);
            assert!(matches!(solution.status, SolveStatus::Infeasible { .. }), "seed {seed}: {:?}", solution.status);
            assert_eq!(solution.report.lemke_islands, 0, "seed {seed}: {:?}", solution.report);
            denied += 1;
        }
    }
    assert!(denied >= 20, "only {denied} squeezes");
}
