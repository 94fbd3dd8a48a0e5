//! Every stage of the cascade is reached, and the report says what it did.

use signorini_contact::{
    ContactProblem, ContactSolution, FrictionBound, SolveReport, SolveStatus, StageKind, StageOutcome, WarmStart,
};
use signorini_solver::{ContactSolver, SolverSettings};
use signorini_testkit::reference::worst_violation;
use signorini_testkit::{Gap, Motion, Parameters, Random, articulated, families};

fn solve(settings: &SolverSettings, problem: &ContactProblem, start: Option<&ContactSolution>) -> ContactSolution {
    let warm = start.map(WarmStart::from_solution);
    ContactSolver::new(settings.clone()).expect("valid").solve(problem, warm.as_ref())
}

/// What a stage was asked and how often it ended an island.
fn count(report: &SolveReport, stage: StageKind) -> (u64, u64) {
    let count = report.stages[stage];
    (count.asked, count.ended)
}

fn stack(motion: Motion, height: usize) -> ContactProblem {
    let parameters = Parameters { motion, gap: Gap::Zero, ..Parameters::default() };
    families::stack(&mut Random::new(31), &parameters, height)
}

fn cluster(seed: u64, bodies: usize) -> ContactProblem {
    let parameters = Parameters { directions: 8, motion: Motion::Slide, gap: Gap::Zero, ..Parameters::default() };
    families::cluster(&mut Random::new(seed), &parameters, bodies)
}

#[test]
fn a_small_island_is_swept_solved_and_held() {
    let (settings, problem) = (SolverSettings::default(), stack(Motion::Rest, 4));
    let cold = solve(&settings, &problem, None);
    assert_eq!(count(&cold.report, StageKind::Sweeps).0, 1, "{:?}", cold.report);
    assert_eq!(count(&cold.report, StageKind::Proximal), (1, 1));
    let warm = solve(&settings, &problem, Some(&cold));
    assert_eq!(count(&warm.report, StageKind::Hold), (1, 1));
    assert_eq!(count(&warm.report, StageKind::Proximal), (0, 0));
    let asleep = solve(&settings.with_sleeping(true), &problem, Some(&cold));
    assert_eq!(count(&asleep.report, StageKind::Hold), (1, 1), "{:?}", asleep.report);
    assert_eq!(asleep.report.sleeping_islands, 1);
}

#[test]
fn a_large_island_stands_or_has_an_interior_start() {
    let settings = SolverSettings::default();
    let standing = solve(&settings, &stack(Motion::Rest, 40), None);
    assert_eq!(count(&standing.report, StageKind::Standing).0, 1);
    assert_eq!(count(&standing.report, StageKind::Proximal), (1, 1));
    let sliding = solve(&settings, &cluster(2900, 100), None);
    assert_eq!(sliding.status, SolveStatus::Solved);
    assert_eq!(count(&sliding.report, StageKind::Interior), (1, 1), "{:?}", sliding.report);
}

/// Where iterations are few, the interior start ends no large island, which is looked at again.
#[test]
fn a_second_look_follows_the_interior_start() {
    let settings = SolverSettings::default().with_max_proximal_iterations(1);
    let (mut asked, mut restarts) = (0, 0);
    for seed in 0..4 {
        let solution = solve(&settings, &cluster(2900 + seed, 60), None);
        asked += count(&solution.report, StageKind::Interior).0;
        restarts += solution.report.restarts;
    }
    assert!(asked > 0 && restarts > 0, "asked {asked} times, {restarts} restarts");
}

#[test]
fn robots_are_ended_in_the_space_of_impulses() {
    let mut ended = 0;
    for seed in 0..20 {
        let mut random = Random::new(4_000 + seed);
        let parameters = Parameters { friction: 0.4, copies: 1, ..Parameters::random(&mut random) };
        let mut problem = articulated(&mut random, &parameters, 12, 1);
        let before = solve(&SolverSettings::default(), &problem, None);
        problem.free_velocity.iter_mut().for_each(|v| *v += 0.1 * random.normal());
        ended += count(&solve(&SolverSettings::default(), &problem, Some(&before)).report, StageKind::Impulses).1;
    }
    assert!(ended >= 10, "{ended} of 20");
}

