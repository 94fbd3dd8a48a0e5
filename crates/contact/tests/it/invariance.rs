//! What must not change a solution: order and copies of contacts, turned tangents, units, a warm start.

use signorini_contact::{ContactProblem, ContactSolution, ContactSolver, FrictionPolygon, SolveStatus, WarmStart};
use signorini_multibody::BlockDiagonal;
use signorini_testkit::{Family, Gap, Motion, Parameters, Random, families, largest_difference};

type Contact = (Vec<(u32, [f64; 3])>, f64, f64, FrictionPolygon);

fn contacts(problem: &ContactProblem) -> Vec<Contact> {
    (0..problem.contact_count())
        .map(|i| {
            let (columns, entries) = problem.jacobian.group(i);
            let group = columns.iter().copied().zip(entries.iter().copied()).collect();
            let polygon = FrictionPolygon::from_directions(problem.directions_of(i).to_vec()).expect("valid");
            (group, problem.gap[i], problem.friction[i], polygon)
        })
        .collect()
}

fn with_contacts(problem: &ContactProblem, contacts: impl IntoIterator<Item = Contact>) -> ContactProblem {
    let mut out = problem.clone();
    out.clear_contacts();
    for (group, gap, friction, polygon) in contacts {
        out.push_contact(group, gap, friction, &polygon);
    }
    out.check().expect("valid data");
    out
}

/// Problems whose `v⁺` is unique: without friction (redundant contacts allowed), or few independent contacts and little friction.
fn unique(seed: u64) -> ContactProblem {
    let mut random = Random::new(80_000 + seed);
    let gap = random.choice(&[Gap::Zero, Gap::Positive]);
    let drawn = Parameters { gap, mass_ratio: 1.0, ..Parameters::random(&mut random) };
    if seed.is_multiple_of(2) {
        return random.choice(&Family::ALL).small(&mut random, &Parameters { friction: 0.0, ..drawn });
    }
    let friction = random.between(0.0, 0.05);
    let bodies = 1 + random.below(4);
    families::cluster(&mut random, &Parameters { friction, copies: 1, motion: Motion::Impact, ..drawn }, bodies)
}

fn solve(problem: &ContactProblem, name: &str) -> ContactSolution {
    let solution = ContactSolver::default().solve(problem, None);
    assert_eq!(solution.status, SolveStatus::Solved, "{name}: {:e}", solution.certificate.worst());
    solution
}

/// To 1e-9 of the largest velocity in the data.
fn assert_same_velocity(problem: &ContactProblem, a: &ContactSolution, b: &ContactSolution, name: &str) {
    let scale = problem.free_velocity.iter().fold(problem.velocity_scale(), |s, v| s.max(v.abs()));
    let difference = largest_difference(&a.velocity, &b.velocity);
    assert!(difference <= 1e-9 * scale, "{name}: v differs by {difference:e} of {scale:e}");
}

#[test]
fn order_of_contacts() {
    for seed in 0..100 {
        let problem = unique(seed);
        let all = contacts(&problem);
        let order = Random::new(seed).permutation(all.len());
        let shuffled = with_contacts(&problem, order.iter().map(|&k| all[k].clone()));
        let name = format!("seed {seed}");
        assert_same_velocity(&problem, &solve(&problem, &name), &solve(&shuffled, &name), &name);
    }
}

#[test]
fn copies_of_contacts() {
    for seed in 0..100 {
        let problem = unique(seed);
        let doubled = with_contacts(&problem, contacts(&problem).into_iter().flat_map(|c| [c.clone(), c]));
        let name = format!("seed {seed}");
        assert_same_velocity(&problem, &solve(&problem, &name), &solve(&doubled, &name), &name);
    }
}

