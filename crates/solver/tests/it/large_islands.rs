//! Large islands from a cold start: solved, certified by dense matrices, and with few factorisations, whose number hardly grows
//! with that of the contacts.

use signorini_contact::{ContactProblem, ContactSolution, FrictionBound, FrictionPolygon, SolveStatus};
use signorini_multibody::BlockDiagonal;
use signorini_solver::{ContactSolver, SolverSettings};
use signorini_testkit::{Gap, Motion, Parameters, Random, families};

use signorini_testkit::reference::{keep, worst_violation};

fn solve(problem: &ContactProblem, name: &str) -> ContactSolution {
    let solution = ContactSolver::default().solve(problem, None);
    if solution.status != SolveStatus::Solved {
        keep(problem, name);
    }
    assert_eq!(solution.status, SolveStatus::Solved, "{name}: {}", solution.certificate.worst());
    let report = solution.report;
    println!("{name}: {} contacts, {} factorisations", problem.contact_count(), report.factorizations);
    assert_eq!(report.lemke_islands, 0, "{name}");
    solution
}

#[test]
fn piles_of_free_bodies_are_solved_cold() {
    for (seed, friction) in [(1, 0.1), (2, 0.5), (3, 1.0)] {
        for motion in [Motion::Rest, Motion::Slide, Motion::Impact] {
            let mut random = Random::new(900 + seed);
            let parameters = Parameters { friction, directions: 6, motion, gap: Gap::Zero, ..Parameters::default() };
            let problem = families::cluster(&mut random, &parameters, 40);
            assert!(problem.contact_count() >= 80);
            let solution = solve(&problem, &format!("cluster {friction} {motion:?}"));
            let worst = worst_violation(&problem, &solution);
            assert!(worst <= 1e-8, "{worst:e}");
        }
    }
}

/// A slab that sticks to the floor at many points, and a servo that moves it very slowly and is weaker than their friction. Every proximal iteration adds
/// the little that the speed is short of; what is missing to the servo's limit comes in one stride.
#[test]
fn impulses_that_balance_each_other_grow_in_strides() {
    let mass = BlockDiagonal::from_dense(3, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]).expect("symmetric");
    for speed in [2e-9, -5e-9, 1e-8] {
        let mut problem = ContactProblem::new(mass.clone(), vec![0.0, 0.0, -1.0], 0.01).expect("valid data");
        let polygon = FrictionPolygon::regular(8, 0.1).expect("even");
        for _ in 0..80 {
            problem.push_contact(
                [(0, [0.0, 1.0, 0.0]), (1, [0.0, 0.0, 1.0]), (2, [1.0, 0.0, 0.0])],
                0.0,
                0.5,
                &polygon,
            );
        }
        problem.push_friction_row([(0, 1.0)], speed, FrictionBound::Impulse(0.3));
        let solution = solve(&problem, &format!("slab at {speed}"));
        assert!((solution.group_impulse[0][0] - 0.3_f64.copysign(speed)).abs() < 1e-12, "{:?}", solution.group_impulse);
        // Without strides they are 78 and more.
        assert!(solution.report.proximal_iterations < 30, "{:?}", solution.report);
    }
}

/// Friction in two directions of a body's rotation, with a constant bound or one that a contact gives.
fn push_groups(problem: &mut ContactProblem, random: &mut Random, count: u32) {
    for j in 0..count {
        let size = random.between(0.01, 0.2);
        let bound = if j % 2 == 0 {
            FrictionBound::Impulse(size)
        } else {
            FrictionBound::Normal { contact: random.below(problem.contact_count()), coefficient: size }
        };
        let columns = [(6 * j + 3, [1.0, 0.0]), (6 * j + 4, [0.0, 1.0])];
        problem.push_friction(columns, [0.0; 2], bound, &FrictionPolygon::regular(6, 0.0).expect("even"));
    }
}

#[test]
fn large_islands_may_have_groups_and_bilateral_rows() {
    for seed in 0..4 {
        let mut random = Random::new(1900 + seed);
        let parameters = Parameters { directions: 6, motion: Motion::Slide, ..Parameters::default() };
        let mut problem = families::cluster(&mut random, &parameters, 30);
        push_groups(&mut problem, &mut random, 12);
        // Two bodies keep their heights relative to each other.
        problem.push_bilateral([(2, [1.0]), (8, [-1.0])], 0.0);
        let solution = solve(&problem, &format!("groups {seed}"));
        let worst = worst_violation(&problem, &solution);
        assert!(worst <= 1e-8, "{worst:e}");
    }
}

/// Eight times as many boxes that slide, hit or rest need at most twice the factorisations, and what stands needs a handful.
#[test]
fn factorisations_hardly_grow_with_a_stack() {
    for motion in [Motion::Rest, Motion::Slide, Motion::Impact] {
        let [few, many] = [20, 160].map(|height| {
            let parameters = Parameters { motion, ..Parameters::default() };
            let problem = families::stack(&mut Random::new(31), &parameters, height);
            solve(&problem, &format!("stack {height} {motion:?}")).report.factorizations
        });
        assert!(many <= 2 * few.max(30), "{motion:?}: {few} and {many}");
        assert!(motion != Motion::Rest || few.max(many) <= 6, "{few} and {many}");
    }
}

/// An attempt that its number of iterations cuts off close to the solution is gone on with, which takes a few more factorisations;
/// another start would take three times as many.
#[test]
fn what_ends_close_to_a_solution_goes_on_from_there() {
    let cut_off = SolverSettings::default().with_max_proximal_iterations(2);
    let mut restarts = 0;
    for seed in 0..3 {
        let parameters = Parameters { directions: 8, motion: Motion::Slide, gap: Gap::Zero, ..Parameters::default() };
        let problem = families::cluster(&mut Random::new(2900 + seed), &parameters, 100);
        let whole = solve(&problem, &format!("whole {seed}"));
        let cut = ContactSolver::new(cut_off.clone()).expect("valid").solve(&problem, None);
        assert_eq!(cut.status, SolveStatus::Solved, "{seed}: {}", cut.certificate.worst());
        restarts += cut.report.restarts;
        let [cut, whole] = [&cut, &whole].map(|solution| solution.report.factorizations);
        assert!(2 * cut <= 3 * whole, "{seed}: {cut} and {whole} factorisations");
    }
    assert!(restarts >= 2, "no attempt was cut off");
}