/// Robots of 12 and of 40 degrees of freedom on contacts that resist spinning, too; judged by dense matrices as well.
#[test]
fn friction_that_contacts_bound_is_solved_in_the_space_of_impulses() {
    let mut ended = [0; 2];
    for (ended, joints) in ended.iter_mut().zip([12, 40]) {
        for seed in 0..20 {
            let mut random = Random::new(5_000 + seed);
            let parameters = Parameters { friction: 0.4, copies: 1, ..Parameters::random(&mut random) };
            let mut problem = articulated(&mut random, &parameters, joints, 1);
            for contact in 0..problem.contact_count() {
                let (columns, _) = problem.jacobian.group(contact);
                let row: Vec<_> = columns.iter().map(|&c| (c, random.normal())).collect();
                problem.push_friction_row(row, 0.0, FrictionBound::Normal { contact, coefficient: 0.1 });
            }
            let before = solve(&SolverSettings::default(), &problem, None);
            problem.free_velocity.iter_mut().for_each(|v| *v += 0.1 * random.normal());
            let after = solve(&SolverSettings::default(), &problem, Some(&before));
            let is_solved = after.status == SolveStatus::Solved;
            assert!(!is_solved || worst_violation(&problem, &after) <= 1e-8, "seed {seed}");
            *ended += u64::from(is_solved) * count(&after.report, StageKind::Impulses).1;
        }
    }
    assert!(ended.iter().all(|ended| *ended >= 10), "{ended:?} of 20 each");
}

/// Wedges with negative gaps are for Lemke's method: some it solves, others it denies, and both end the island.
#[test]
fn lemke_ends_what_wedges() {
    let (mut solved, mut denied) = (0, 0);
    for seed in 0..300 {
        let mut random = Random::new(seed);
        let parameters = Parameters { friction: 0.9, gap: Gap::Negative, ..Parameters::random(&mut random) };
        let problem = families::wedge(&mut random, &parameters, 0.6, 3);
        let solution = solve(&SolverSettings::default(), &problem, None);
        let ended = count(&solution.report, StageKind::Lemke).1;
        match solution.status {
            SolveStatus::Solved => solved += ended,
            SolveStatus::Ray { .. } | SolveStatus::Infeasible { .. } => denied += ended,
            _ => {}
        }
    }
    println!("{solved} solved, {denied} denied by Lemke's method");
    assert!(denied > 0, "{solved} solved, {denied} denied");
}

/// The history has every stage that was asked, in order, and the residuals of the proximal iterations; without the setting it is empty,
/// and no clock is read.
#[test]
fn histories_are_there_where_they_are_asked_for() {
    let problem = cluster(2900, 100);
    let plain = solve(&SolverSettings::default(), &problem, None);
    assert!(plain.history.is_empty() && plain.report.stages.iter().all(|(_, count)| count.nanoseconds == 0));
    let settings = SolverSettings::default().with_record_history(true).with_time_stages(true);
    let told = solve(&settings, &problem, None);
    assert_eq!(told.impulse, plain.impulse);
    let stages: Vec<StageKind> = told.history.iter().map(|run| run.stage).collect();
    assert_eq!(stages, [StageKind::Standing, StageKind::Proximal, StageKind::Interior]);
    let last = &told.history[2];
    assert!(matches!(last.outcome, StageOutcome::Solved | StageOutcome::Slow), "{:?}", last.outcome);
    assert!(
        last.residuals.len() as u32 >= told.report.proximal_iterations && last.residuals.iter().any(|r| *r <= 1e-9)
    );
    assert!(told.report.stages[StageKind::Interior].nanoseconds > 0);
}
