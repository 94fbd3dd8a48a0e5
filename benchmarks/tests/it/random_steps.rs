//! The judge and the examiner of random problems, on cases whose answer is known.

use signorini::contact::{ContactProblem, ContactSolver, FrictionPolygon, SolveStatus};
use signorini::lcp::{Enumeration, Method};
use signorini::multibody::BlockDiagonal;
use signorini_benchmarks::random_steps::{
    FAMILIES, Finding, Judge, Limits, MOST_ROWS, Outcome, examine, promised, run, sequence,
};
use signorini_testkit::{Gap, Motion, Parameters, Random, families};

/// A particle of 1 kg between two walls that face each other along x, at these gaps; Δt = 1 s.
fn between_walls(gaps: [f64; 2], friction: f64) -> ContactProblem {
    let mass = BlockDiagonal::from_dense(2, &[1.0, 0.0, 0.0, 1.0]).expect("symmetric");
    let mut problem = ContactProblem::new(mass, vec![-1.0, 0.5], 1.0).expect("valid data");
    let polygon = FrictionPolygon::regular(2, 0.0).expect("even");
    for (normal, gap) in [1.0, -1.0].into_iter().zip(gaps) {
        problem.push_contact([(0, [normal, 0.0, 0.0]), (1, [0.0, 1.0, 0.0])], gap, friction, &polygon);
    }
    problem
}

#[test]
fn the_examiner_tells_what_exists() {
    assert_eq!(examine(&between_walls([-0.1, -0.1], 0.5), 0), Finding::Infeasible);
    let Finding::Solvable(z) = examine(&between_walls([-0.1, 0.3], 0.5), 0) else { panic!("it has a solution") };
    // The particle moves to x = 0.1: λ_N = 1.1, and friction 0.55 more than stops it.
    assert!((z[0] - 1.1).abs() < 1e-12 && z[1].abs() < 1e-12, "{z:?}");
    assert!(promised(&between_walls([0.0, 0.3], 0.5)) && !promised(&between_walls([-0.1, 0.3], 0.5)));
}

/// All complementary bases of tiny problems, one after another: balls that jam in a groove, or do not.
#[test]
fn branching_agrees_with_enumeration() {
    let (mut refuted, mut found) = (0, 0);
    for seed in 0..60 {
        let mut random = Random::new(seed);
        let friction = random.choice(&[0.3, 1.0, 2.0]);
        let parameters = Parameters { friction, gap: Gap::Negative, motion: Motion::Random, ..Parameters::default() };
        let half_angle = random.between(0.15, 1.0);
        let problem = families::wedge(&mut random, &parameters, half_angle, 1);
        let exists =
            Enumeration::default().solve(&problem.standard_lcp().expect("finite data"), None).status.is_solved();
        match examine(&problem, 2000) {
            Finding::Solvable(_) => {
                assert!(exists, "seed {seed}: enumeration has no solution");
                found += 1;
            }
            Finding::Infeasible | Finding::NoSolution => {
                assert!(!exists, "seed {seed}: enumeration has a solution");
                refuted += 1;
            }
            Finding::Open => {}
        }
    }
    println!("{refuted} refuted, {found} found");
    assert!(refuted >= 5 && found >= 20, "{refuted} refuted, {found} found");
}

#[test]
fn the_judge_sees_what_is_wrong() {
    let (mut solver, mut judge, mut judged) = (ContactSolver::default(), Judge::default(), 0);
    for seed in 0..90 {
        let sequence = sequence(seed);
        assert!(sequence.steps.iter().all(|step| step.problem.standard_layout().size <= MOST_ROWS));
        let problem = &sequence.steps[0].problem;
        let solution = solver.solve(problem, None);
        if solution.status != SolveStatus::Solved || problem.velocity_scale() == 0.0 {
            continue;
        }
        let exact = judge.residual(problem, &solution);
        assert!(exact < 1e-8, "seed {seed}: {exact:e}");
        let size = 1e-3 * problem.velocity_scale();
        for i in 0..problem.contact_count() {
            let mut wrong = solution.clone();
            wrong.beta[i] -= 2.0 * size + wrong.beta[i];
            assert!(judge.residual(problem, &wrong) > 1e-4, "seed {seed}: a negative multiplier");
            let mut wrong = solution.clone();
            wrong.lambda_n[i] -= 2.0 * wrong.lambda_n[i] + size / problem.delassus_scale();
            assert!(judge.residual(problem, &wrong) > 1e-4, "seed {seed}: a contact that pulls");
        }
        // What rounding can do grows with the impulses, and is far from what counts as wrong.
        judge.residual(problem, &solution);
        let rounding = judge.rounding();
        assert!(rounding < 1e-5, "seed {seed}: {rounding:e}");
        let mut large = solution.clone();
        let impulses = large.lambda_n.iter_mut().chain(&mut large.alpha).chain(&mut large.group_alpha);
        impulses.for_each(|p| *p *= 1024.0);
        judge.residual(problem, &large);
        assert_eq!(judge.rounding(), 1024.0 * rounding);
        let mut wrong = solution.clone();
        wrong.velocity.pop();
        assert_eq!(judge.residual(problem, &wrong), f64::INFINITY);
        judged += 1;
    }
    assert!(judged >= 60, "{judged}");
}

/// The threads share the work, not the outcome.
#[test]
fn counts_do_not_depend_on_threads() {
    let limits = |threads| Limits { threads, seconds: 600.0, examine_every: 10, programs: 20, examined_rows: 20 };
    let mut counts = Vec::new();
    for threads in [1, 3] {
        let mut failures = Vec::new();
        let tallies = run(0..200, limits(threads), |trial| {
            if trial.outcome.is_failure() {
                failures.push((trial.seed, trial.step, trial.outcome));
            }
        });
        assert_eq!(tallies.len(), FAMILIES.len());
        failures.sort_unstable();
        let outcomes: Vec<_> = tallies.into_iter().map(|tally| (tally.problems, tally.outcomes, tally.worst)).collect();
        assert!(outcomes.iter().all(|o| o.1.contains_key(&Outcome::Solved)));
        counts.push((failures, outcomes));
    }
    assert_eq!(counts[0], counts[1]);
}
