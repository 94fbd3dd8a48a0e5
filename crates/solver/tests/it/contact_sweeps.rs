//! Contact sweeps in turn with exact solutions of parts: certified, the same velocity as by the cascade where it is unique, and no more
//! work than a tolerance asks for.

use std::path::Path;

use signorini_contact::problem_file::{self, ProblemFile};
use signorini_contact::projection::Mode;
use signorini_contact::{
    ContactProblem, ContactSolution, FrictionBound, FrictionPolygon, SolveStatus, StageKind, WarmStart, certify,
};
use signorini_solver::{ContactSolver, SolverSettings};
use signorini_testkit::reference::worst_violation;
use signorini_testkit::{Gap, Motion, Parameters, Random, families, shared_data};

fn solve(settings: &SolverSettings, problem: &ContactProblem) -> ContactSolution {
    ContactSolver::new(settings.clone()).expect("valid").solve(problem, None)
}

/// With the sweeps in every large island, and without.
fn both(tolerance: f64) -> [SolverSettings; 2] {
    [64, usize::MAX].map(|from| SolverSettings::default().for_tolerance(tolerance).with_sweeps_from(from))
}

fn cluster(seed: u64, bodies: usize, parameters: &Parameters) -> ContactProblem {
    families::cluster(&mut Random::new(seed), parameters, bodies)
}

/// Changes all free velocities at random, by at most this share of the largest one.
fn push(problem: &mut ContactProblem, seed: u64, share: f64) {
    let mut random = Random::new(seed);
    let size = share * problem.free_velocity.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
    problem.free_velocity.iter_mut().for_each(|v| *v += random.between(-size, size));
}

fn ended(solution: &ContactSolution) -> u64 {
    solution.report.stages[StageKind::ContactSweeps].ended
}

#[test]
fn clusters_that_move_are_certified() {
    let mut by_sweeps = 0;
    for (seed, friction) in [(1, 0.1), (3, 1.0)] {
        for motion in [Motion::Slide, Motion::Impact] {
            for gap in [Gap::Zero, Gap::Mixed] {
                let parameters = Parameters { friction, directions: 8, motion, gap, ..Parameters::default() };
                let problem = cluster(5900 + seed, 40, &parameters);
                let solution = solve(&both(1e-9)[0], &problem);
                by_sweeps += ended(&solution);
                assert_eq!(solution.status, SolveStatus::Solved, "{friction} {motion:?} {gap:?}");
                let worst = worst_violation(&problem, &solution);
                assert!(worst <= 1e-8, "{friction} {motion:?} {gap:?}: {worst:e}");
            }
        }
    }
    assert!(by_sweeps >= 3, "only {by_sweeps} of 8 were ended by the sweeps");
}

/// Islands of some hundred contacts whose start is far from their modes are swept, and iterations go on from there. Cold ones are not, nor are those of
/// fewer contacts.
#[test]
fn warm_islands_of_some_hundred_contacts_are_swept() {
    let (asked, by_sweeps) = swept_from_afar(60, 128..512);
    println!("asked {asked} times, ended {by_sweeps}");
    assert!(by_sweeps > 0, "the sweeps were asked {asked} times and ended nothing");
    assert_eq!(swept_from_afar(26, 64..128).0, 0);
}

