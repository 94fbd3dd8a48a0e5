//! Warm starts that solve islands already.

use signorini_contact::projection::Mode;
use signorini_contact::{
    ContactProblem, ContactSolution, FrictionBound, FrictionPolygon, SolveStatus, SparseRows, StageKind, WarmStart,
    certify,
};
use signorini_multibody::BlockDiagonal;
use signorini_solver::ContactSolver;
use signorini_testkit::{Family, Gap, Motion, Parameters, Random, articulated, families};

use signorini_testkit::reference::worst_violation;

const DT: f64 = 1e-3;
const WEIGHT: f64 = 9.81 * DT;

/// Point masses on a floor, each with its velocity without contact and its friction.
fn points(given: &[([f64; 3], f64)]) -> ContactProblem {
    let nv = 3 * given.len();
    let mut mass = vec![0.0; nv * nv];
    (0..nv).for_each(|k| mass[k * (nv + 1)] = 1.0 + (k / 3) as f64);
    let velocity = given.iter().flat_map(|(v, _)| *v).collect();
    let mut problem = ContactProblem::new(BlockDiagonal::from_dense(nv, &mass).unwrap(), velocity, DT).unwrap();
    let polygon = FrictionPolygon::regular(8, 0.1).unwrap();
    for (k, (_, friction)) in given.iter().enumerate() {
        let at = 3 * k as u32;
        let columns = [(at, [0.0, 1.0, 0.0]), (at + 1, [0.0, 0.0, 1.0]), (at + 2, [1.0, 0.0, 0.0])];
        problem.push_contact(columns, 0.0, *friction, &polygon);
    }
    problem
}

fn solve_again(problem: &ContactProblem, earlier: &ContactSolution) -> ContactSolution {
    let mut solver = ContactSolver::default();
    let solution = solver.solve(problem, Some(&WarmStart::from_solution(earlier)));
    assert_eq!(solution.certificate, certify(problem, &solution));
    assert!(solution.certificate.holds(1e-12), "{:?}", solution.certificate);
    solution
}

/// One point stands, one slides without friction, one slides against it: nothing is left to solve, what stands has no velocity
/// at all, and what moves goes on.
#[test]
fn nothing_is_solved_twice() {
    let problem = points(&[([0.0, 0.0, -WEIGHT], 0.5), ([1.0, 0.0, -WEIGHT], 0.0), ([0.3, 0.1, -WEIGHT], 0.2)]);
    let cold = ContactSolver::default().solve(&problem, None);
    assert!(cold.report.factorizations >= 3, "{:?}", cold.report);
    let warm = solve_again(&problem, &cold);
    assert_eq!((warm.report.islands, warm.report.factorizations, warm.report.proximal_iterations), (3, 0, 0));
    assert_eq!(warm.velocity[..3], [0.0; 3]);
    assert!(warm.velocity.iter().zip(&cold.velocity).all(|(a, b)| (a - b).abs() < 1e-15));
    assert!((warm.velocity[3] - 1.0).abs() < 1e-15 && (warm.velocity[6] - 0.3).abs() < 3e-3, "{:?}", warm.velocity);
}

/// A point that is pushed is solved for, and nobody else.
#[test]
fn what_is_pushed_is_solved() {
    let mut given = [([0.0, 0.0, -WEIGHT], 0.5), ([1.0, 0.0, -WEIGHT], 0.0), ([0.0, 0.0, -WEIGHT], 0.5)];
    let cold = ContactSolver::default().solve(&points(&given), None);
    given[2].0 = [0.4, -0.1, -2.0 * WEIGHT];
    let problem = points(&given);
    let warm = solve_again(&problem, &cold);
    assert!((1..=2).contains(&warm.report.factorizations), "{:?}", warm.report);
    assert_eq!(warm.impulse[..2], cold.impulse[..2]);
    let expected = ContactSolver::default().solve(&problem, None);
    assert!(warm.velocity.iter().zip(&expected.velocity).all(|(a, b)| (a - b).abs() < 1e-14));
}

/// What a large island at rest lacks of balance below the tolerance stays as it is, at velocity zero, while what is above it is solved.
#[test]
fn a_heap_rests_to_the_tolerance() {
    let parameters = Parameters { motion: Motion::Rest, gap: Gap::Zero, ..Parameters::default() };
    let problem = families::pyramid(&mut Random::new(11), &parameters, 6);
    assert!(problem.contact_count() >= 64);
    let cold = ContactSolver::default().solve(&problem, None);
    assert!(cold.certificate.holds(1e-9));
    let from = |lack: f64| {
        let mut random = Random::new(12);
        let mut start = WarmStart::from_solution(&cold);
        for entry in start.contacts.iter_mut().flatten() {
            entry.0[0] *= 1.0 + random.between(-lack, lack);
        }
        ContactSolver::default().solve(&problem, Some(&start))
    };
    let held = from(2e-12);
    assert_eq!(held.report.factorizations, 0, "{:?}", held.report);
    assert!(held.velocity.iter().all(|v| *v == 0.0));
    assert!(held.certificate.worst() > 1e-13 && held.certificate.holds(1e-9), "{:?}", held.certificate);
    let solved = from(1e-6);
    assert!(solved.report.factorizations > 0 && solved.certificate.holds(1e-9), "{:?}", solved.certificate);
}

