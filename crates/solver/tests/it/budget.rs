//! Solves whose sweeps are counted: the best point found comes back with its true certificate, within the bounds of friction, and with the
//! velocity of its impulses.

use signorini_contact::{
    ContactProblem, ContactSolution, FrictionBound, FrictionPolygon, LackingRow, SolveStatus, StageKind, WarmStart,
    certify, residual_spread,
};
use signorini_solver::{ContactSolver, SolverSettings};
use signorini_testkit::{Gap, Motion, Parameters, Random, articulated, families};

const BUDGETS: [u32; 4] = [1, 10, 50, 1000];

fn counted(budget: u32) -> ContactSolver {
    ContactSolver::new(SolverSettings::default().with_budget(budget)).expect("valid")
}

fn cluster(seed: u64, bodies: usize) -> ContactProblem {
    let parameters = Parameters { directions: 8, motion: Motion::Slide, gap: Gap::Zero, ..Parameters::default() };
    families::cluster(&mut Random::new(seed), &parameters, bodies)
}

/// Piles, one with friction groups and one with bilateral rows that tie its bodies together, a stack, and a robot.
fn problems() -> Vec<(&'static str, ContactProblem)> {
    let mut random = Random::new(5);
    let mut grouped = cluster(71, 60);
    let polygon = FrictionPolygon::regular(8, 0.0).expect("even");
    for i in (0..grouped.contact_count()).step_by(5) {
        // Contacts that resist spinning, and bodies that are braked.
        let column = grouped.jacobian.group(i).0[0];
        let bound = if i % 2 == 0 {
            FrictionBound::Normal { contact: i, coefficient: 0.02 }
        } else {
            FrictionBound::Impulse(0.01)
        };
        grouped.push_friction([(column + 3, [1.0, 0.0]), (column + 4, [0.0, 1.0])], [0.0; 2], bound, &polygon);
    }
    let mut tied = cluster(72, 60);
    for k in (0..tied.nv() as u32 - 12).step_by(18) {
        let columns = [(k, [1.0]), (k + 1, [0.3]), (k + 6, [-1.0]), (k + 8, [0.7])];
        tied.push_bilateral(columns, 1e-4 * random.normal());
    }
    let parameters = Parameters { motion: Motion::Rest, gap: Gap::Zero, ..Parameters::default() };
    let stack = families::stack(&mut random, &parameters, 30);
    let robot = articulated(&mut random, &Parameters { friction: 0.4, copies: 1, ..parameters }, 12, 8);
    vec![("pile", cluster(70, 120)), ("groups", grouped), ("tied", tied), ("stack", stack), ("robot", robot)]
}

/// The certificate as code that knows no solver computes it, and the bounds as numbers.
fn is_honest(name: &str, problem: &ContactProblem, solution: &ContactSolution) {
    let checked = certify(problem, solution);
    assert_eq!(checked, solution.certificate, "{name}");
    let is_within = checked.worst() <= 1e-9;
    assert_eq!(solution.status == SolveStatus::Solved, is_within, "{name}: {:?}, {checked:?}", solution.status);
    let to_rounding = if is_within { 1e-9 } else { 1e-12 };
    assert!(checked.momentum <= to_rounding && checked.friction <= to_rounding, "{name}: {checked:?}");
    for i in 0..problem.contact_count() {
        let own = &solution.alpha[problem.direction_offsets[i]..problem.direction_offsets[i + 1]];
        let (sum, bound) = (own.iter().sum::<f64>(), problem.friction[i] * solution.lambda_n[i]);
        assert!(solution.lambda_n[i] >= 0.0 && own.iter().all(|a| *a >= 0.0), "{name}: contact {i}");
        assert!(sum <= bound * (1.0 + 16.0 * f64::EPSILON), "{name}: contact {i} {sum:e} of {bound:e}");
    }
    if solution.status != SolveStatus::Solved {
        assert_eq!(solution.status, SolveStatus::Inaccurate, "{name}");
        let spread = solution.spread.expect("told where nothing is solved");
        assert_eq!(Some(spread), residual_spread(problem, solution), "{name}");
        assert_eq!(spread.worst, checked.natural_map, "{name}");
        assert!(spread.rms <= spread.worst, "{name}: {spread:?}");
    }
}

