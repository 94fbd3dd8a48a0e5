//! Three routes to one velocity: Lemke on the mixed form, Lemke on the standard form, the structured solver.
//!
//! `v⁺` is unique without friction (a strictly convex quadratic program), and with a small enough coefficient of friction
//! where the rows of `J_N` are independent (the map from normal impulses to friction and back is then a contraction). With
//! redundant contacts it is not, however small μ is: the four corners of a box that slides and spins can share its weight in
//! many ways, and each way brakes the spin differently. Two solutions may differ there, and each must pass the other's test.

use signorini_contact::ContactProblem;
use signorini_lcp::{Lemke, LemkeSettings, solve_mixed};
use signorini_solver::{ContactSolver, solve_as_lcp};
use signorini_testkit::{Family, Gap, Parameters, Random, families, largest_difference};

use signorini_testkit::reference::worst_violation;

/// Lemke with the tightest tolerance that rounding leaves room for.
fn lemke() -> Lemke {
    Lemke::new(LemkeSettings::default().with_tolerance(1e-12)).expect("valid settings")
}

fn velocity_scale(problem: &ContactProblem) -> f64 {
    problem.free_velocity.iter().fold(problem.velocity_scale(), |a, v| a.max(v.abs()))
}

/// The velocities of the three routes, where all three end in a solution.
fn velocities(problem: &ContactProblem, solver: &mut ContactSolver) -> Option<[Vec<f64>; 3]> {
    let mixed = solve_mixed(&problem.mixed_lcp().expect("finite data"), &mut lemke(), None);
    let standard = solve_as_lcp(problem, &mut lemke(), 1e-9).expect("finite data");
    let structured = solver.solve(problem, None);
    let all = mixed.status.is_solved()
        && standard.status == signorini_contact::SolveStatus::Solved
        && structured.status == signorini_contact::SolveStatus::Solved;
    all.then(|| [mixed.z[..problem.nv()].to_vec(), standard.velocity, structured.velocity])
}

fn parameters(random: &mut Random, friction: f64) -> Parameters {
    let drawn = Parameters::random(random);
    let gap = if drawn.gap == Gap::Zero { Gap::Zero } else { Gap::Positive };
    Parameters { friction, gap, mass_ratio: 1.0, ..drawn }
}

fn unique(seed: u64) -> ContactProblem {
    let mut random = Random::new(1000 + seed);
    match seed % 5 {
        0 | 1 => {
            let p = parameters(&mut random, 0.0);
            random.choice(&Family::ALL).small(&mut random, &p)
        }
        2 | 3 => {
            let friction = random.between(0.0, 0.05);
            let p = Parameters { copies: 1, ..parameters(&mut random, friction) };
            let bodies = 2 + random.below(3);
            families::cluster(&mut random, &p, bodies)
        }
        _ => {
            let friction = random.between(0.0, 0.3);
            let p = Parameters { copies: 1, ..parameters(&mut random, friction) };
            families::cluster(&mut random, &p, 1)
        }
    }
}

#[test]
fn three_routes_give_one_velocity_where_it_is_unique() {
    let mut solver = ContactSolver::default();
    let mut worst = [0.0_f64; 2];
    let mut unsolved = Vec::new();
    for seed in 0..1000 {
        let problem = unique(seed);
        let Some([mixed, standard, structured]) = velocities(&problem, &mut solver) else {
            unsolved.push(seed);
            continue;
        };
        let scale = velocity_scale(&problem);
        for (k, other) in [mixed, structured].iter().enumerate() {
            let difference = largest_difference(&standard, other) / scale;
            worst[k] = worst[k].max(difference);
            assert!(difference <= 1e-10, "seed {seed}, route {k}: v differs by {difference:e}");
        }
    }
    println!(
        "largest difference from the standard form: mixed {:.1e}, structured {:.1e}; unsolved {unsolved:?}",
        worst[0], worst[1]
    );
    assert!(unsolved.is_empty(), "unsolved: {unsolved:?}");
}

#[test]
fn where_velocities_may_differ_each_route_passes_the_same_test() {
    let mut solver = ContactSolver::default();
    let (mut solved, mut different) = (0, 0);
    for seed in 0..150 {
        let mut random = Random::new(5000 + seed);
        let friction = random.choice(&[0.5, 1.0, 2.0]);
        let p = parameters(&mut random, friction);
        let problem = random.choice(&Family::ALL).small(&mut random, &p);
        let standard = solve_as_lcp(&problem, &mut lemke(), 1e-9).expect("finite data");
        let structured = solver.solve(&problem, None);
        let mixed = solve_mixed(&problem.mixed_lcp().expect("finite data"), &mut lemke(), None);
        for solution in [&standard, &structured] {
            if solution.status == signorini_contact::SolveStatus::Solved {
                let violation = worst_violation(&problem, solution);
                assert!(violation <= 1e-8, "seed {seed}: claims Solved, violates the laws by {violation:e}");
                solved += 1;
            }
        }
        if mixed.status.is_solved() {
            let residual = problem.standard_lcp().expect("finite data").residual(&mixed.z[problem.nv()..]).value;
            assert!(residual <= 1e-9, "seed {seed}: mixed solution in the standard form: {residual:e}");
            solved += 1;
        }
        let apart = largest_difference(&standard.velocity, &structured.velocity) / velocity_scale(&problem);
        different += usize::from(apart > 1e-8);
    }
    println!("{solved} of 450 solved; in {different} of 150 problems Lemke and the structured solver differ in v");
    assert!(solved >= 445, "only {solved} of 450 solved");
}