/// A velocity of a few nanometres per second is none, to the eye and to a solver with tolerances; here it stays.
#[test]
fn slow_is_not_at_rest() {
    let problem = points(&[([3e-9, 0.0, -WEIGHT], 0.0)]);
    let cold = ContactSolver::default().solve(&problem, None);
    let warm = solve_again(&problem, &cold);
    assert_eq!(warm.report.factorizations, 0);
    assert!((warm.velocity[0] - 3e-9).abs() < 1e-20, "{:e}", warm.velocity[0]);
}

/// The solution of a problem whose bodies are pushed a little, from that without the push: judged by another writing of the laws, with the
/// velocity of a cold solve.
fn pushed(solver: &mut ContactSolver, problem: &mut ContactProblem, random: &mut Random, seed: u64) -> ContactSolution {
    let before = solver.solve(problem, None);
    let size = 10.0_f64.powi(-(seed as i32 % 4));
    problem.free_velocity.iter_mut().for_each(|v| *v += size * random.normal());
    let cold = solver.solve(problem, None);
    let warm = solver.solve(problem, Some(&WarmStart::from_solution(&before)));
    assert_eq!(warm.status, SolveStatus::Solved, "seed {seed}: {:?}", warm.certificate);
    assert_eq!(warm.certificate, certify(problem, &warm));
    let violation = worst_violation(problem, &warm);
    assert!(violation <= 1e-9, "seed {seed}: {violation:e}");
    let scale = problem.free_velocity.iter().fold(problem.velocity_scale(), |a, v| a.max(v.abs()));
    let difference = warm.velocity.iter().zip(&cold.velocity).fold(0.0, |d: f64, (a, b)| d.max((a - b).abs()));
    assert!(difference <= 1e-9 * scale, "seed {seed}: {difference:e}");
    warm
}

/// Robots with fewer rows than degrees of freedom that were pushed a little, sliding, lifted and standing feet among them: one small
/// system for each change of the modes, no proximal iterations, and the velocity of a cold solve.
#[test]
fn robots_are_solved_in_impulses() {
    let mut solver = ContactSolver::default();
    let (mut moved, mut in_impulses, mut alone) = (0, 0, 0);
    for seed in 0..100 {
        let mut random = Random::new(4_000 + seed);
        let parameters = Parameters { friction: 0.4, copies: 1, ..Parameters::random(&mut random) };
        let mut problem = articulated(&mut random, &parameters, 12 + seed as usize % 12, 1 + seed as usize % 4);
        let warm = pushed(&mut solver, &mut problem, &mut random, seed);
        moved += u32::from(warm.report.mode_changes > 0);
        in_impulses += u32::from(warm.report.proximal_iterations == 0 && warm.report.factorizations > 0);
        alone += u32::from(warm.report.factorizations == 1);
    }
    println!("{in_impulses} of 100 in impulses, {moved} with other modes, {alone} with one factorisation");
    assert!(in_impulses >= 80 && moved >= 20 && alone >= 20, "{in_impulses} {moved} {alone}");
}

/// Robots whose joints have dry friction or servos, and whose links are tied together, that were pushed a little: joints stick, slip and turn
/// back, the velocity is that of a cold solve, and another writing of the laws finds nothing wrong.
#[test]
fn dry_friction_and_constraints_are_solved_in_impulses() {
    let mut solver = ContactSolver::default();
    let (mut ended, mut turned) = (0, 0);
    for seed in 0..60 {
        let mut random = Random::new(8_000 + seed);
        let parameters = Parameters { friction: 0.4, copies: 1, ..Parameters::random(&mut random) };
        let n = 12 + seed as usize % 12;
        let mut problem = articulated(&mut random, &parameters, n, 1);
        for k in (6..n as u32).step_by(2) {
            let target = if random.below(4) == 0 { random.normal() } else { 0.0 };
            let bound = FrictionBound::Impulse(10.0_f64.powf(random.between(-4.0, 0.0)));
            problem.push_friction_row([(k, 1.0)], target, bound);
        }
        if random.below(2) == 0 {
            problem.push_friction(
                [(0, [1.0, 0.0]), (1, [0.0, 1.0])],
                [0.0; 2],
                FrictionBound::Impulse(0.01),
                &FrictionPolygon::regular(6, 0.0).unwrap(),
            );
        }
        let tied = 7 + random.below(n - 8) as u32;
        problem.push_bilateral([(6, [1.0]), (tied, [random.normal()])], 0.0);
        let warm = pushed(&mut solver, &mut problem, &mut random, seed);
        let in_impulses = warm.report.stages[StageKind::Impulses].ended > 0;
        ended += u32::from(in_impulses);
        turned += u32::from(in_impulses && warm.report.mode_changes > 0);
    }
    println!("{ended} of 60 in impulses, {turned} with other modes");
    assert!(ended >= 50 && turned >= 10, "{ended} {turned}");
}