/// `J_T` turned by θ and the directions by −θ: the same vectors in world.
#[test]
fn turned_tangents() {
    for seed in 0..100 {
        let problem = unique(seed);
        let mut random = Random::new(seed);
        let turned = contacts(&problem).into_iter().map(|(group, gap, friction, polygon)| {
            let (sin, cos) = random.between(0.0, 6.0).sin_cos();
            let turn = |a: f64, b: f64| [cos * a + sin * b, cos * b - sin * a];
            let turn_row = |e: [f64; 3]| [e[0], turn(e[1], e[2])[0], turn(e[1], e[2])[1]];
            let group = group.into_iter().map(|(c, e)| (c, turn_row(e))).collect();
            let directions = polygon.directions().iter().map(|d| turn(d[0], d[1])).collect();
            (group, gap, friction, FrictionPolygon::from_directions(directions).expect("valid"))
        });
        let turned = with_contacts(&problem, turned);
        let name = format!("seed {seed}");
        assert_same_velocity(&problem, &solve(&problem, &name), &solve(&turned, &name), &name);
    }
}

/// Units of mass and of time that are powers of two change no digit; others change rounding only.
#[test]
fn units_of_mass_and_time() {
    for seed in 0..60 {
        let problem = unique(seed);
        let name = format!("seed {seed}");
        let here = solve(&problem, &name);
        for (mass, time) in [(1024.0, 1.0), (1.0, 1.0 / 4096.0), (0.4536, 3600.0), (1e-6, 1e3)] {
            let dense: Vec<f64> = problem.mass.to_dense().iter().map(|m| m * mass).collect();
            let velocity = problem.free_velocity.iter().map(|v| v / time).collect();
            let block = BlockDiagonal::from_dense(problem.nv(), &dense).expect("symmetric");
            let other = ContactProblem::new(block, velocity, problem.timestep * time).expect("valid");
            let other = with_contacts(&other, contacts(&problem));
            let mut there = solve(&other, &name);
            there.velocity.iter_mut().for_each(|v| *v *= time);
            assert_same_velocity(&problem, &here, &there, &format!("{name}, mass {mass}, time {time}"));
        }
    }
}

#[test]
fn a_solution_is_its_own_warm_start() {
    let mut solver = ContactSolver::default();
    let (mut checked, mut factorizations) = (0, [0; 20]);
    for seed in 0..200 {
        let mut random = Random::new(90_000 + seed);
        let gap = random.choice(&[Gap::Zero, Gap::Positive]);
        let parameters = Parameters { gap, ..Parameters::random(&mut random) };
        let problem = Family::ALL[seed as usize % Family::ALL.len()].small(&mut random, &parameters);
        let cold = solver.solve(&problem, None);
        if cold.status != SolveStatus::Solved || cold.report.lemke_islands > 0 {
            continue;
        }
        let mut start = WarmStart::default();
        (0..problem.contact_count()).for_each(|i| start.push(&cold, Some(i)));
        let warm = solver.solve(&problem, Some(&start));
        assert_eq!(warm.status, SolveStatus::Solved, "seed {seed}");
        assert_eq!(warm.report.mode_changes, 0, "seed {seed}: {:?}", warm.report);
        let per_island = warm.report.factorizations.div_ceil(warm.report.islands.max(1) as u32);
        factorizations[per_island as usize] += 1;
        let scale = problem.free_velocity.iter().fold(problem.velocity_scale(), |a, v| a.max(v.abs()));
        let difference = largest_difference(&warm.velocity, &cold.velocity) / scale;
        assert!(difference <= 1e-8, "seed {seed}: v moved by {difference:e}");
        checked += 1;
    }
    println!("factorisations of an island: {factorizations:?}");
    assert!(factorizations[2..].iter().all(|n| *n == 0), "{factorizations:?}");
    assert!(checked >= 195, "only {checked} of 200 checked");
}

/// One solver for many problems gives what a new solver gives, bit for bit.
#[test]
fn a_solver_has_no_memory_of_earlier_problems() {
    let mut used = ContactSolver::default();
    let mut reused = ContactSolution::default();
    for seed in 0..60 {
        let mut random = Random::new(95_000 + seed);
        let parameters = Parameters::random(&mut random);
        let problem = random.choice(&Family::ALL).small(&mut random, &parameters);
        used.solve_into(&problem, None, &mut reused);
        let fresh = ContactSolver::default().solve(&problem, None);
        assert_eq!(reused.velocity, fresh.velocity, "seed {seed}");
        assert_eq!(
            (reused.z(), &reused.modes, &reused.status),
            (fresh.z(), &fresh.modes, &fresh.status),
            "seed {seed}"
        );
    }
}
