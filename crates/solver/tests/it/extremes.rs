//! Data at the edges of the range: the solver ends, does not panic, and claims nothing false.

use signorini_contact::{ContactProblem, ContactSolution, FrictionPolygon, SolveStatus, WarmStart};
use signorini_multibody::BlockDiagonal;
use signorini_multibody::glam::{DMat3, DVec3};
use signorini_solver::ContactSolver;
use signorini_testkit::{Family, Gap, Motion, Parameters, Random, RigidBody, Scene, families};

use signorini_testkit::particle;
use signorini_testkit::reference::{keep, worst_violation};

/// Solves cold and once more from the result; nothing false may be claimed either time. Returns the first solution.
fn solve_honestly(problem: &ContactProblem, name: &str) -> ContactSolution {
    let mut solver = ContactSolver::default();
    let cold = solver.solve(problem, None);
    let mut start = WarmStart::default();
    (0..problem.contact_count()).for_each(|i| start.push(&cold, Some(i)));
    start.set_bilateral(&cold.bilateral);
    let warm = solver.solve(problem, Some(&start));
    for (solution, how) in [(&cold, "cold"), (&warm, "warm")] {
        assert_eq!(solution.velocity.len(), problem.nv(), "{name}, {how}");
        if solution.status == SolveStatus::Solved {
            assert!(solution.velocity.iter().chain(&solution.lambda_n).all(|x| x.is_finite()), "{name}, {how}");
            let violation = worst_violation(problem, solution);
            assert!(violation <= 1e-8, "{name}, {how}: claims Solved, violates the laws by {violation:e}");
        }
    }
    cold
}

fn assert_solved(problem: &ContactProblem, name: &str) -> ContactSolution {
    let solution = solve_honestly(problem, name);
    let residual = solution.certificate.worst();
    if solution.status != SolveStatus::Solved {
        keep(problem, name);
    }
    assert_eq!(solution.status, SolveStatus::Solved, "{name}: residual {residual:e}");
    solution
}

fn random_small(seed: u64, change: impl Fn(&mut Parameters, &mut Random)) -> ContactProblem {
    let mut random = Random::new(40_000 + seed);
    let mut parameters = Parameters::random(&mut random);
    parameters.gap = random.choice(&[Gap::Zero, Gap::Positive]);
    change(&mut parameters, &mut random);
    let families = [Family::Box, Family::Stack, Family::Pyramid, Family::Cluster, Family::Articulated];
    random.choice(&families).small(&mut random, &parameters)
}

#[test]
fn coefficients_of_friction_from_nothing_to_rubber() {
    for seed in 0..90 {
        let friction = [0.0, 1e-300, 1e-12, 1e-6, 5.0, 100.0][seed as usize % 6];
        let problem = random_small(seed, |p, _| (p.friction, p.mass_ratio) = (friction, 1.0));
        assert_solved(&problem, &format!("seed {seed}, friction {friction}"));
    }
}

/// Mass ratios beyond what double precision resolves: no solution may be denied that must exist, and most are found.
#[test]
fn masses_from_milligrams_to_kilotons() {
    let (mut unsolved, ratios) = (Vec::new(), [1e-12, 1e-8, 1e-6, 1e6, 1e8, 1e12]);
    for seed in 0..120 {
        let ratio = ratios[seed as usize % ratios.len()];
        let problem = random_small(seed, |p, _| p.mass_ratio = ratio);
        let solution = solve_honestly(&problem, &format!("seed {seed}, mass ratio {ratio:e}"));
        let denied = matches!(solution.status, SolveStatus::Ray { .. } | SolveStatus::Infeasible { .. });
        assert!(!denied, "seed {seed}, mass ratio {ratio:e}: {:?}", solution.status);
        if solution.status != SolveStatus::Solved {
            unsolved.push((seed, ratio, solution.certificate.worst()));
            keep(&problem, &format!("mass_ratio_{ratio:e}_{seed}"));
        }
    }
    println!("unsolved at extreme mass ratios (seed, ratio, residual): {unsolved:?}");
    assert!(unsolved.len() <= 20, "{} of 120: {unsolved:?}", unsolved.len());
}