/// Contacts that share a load go on sharing it: what is indeterminate among the impulses does not grow from the rounding of many steps.
#[test]
fn redundant_contacts_of_robots_keep_their_shares() {
    let mut solver = ContactSolver::default();
    let (mut checked, mut in_impulses) = (0, 0);
    for seed in 0..12 {
        let mut random = Random::new(7_000 + seed);
        let parameters = Parameters {
            friction: 0.6,
            copies: 2,
            gap: Gap::Zero,
            motion: Motion::Rest,
            ..Parameters::random(&mut random)
        };
        let mut problem = articulated(&mut random, &parameters, 24, 2);
        let first = solver.solve(&problem, None);
        let largest = first.lambda_n.iter().fold(0.0, |a: f64, p| a.max(*p));
        if largest == 0.0 {
            continue;
        }
        let (scale, mut before) = (problem.velocity_scale(), first.clone());
        for _ in 0..50 {
            problem.free_velocity.iter_mut().for_each(|v| *v += 1e-9 * scale * random.normal());
            let next = solver.solve(&problem, Some(&WarmStart::from_solution(&before)));
            assert_eq!(next.status, SolveStatus::Solved, "seed {seed}");
            in_impulses += u32::from(next.report.proximal_iterations == 0 && next.report.factorizations > 0);
            before = next;
        }
        let moved = before.impulse.iter().flatten().zip(first.impulse.iter().flatten());
        let moved = moved.fold(0.0, |a: f64, (p, q)| a.max((p - q).abs()));
        assert!(moved <= 1e-5 * largest, "seed {seed}: impulses of {largest:e} moved by {moved:e}");
        checked += 1;
    }
    println!("{checked} robots, {in_impulses} steps in impulses");
    assert!(checked >= 6 && in_impulses >= 200, "{checked} {in_impulses}");
}

/// A start whose laws hold to 6e-13 of the speed at hand is as exact as what the iterations stop at, 1e-12, and stays; one of
/// 2e-12 does not.
#[test]
fn a_start_as_exact_as_a_solution_stays() {
    let (speed, weight) = (0.3, |error: f64| -WEIGHT - error * 0.3);
    let cold = ContactSolver::default().solve(&points(&[([speed, 0.1, weight(0.0)], 0.2)]), None);
    let kept = solve_again(&points(&[([speed, 0.1, weight(6e-13)], 0.2)]), &cold);
    assert_eq!((kept.report.factorizations, &kept.lambda_n), (0, &cold.lambda_n));
    assert!(kept.certificate.natural_map > 3e-13, "{:?}", kept.certificate);
    let solved = solve_again(&points(&[([speed, 0.1, weight(2e-12)], 0.2)]), &cold);
    assert!(solved.report.factorizations > 0 && solved.certificate.natural_map < 1e-13, "{:?}", solved.certificate);
}

/// A problem and others with one thing changed: nothing, the mass, the rows, friction, directions, the free velocity and the gaps, and
/// the columns.
fn variants(problem: &ContactProblem) -> Vec<ContactProblem> {
    let with = |change: fn(&mut ContactProblem)| {
        let mut other = problem.clone();
        change(&mut other);
        other.check().expect("a valid problem");
        other
    };
    let rows = |problem: &mut ContactProblem, column: fn(u32) -> u32, factor: f64| {
        let mut rows = SparseRows::default();
        for i in 0..problem.contact_count() {
            let (columns, entries) = problem.jacobian.group(i);
            rows.push(columns.iter().zip(entries).map(|(&c, e)| (column(c), e.map(|e| factor * e))));
        }
        problem.jacobian = rows;
    };
    let mut scaled = problem.clone();
    rows(&mut scaled, |c| c, 1.25);
    let mut moved = problem.clone();
    rows(&mut moved, |c| if c == 0 { 1 } else { c }, 1.0);
    let changes = [
        with(|_| ()),
        with(|p| {
            p.mass.add_to_diagonal(p.nv() - 1, 0.5);
            p.mass_factor.refactor(&p.mass).expect("positive definite");
        }),
        scaled,
        with(|p| p.friction.iter_mut().for_each(|mu| *mu *= 0.5)),
        with(|p| p.directions.iter_mut().for_each(|d| *d = [0.6 * d[0] - 0.8 * d[1], 0.8 * d[0] + 0.6 * d[1]])),
        with(|p| p.free_velocity.iter_mut().for_each(|v| *v *= 1.5)),
        with(|p| p.gap.iter_mut().for_each(|gap| *gap = gap.abs() + 1e-4)),
    ];
    // Columns ascend: those that begin with the first two cannot be moved.
    changes.into_iter().chain(Some(moved).filter(|p| p.check().is_ok())).collect()
}