/// The further solves of a time step start from a solution of its problem with fewer contacts: few modes are wrong, and no sweeps are made for them.
#[test]
fn a_start_that_nearly_solves_an_island_is_not_swept() {
    let mut swept = 0;
    for (seed, friction) in [(1, 0.1), (2, 0.5), (3, 1.0)] {
        let parameters =
            Parameters { friction, directions: 8, motion: Motion::Random, gap: Gap::Mixed, ..Parameters::default() };
        let problem = cluster(8900 + seed, 60, &parameters);
        // Of every eighth contact the first solve knows nothing: its gap is far too wide to close.
        let is_left_out = |i: usize| i.is_multiple_of(8);
        let mut fewer = problem.clone();
        (0..fewer.gap.len()).filter(|i| is_left_out(*i)).for_each(|i| fewer.gap[i] = 1e3);
        let earlier = solve(&SolverSettings::default(), &fewer);
        assert_eq!(earlier.status, SolveStatus::Solved, "{friction}");
        let mut start = WarmStart::from_solution(&earlier);
        (0..problem.contact_count()).filter(|i| is_left_out(*i)).for_each(|i| start.contacts[i] = None);
        for nearly_solves in [false, true] {
            start.nearly_solves = nearly_solves;
            let solution = ContactSolver::new(SolverSettings::default()).expect("valid").solve(&problem, Some(&start));
            let asked = solution.report.stages[StageKind::ContactSweeps].asked;
            if nearly_solves {
                assert_eq!(asked, 0, "{friction}");
            }
            swept += asked;
            assert_eq!(solution.status, SolveStatus::Solved, "{friction} {nearly_solves}");
            let worst = worst_violation(&problem, &solution);
            assert!(worst <= 1e-8, "{friction} {nearly_solves}: {worst:e}");
        }
    }
    assert!(swept > 0, "nothing was swept from such a start taken for any other");
}

/// How often clusters with so many contacts were swept from a start that is far from their modes, and how often that was the end.
fn swept_from_afar(bodies: usize, contacts: std::ops::Range<usize>) -> (u64, u64) {
    let (mut asked, mut by_sweeps) = (0, 0);
    for (seed, friction) in [(1, 0.1), (2, 0.5), (3, 1.0)] {
        for motion in [Motion::Slide, Motion::Impact, Motion::Random] {
            let parameters = Parameters { friction, directions: 8, motion, gap: Gap::Mixed, ..Parameters::default() };
            let mut problem = cluster(8900 + seed, bodies, &parameters);
            assert!(contacts.contains(&problem.contact_count()), "{}", problem.contact_count());
            let earlier = solve(&SolverSettings::default(), &problem);
            assert_eq!(earlier.report.stages[StageKind::ContactSweeps].asked, 0, "{friction} {motion:?}: cold");
            push(&mut problem, 9900 + seed, 0.3);
            let mut solver = ContactSolver::new(SolverSettings::default()).expect("valid");
            let solution = solver.solve(&problem, Some(&WarmStart::from_solution(&earlier)));
            asked += solution.report.stages[StageKind::ContactSweeps].asked;
            by_sweeps += ended(&solution);
            assert_eq!(solution.status, SolveStatus::Solved, "{friction} {motion:?}");
            let worst = worst_violation(&problem, &solution);
            assert!(worst <= 1e-8, "{friction} {motion:?}: {worst:e}");
        }
    }
    (asked, by_sweeps)
}

/// A warm cluster whose iterations end at 1e-3 to 1e-4 after the first sweeps: swept from there again it is solved, while one turn leaves it to the stages
/// that follow.
#[test]
fn what_iterations_leave_is_swept_again() {
    let parameters =
        Parameters { friction: 1.0, directions: 4, motion: Motion::Impact, gap: Gap::Mixed, ..Parameters::default() };
    let mut problem = cluster(4913, 75, &parameters);
    let [swept, other] = both(1e-9);
    let earlier = solve(&other, &problem);
    push(&mut problem, 9913, 0.1);
    let solution = ContactSolver::new(swept).expect("valid").solve(&problem, Some(&WarmStart::from_solution(&earlier)));
    assert_eq!((solution.status.clone(), ended(&solution)), (SolveStatus::Solved, 1));
    let worst = worst_violation(&problem, &solution);
    assert!(worst <= 1e-8, "{worst:e}");
}

/// Without friction the problem is a strictly convex quadratic program in the velocity.
#[test]
fn without_friction_the_velocity_is_that_of_the_cascade() {
    for seed in 0..4 {
        let parameters = Parameters { friction: 0.0, motion: Motion::Random, gap: Gap::Mixed, ..Parameters::default() };
        let problem = cluster(6900 + seed, 100, &parameters);
        let [swept, other] = both(1e-9).map(|settings| solve(&settings, &problem));
        assert_eq!([&swept.status, &other.status], [&SolveStatus::Solved; 2], "{seed}");
        let scale = problem.velocity_scale();
        let distance = swept.velocity.iter().zip(&other.velocity).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(distance <= 1e-6 * scale, "{seed}: {distance:e} at a scale of {scale:e}");
    }
}