#[test]
fn all_masses_tiny_or_huge() {
    for factor in [1e-6, 1e-3, 1e3, 1e6] {
        for seed in 0..10 {
            let problem = random_small(seed, |p, _| p.mass_ratio = 1.0);
            let dense: Vec<f64> = problem.mass.to_dense().iter().map(|m| m * factor).collect();
            let mut scaled = problem.clone();
            scaled.mass = BlockDiagonal::from_dense(problem.nv(), &dense).expect("symmetric");
            scaled.mass_factor = scaled.mass.factor().expect("positive definite");
            assert_solved(&scaled, &format!("seed {seed}, masses times {factor}"));
        }
    }
}

#[test]
fn time_steps_from_a_microsecond_to_an_hour() {
    for timestep in [1e-9, 1e-6, 1.0, 3600.0] {
        for seed in 0..15 {
            let mut problem = random_small(seed, |p, _| p.mass_ratio = 1.0);
            problem.timestep = timestep;
            assert_solved(&problem, &format!("seed {seed}, time step {timestep}"));
        }
    }
}

#[test]
fn far_contacts_do_not_matter() {
    for seed in 0..20 {
        let mut problem = random_small(seed, |p, _| (p.mass_ratio, p.motion) = (1.0, Motion::Slide));
        let near = assert_solved(&problem, "near");
        let group: Vec<(u32, [f64; 3])> = {
            let (columns, entries) = problem.jacobian.group(0);
            columns.iter().copied().zip(entries.iter().copied()).collect()
        };
        problem.push_contact(group, 1e6, 0.5, &FrictionPolygon::regular(8, 0.1).expect("even"));
        let far = solve_honestly(&problem, &format!("seed {seed}"));
        assert_eq!(far.lambda_n.last(), Some(&0.0));
        let difference = signorini_testkit::largest_difference(&near.velocity, &far.velocity);
        println!("seed {seed}: {:?}, v differs by {difference:e}", far.status);
    }
}

#[test]
fn nothing_moves_and_nothing_pushes() {
    for seed in 0..30 {
        let mut problem = random_small(seed, |p, _| p.gap = Gap::Zero);
        problem.free_velocity.fill(0.0);
        let solution = assert_solved(&problem, &format!("seed {seed}"));
        assert!(solution.velocity.iter().all(|v| *v == 0.0));
        assert_eq!(solution.certificate.worst(), 0.0);
    }
}

#[test]
fn no_contacts_and_no_degrees_of_freedom() {
    let mass = BlockDiagonal::from_dense(0, &[]).expect("empty");
    let mut empty = ContactProblem::new(mass, Vec::new(), 0.01).expect("valid data");
    assert_solved(&empty, "empty");
    empty.push_contact([], 1e-3, 0.5, &FrictionPolygon::regular(4, 0.0).expect("even"));
    assert_solved(&empty, "a contact and no degree of freedom");
    let mut free = particle(-1.0, [0.5, 0.0], 0.1, 0.0, 0.3);
    free.clear_contacts();
    let solution = assert_solved(&free, "no contacts");
    assert_eq!(solution.velocity, free.free_velocity);
}

#[test]
fn coincident_contacts() {
    for seed in 0..24 {
        let copies = [3, 7, 20][seed as usize % 3];
        let problem = random_small(seed, |p, _| (p.copies, p.mass_ratio) = (copies, 1.0));
        if problem.contact_count() <= 120 {
            assert_solved(&problem, &format!("seed {seed}, {copies} copies"));
        }
    }
}

/// Contacts between two fixed bodies, with no column at all or with columns of zeros, beside a resting particle.
#[test]
fn contacts_that_nothing_can_move() {
    let polygon = FrictionPolygon::regular(4, 0.0).expect("even");
    let columns: [Vec<(u32, [f64; 3])>; 2] = [vec![], vec![(0, [0.0; 3]), (2, [0.0; 3])]];
    for (k, group) in columns.into_iter().enumerate() {
        for gap in [1e-3, 0.0, -1e-3] {
            let mut problem = particle(-1.0, [0.5, 0.0], 0.1, 0.0, 0.3);
            problem.push_contact(group.clone(), gap, 0.5, &polygon);
            let name = format!("kind {k}, gap {gap}");
            let solution = solve_honestly(&problem, &name);
            if gap >= 0.0 {
                assert_eq!(solution.status, SolveStatus::Solved, "{name}");
                assert!((solution.velocity[1] - 0.2).abs() < 1e-12, "{name}: {:?}", solution.velocity);
            } else {
                assert_eq!(solution.status, SolveStatus::Infeasible { contacts: vec![1] }, "{name}");
            }
        }
    }
}