#[test]
fn what_comes_back_is_certified_by_the_data_alone() {
    for (name, problem) in problems() {
        for budget in BUDGETS {
            let solution = counted(budget).solve(&problem, None);
            is_honest(name, &problem, &solution);
            assert!(solution.report.sweeps <= budget, "{name}: {} sweeps of {budget}", solution.report.sweeps);
            println!(
                "{name}, {budget}: {:?}, {:.1e}, rms {:.1e}",
                solution.status,
                solution.certificate.worst(),
                solution.spread.map_or(0.0, |s| s.rms)
            );
        }
    }
}

/// Sweeps alone: nothing is factorised, and no other way is tried.
#[test]
fn a_large_island_is_left_after_its_sweeps() {
    let solution = counted(10).solve(&cluster(70, 120), None);
    assert_eq!((solution.report.unfinished_islands, solution.report.sweeps), (1, 10));
    assert_eq!(solution.report.factorizations, 0);
    let asked: Vec<StageKind> =
        solution.report.stages.iter().filter(|(_, count)| count.asked > 0).map(|(stage, _)| stage).collect();
    assert_eq!(asked, [StageKind::ContactSweeps]);
}

/// Small islands are solved as without a budget, to the same bits.
#[test]
fn small_islands_do_not_need_the_budget() {
    let parameters = Parameters { motion: Motion::Rest, gap: Gap::Zero, ..Parameters::default() };
    for seed in 0..20 {
        let problem = families::stack(&mut Random::new(seed), &parameters, 6);
        let solution = counted(1).solve(&problem, None);
        assert_eq!(solution.status, SolveStatus::Solved, "seed {seed}");
        let exact = ContactSolver::new(SolverSettings::default()).expect("valid").solve(&problem, None);
        assert_eq!(solution.velocity, exact.velocity, "seed {seed}");
    }
}

#[test]
fn the_same_bits_twice_and_on_two_threads() {
    for (name, problem) in problems() {
        let first = counted(50).solve(&problem, None);
        let settings = SolverSettings::default().with_budget(50).with_threads(2);
        for again in
            [counted(50).solve(&problem, None), ContactSolver::new(settings).expect("valid").solve(&problem, None)]
        {
            assert_eq!(first.velocity, again.velocity, "{name}");
            assert_eq!(first.impulse, again.impulse, "{name}");
        }
    }
}

/// What a solve leaves open the next ones close, each from the impulses of the one before.
#[test]
fn further_solves_close_what_is_open() {
    for (name, problem) in problems() {
        let mut solver = counted(10);
        let mut solution = solver.solve(&problem, None);
        let first = solution.spread.map_or(0.0, |spread| spread.rms);
        for _ in 0..40 {
            solution = solver.solve(&problem, Some(&WarmStart::from_solution(&solution)));
            is_honest(name, &problem, &solution);
        }
        let last = solution.spread.map_or(0.0, |spread| spread.rms);
        println!("{name}: rms {first:.1e}, after 40 more {last:.1e}");
        assert!(last <= 0.1 * first, "{name}: rms {first:.1e}, after 40 more {last:.1e}");
    }
}

/// The row that is said to lack most does: it opens, closes or slips by about as much.
#[test]
fn the_worst_row_is_named() {
    let parameters = Parameters { motion: Motion::Rest, gap: Gap::Zero, ..Parameters::default() };
    let problem = families::stack(&mut Random::new(8), &parameters, 100);
    let solution = counted(3).solve(&problem, None);
    let spread = solution.spread.expect("not solved by 3 sweeps");
    let LackingRow::Contact(worst) = spread.worst_row else { panic!("{spread:?}") };
    let velocity = problem.contact_velocity(worst, &solution.velocity);
    let gap_rate = velocity[0] + problem.gap[worst] / problem.timestep;
    let slip = velocity[1].abs() + velocity[2].abs();
    let own = gap_rate.abs() + slip;
    assert!(own * 4.0 >= spread.worst * problem.velocity_scale(), "contact {worst}: {velocity:?}, {spread:?}");
}
