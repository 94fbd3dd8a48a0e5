//! Steps towards rest against the convex relaxation, which finds the same velocities with dense matrices.

use signorini_contact::WarmStart;
use signorini_laws::{ConvexRelaxation, RelaxationStatus, SettlingEffort, SettlingSolver, SettlingStep};
use signorini_testkit::{Family, Gap, Parameters, Random, largest_difference};

use signorini_testkit::reference::random_problem;

/// With the associated law, and a few problems one around the impulses of the other, the velocity is that of the relaxation.
#[test]
fn the_associated_law_is_that_of_the_relaxation() {
    let (mut relaxation, mut solver, mut step) =
        (ConvexRelaxation::default(), SettlingSolver::default(), SettlingStep::default());
    let mut compared = 0;
    for seed in 0..200 {
        let mut random = Random::new(130_000 + seed);
        let problem = if seed % 2 == 0 {
            let (nc, nb) = (1 + random.below(5), random.below(2));
            random_problem(&mut random, nc, nb)
        } else {
            let parameters = Parameters { gap: Gap::Positive, mass_ratio: 1.0, ..Parameters::random(&mut random) };
            random.choice(&[Family::Box, Family::Stack, Family::Wedge]).small(&mut random, &parameters)
        };
        let wanted = relaxation.solve(&problem, 1e-10);
        if wanted.status != RelaxationStatus::Solved {
            continue;
        }
        let (mut earlier, start) = (WarmStart::default(), problem.free_velocity.clone());
        for epsilon in [1e-3, 1e-5, 1e-6, 1e-6, 1e-6, 1e-6] {
            let effort = SettlingEffort { epsilon, newton_steps: 60, associated: true };
            solver.step_into(&problem, &earlier, &start, effort, &mut step).unwrap();
            earlier = WarmStart::from_solution(&step.impulses);
        }
        let scale = wanted.velocity.iter().fold(problem.velocity_scale(), |a, v| a.max(v.abs()));
        let difference = largest_difference(&step.velocity, &wanted.velocity) / scale;
        assert!(difference < 1e-7, "seed {seed}: {difference:e}, slack {:e}", step.slack / scale);
        compared += 1;
    }
    assert!(compared > 150, "only {compared} relaxations were solved");
}

/// A contact that is known has the friction of its last normal impulse, whatever its normal impulse is now.
#[test]
fn friction_is_bounded_by_the_impulses_before() {
    let mass =
        signorini_multibody::BlockDiagonal::from_dense(3, &[2.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 2.0]).unwrap();
    let mut problem = signorini_contact::ContactProblem::new(mass, vec![1.0, 0.0, -3.0], 0.01).unwrap();
    let columns = [(0, [0.0, 1.0, 0.0]), (1, [0.0, 0.0, 1.0]), (2, [1.0, 0.0, 0.0])];
    problem.push_contact(columns, 0.0, 0.5, &signorini_contact::FrictionPolygon::regular(8, 0.0).unwrap());
    let (mut solver, mut step) = (SettlingSolver::default(), SettlingStep::default());
    step.impulses.impulse = vec![[1.0, 0.0, 0.0]];
    let mut earlier = WarmStart::default();
    // 2 kg pressed down with 3 m/s and sliding with 1 m/s: 0.5 N·s of friction, then the 3 N·s that the new bound allows hold it.
    for (expected, held) in [(1.0 - 0.25, false), (0.0, true)] {
        let known = if held { [6.0, -0.5, 0.0] } else { [1.0, 0.0, 0.0] };
        let mut solution = signorini_solver::ContactSolver::default().solve(&problem, None);
        solution.impulse = vec![known];
        earlier.clear();
        earlier.push(&solution, Some(0));
        let effort = SettlingEffort { epsilon: 1e-9, newton_steps: 20, associated: false };
        solver.step_into(&problem, &earlier, &[0.0; 3], effort, &mut step).unwrap();
        assert!((step.velocity[0] - expected).abs() < 1e-7 && step.velocity[2].abs() < 1e-7, "{:?}", step.velocity);
        assert!((step.impulses.impulse[0][0] - 6.0).abs() < 1e-6);
    }
}