/// The same with a bilateral row that nothing can satisfy.
#[test]
fn bilateral_rows_that_nothing_can_move() {
    for (k, group) in [vec![], vec![(0_u32, [0.0])]].into_iter().enumerate() {
        let mut problem = particle(-1.0, [0.5, 0.0], 0.1, 0.0, 0.3);
        problem.push_bilateral(group.clone(), 0.0);
        assert_solved(&problem, &format!("kind {k}"));
        problem.bilateral_violation[0] = 1e-3;
        let solution = solve_honestly(&problem, &format!("kind {k}, violated"));
        assert!(matches!(solution.status, SolveStatus::Infeasible { .. }), "kind {k}: {:?}", solution.status);
    }
}

/// One box on another, the lower one lighter or heavier. A heavy body on a light one is hard: the rounding
/// of the impulse that carries it moves the light one by `ratio` times the rounding of a velocity.
#[test]
fn light_and_heavy_bodies_in_both_orders() {
    for power in -8..=8 {
        let ratio = 10_f64.powi(power);
        let mut scene = Scene::default();
        for (k, mass) in [1.0 / ratio.sqrt(), ratio.sqrt()].into_iter().enumerate() {
            let center = DVec3::Z * (0.5 + k as f64);
            let body = RigidBody::cuboid(DVec3::ONE, mass, center, DMat3::IDENTITY);
            let body = scene.body(body.moving((DVec3::X * 0.1 * k as f64, DVec3::ZERO)));
            for (x, y) in [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)] {
                scene.contact(body.checked_sub(1), Some(body), DVec3::new(x, y, k as f64), DVec3::Z, 0.0);
            }
        }
        let problem = scene.problem(|_| (0.6, FrictionPolygon::regular(8, 0.0).expect("even")));
        let name = format!("upper to lower mass {ratio:e}");
        if power <= 4 {
            assert_solved(&problem, &name);
        } else {
            let solution = solve_honestly(&problem, &name);
            let denied = matches!(solution.status, SolveStatus::Ray { .. } | SolveStatus::Infeasible { .. });
            assert!(!denied, "{name}: {:?}", solution.status);
            println!("{name}: {:?}, residual {:.1e}", solution.status, solution.certificate.worst());
            keep(&problem, &name);
        }
    }
}

/// A way to spoil the data, with its name.
type Damage = (&'static str, fn(&mut ContactProblem));

/// Data that no check has seen: no panic, no claim.
#[test]
fn unchecked_data_are_not_solved() {
    let damages: [Damage; 6] = [
        ("gap NaN", |p| p.gap[0] = f64::NAN),
        ("gap infinite", |p| p.gap[0] = f64::NEG_INFINITY),
        ("friction NaN", |p| p.friction[0] = f64::NAN),
        ("velocity NaN", |p| p.free_velocity[0] = f64::NAN),
        ("velocity infinite", |p| p.free_velocity[0] = f64::INFINITY),
        ("time step zero", |p| p.timestep = 0.0),
    ];
    for (name, damage) in damages {
        let mut random = Random::new(3);
        let parameters = Parameters { motion: Motion::Impact, gap: Gap::Mixed, ..Parameters::default() };
        let mut problem = families::stack(&mut random, &parameters, 2);
        damage(&mut problem);
        assert!(problem.check().is_err(), "{name}");
        let solution = ContactSolver::default().solve(&problem, None);
        assert_ne!(solution.status, SolveStatus::Solved, "{name}");
    }
}

/// Warm starts that have nothing to do with the problem.
#[test]
fn foreign_warm_starts_do_no_harm() {
    let mut solver = ContactSolver::default();
    for seed in 0..40 {
        let problem = random_small(seed, |p, _| p.mass_ratio = 1.0);
        let other = random_small(seed + 1000, |p, _| p.mass_ratio = 1.0);
        let foreign = solver.solve(&other, None);
        let mut start = WarmStart::default();
        for i in 0..problem.contact_count() {
            start.push(&foreign, if i % 3 == 2 { None } else { Some(i % foreign.lambda_n.len().max(1)) });
        }
        let solution = solver.solve(&problem, Some(&start));
        assert_eq!(solution.status, SolveStatus::Solved, "seed {seed}: {:e}", solution.certificate.worst());
        assert!(worst_violation(&problem, &solution) <= 1e-8, "seed {seed}");
        let mut short = WarmStart::default();
        short.push(&foreign, Some(usize::MAX));
        assert_eq!(solver.solve(&problem, Some(&short)).status, SolveStatus::Solved, "seed {seed}");
    }
}