/// Friction groups with constant bounds and with bounds that contacts give, anisotropic polygons, friction in one direction, and
/// bilateral rows.
#[test]
fn groups_and_bilateral_rows_are_swept_too() {
    let mut by_sweeps = 0;
    for seed in 0..4 {
        let mut random = Random::new(7900 + seed);
        let parameters = Parameters { directions: 6, motion: Motion::Slide, ..Parameters::default() };
        let mut problem = families::cluster(&mut random, &parameters, 60);
        for j in 0..16 {
            let size = random.between(0.01, 0.2);
            let bound = if j % 2 == 0 {
                FrictionBound::Impulse(size)
            } else {
                FrictionBound::Normal { contact: random.below(problem.contact_count()), coefficient: size }
            };
            let polygon = FrictionPolygon::regular(if j % 3 == 0 { 4 } else { 6 }, 0.0).expect("even");
            problem.push_friction([(6 * j + 3, [1.0, 0.0]), (6 * j + 4, [0.0, 1.0])], [0.0; 2], bound, &polygon);
        }
        problem.push_bilateral([(2, [1.0]), (8, [-1.0])], 0.0);
        problem.push_bilateral([(14, [1.0]), (20, [-1.0])], 1e-4);
        let solution = solve(&both(1e-9)[0], &problem);
        by_sweeps += ended(&solution);
        assert_eq!(solution.status, SolveStatus::Solved, "{seed}");
        let worst = worst_violation(&problem, &solution);
        assert!(worst <= 1e-8, "{seed}: {worst:e}");
    }
    assert!(by_sweeps > 0, "the sweeps ended none of them");
}

/// Per contact whether it had an impulse, the impulse, and the code of its mode, as little-endian doubles.
fn recorded_start(path: &Path) -> WarmStart {
    let bytes = std::fs::read(path).expect("a start beside the problem");
    let numbers: Vec<f64> = bytes.as_chunks::<8>().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
    let mut start = WarmStart::default();
    for &[known, n, a, b, code] in numbers.as_chunks::<5>().0 {
        start.contacts.push((known > 0.0).then_some(([n, a, b], Mode::from_code(code as u32).expect("a mode"))));
    }
    start
}

/// Recorded steps of piles of 1000 that fall and strike: at 1e-8 swept until few modes are wrong and no longer, then a few factorisations, and at 1e-3
/// next to nothing.
#[test]
fn recorded_piles_cost_what_their_tolerance_asks_for() {
    let Some(folder) = shared_data("moving_piles") else { return };
    for name in ["s4f1000_0171", "s5_0111"] {
        let Ok(ProblemFile::Contact(problem)) = problem_file::read(folder.join(format!("{name}.npz"))) else {
            panic!("{name} is no contact problem")
        };
        let start = recorded_start(&folder.join(format!("{name}.warm")));
        let [fine, rough] = [1e-8, 1e-3].map(|tolerance| {
            let settings = SolverSettings::default().for_tolerance(tolerance).with_record_history(true);
            let solution = ContactSolver::new(settings).expect("valid").solve(&problem, Some(&start));
            assert_eq!(solution.status, SolveStatus::Solved, "{name} at {tolerance}");
            assert!(certify(&problem, &solution).holds(tolerance), "{name} at {tolerance}");
            solution
        });
        println!("{name}: {:?}, {:?}", fine.report, rough.report);
        assert!(ended(&fine) > 0 && ended(&rough) > 0, "{name}");
        // Sixty sweeps between the first look and the second one, thirty between any two others.
        let run = fine.history.iter().find(|run| run.stage == StageKind::ContactSweeps).expect("swept");
        let far = run.residuals.iter().take_while(|residual| **residual > 1e-4).count();
        assert_eq!(fine.report.sweeps as usize, 30 + 30 * far, "{name}: {:?}", run.residuals);
        assert!(fine.report.factorizations <= 40, "{name}: {}", fine.report.factorizations);
        assert!(rough.report.mode_changes * 4 <= fine.report.mode_changes.max(40), "{name}");
    }
}