/// What a solver keeps of the problem before (cones, islands, scales of robots) never changes a bit of the next solution.
#[test]
fn the_problem_before_changes_no_bit() {
    let (mut solver, mut solution) = (ContactSolver::default(), ContactSolution::default());
    for seed in 0..24 {
        let mut random = Random::new(5200 + seed);
        let parameters = Parameters::random(&mut random);
        let family = [Family::Articulated, Family::Stack, Family::Articulated, Family::Painleve][seed as usize % 4];
        let problem = family.small(&mut random, &parameters);
        let start = WarmStart::from_solution(&ContactSolver::default().solve(&problem, None));
        for (k, problem) in variants(&problem).iter().flat_map(|other| [&problem, other]).enumerate() {
            for start in [None, Some(&start)] {
                solver.solve_into(problem, start, &mut solution);
                let expected = ContactSolver::default().solve(problem, start);
                let all =
                    |s: &ContactSolution| (s.z(), s.velocity.clone(), s.modes.clone(), s.certificate, s.status.clone());
                assert_eq!(all(&solution), all(&expected), "seed {seed}, variant {k}, warm {}", start.is_some());
            }
        }
    }
}

/// A crank, a rod and a foot in a jam: two rows close the loop and two limits hold it from both sides, so that impulses which balance each other change nothing. Those
/// of a start that are millions of times those that the problem asks for leave last digits in its small velocities; the solution is found without them.
#[test]
fn a_start_of_impulses_that_balance_each_other_does_not_stay() {
    let rows: [[f64; 3]; 2] = [[-0.395, -0.341, 0.0524], [-0.0911, -0.0788, 0.0182]];
    // What the limits of crank and foot push by, for the rows' impulses to leave nothing to the rod.
    let along: [f64; 2] = [0.0788, -0.341];
    let balance = [0, 2].map(|k| rows[0][k] * along[0] + rows[1][k] * along[1]);
    assert!(balance[0] * balance[1] > 0.0, "{balance:?}");
    let sign = balance[0].signum();
    let mut mass = vec![0.0; 9];
    [1.2e-3, 8.8e-3, 1.3e-2].iter().enumerate().for_each(|(k, m)| mass[4 * k] = *m);
    let mut solver = ContactSolver::default();
    for seed in 0..40 {
        let mut random = Random::new(seed);
        let free = [0; 3].map(|_| 1e-5 * random.normal()).to_vec();
        let mut problem = ContactProblem::new(BlockDiagonal::from_dense(3, &mass).unwrap(), free, 5e-4).unwrap();
        let frictionless = FrictionPolygon::regular(4, 0.0).unwrap();
        for k in [0, 2] {
            problem.push_contact([(k, [-1.0, 0.0, 0.0])], 0.0, 0.0, &frictionless);
        }
        rows.iter().for_each(|row| problem.push_bilateral((0..3).zip(row.map(|x| [x])), 0.0));
        let mut start = solver.solve(&problem, None);
        assert_eq!(start.status, SolveStatus::Solved);
        let large = 10f64.powf(random.between(-2.0, 6.0));
        for (i, part) in balance.iter().enumerate() {
            start.impulse[i][0] += large * sign * part;
            start.lambda_n[i] = start.impulse[i][0];
            start.solver_modes[i] = Mode::Closed;
        }
        start.bilateral.iter_mut().zip(along).for_each(|(p, part)| *p += large * sign * part);
        let solution = solver.solve(&problem, Some(&WarmStart::from_solution(&start)));
        assert_eq!(solution.status, SolveStatus::Solved, "{seed}: {large:.1e} {:?}", solution.certificate);
        assert!(solution.certificate.holds(solver.settings().tolerance), "{seed}: {:?}", solution.certificate);
    }
}
