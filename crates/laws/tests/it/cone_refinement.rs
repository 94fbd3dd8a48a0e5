//! Direction refinement against the solver of the nonlinear problem, which shares none of its iterations.

use signorini_contact::{
    ConeStatus, ContactProblem, ContactSolution, FrictionBound, FrictionPolygon, SolveStatus, certify, certify_cone,
};
use signorini_laws::{CircularConeSolver, DirectionRefiner, align_directions};
use signorini_multibody::BlockDiagonal;
use signorini_solver::ContactSolver;
use signorini_testkit::{Family, Gap, Motion, Parameters, Random, families, largest_difference};

use crate::circular_cone::with_polygon;
use crate::cone_solver::solve;
use signorini_testkit::particle;

const COUNTS: [usize; 4] = [4, 8, 16, 64];

/// A slip at 37° to four directions: the refined LCP has a vertex against it and gives Coulomb's friction.
#[test]
fn a_sliding_particle_gets_a_direction_against_its_slip() {
    let mut problem = particle(-0.5, [4.0, 3.0], 0.01, 0.0, 0.4);
    let mut solution = ContactSolution::default();
    let report =
        DirectionRefiner::default().refine(&mut ContactSolver::default(), &mut problem, None, 1e-12, 20, &mut solution);
    assert!(report.converged, "{report:?}");
    problem.check().expect("the refined directions are balanced unit vectors");
    assert!(certify(&problem, &solution).holds(1e-12));
    assert!(largest_difference(&solution.velocity, &[0.0, 4.8 * 0.8, 4.8 * 0.6]) < 1e-12, "{:?}", solution.velocity);
    let off = |d: &[f64; 2]| (d[0] + 0.8).hypot(d[1] + 0.6);
    assert!(problem.directions.iter().map(off).fold(f64::MAX, f64::min) < 1e-11, "{:?}", problem.directions);
}

/// A pad that slides at 37° to the four directions of its friction group, whose bound is a constant, and one in a groove beside it
/// whose two directions are all there are.
#[test]
fn a_sliding_friction_group_gets_a_direction_against_its_slip() {
    let mass = BlockDiagonal::from_dense(3, &[2.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 2.0]).expect("symmetric");
    let mut problem = ContactProblem::new(mass, vec![4.0, 3.0, 1.0], 0.01).expect("valid data");
    let square = FrictionPolygon::regular(4, 0.0).expect("even");
    problem.push_friction([(0, [1.0, 0.0]), (1, [0.0, 1.0])], [0.0; 2], FrictionBound::Impulse(2.0), &square);
    problem.push_friction_row([(2, 1.0)], 0.0, FrictionBound::Impulse(0.5));
    let line = problem.friction_groups.directions_of(1).to_vec();
    let mut solution = ContactSolution::default();
    let report =
        DirectionRefiner::default().refine(&mut ContactSolver::default(), &mut problem, None, 1e-12, 20, &mut solution);
    assert!(report.converged && report.solves > 1, "{report:?}");
    assert!(certify(&problem, &solution).holds(1e-12));
    // 2 N·s on 2 kg against a slip of 5 m/s.
    assert!(largest_difference(&solution.velocity, &[3.2, 2.4, 0.75]) < 1e-12, "{:?}", solution.velocity);
    assert_eq!(problem.friction_groups.directions_of(1), line);
}

/// One body of random shape with one contact point or more in general position: `v⁺` is unique.
#[test]
fn refined_polygons_agree_with_the_nonlinear_problem() {
    let mut sliding = 0;
    for seed in 0..40 {
        let mut random = Random::new(1300 + seed);
        let friction = random.between(0.05, 0.4);
        let motion = random.choice(&[Motion::Impact, Motion::Slide]);
        let parameters = Parameters { friction, gap: Gap::Zero, motion, ..Parameters::default() };
        let problem = families::cluster(&mut random, &parameters, 1);
        let exact = solve(&problem);
        let (mut refined, mut solution) = (problem.clone(), ContactSolution::default());
        let report = DirectionRefiner::default().refine(
            &mut ContactSolver::default(),
            &mut refined,
            None,
            1e-10,
            60,
            &mut solution,
        );
        assert!(report.converged, "seed {seed}: {report:?}");
        assert!(certify(&refined, &solution).holds(1e-9), "seed {seed}");
        refined.check().expect("balanced unit vectors");
        let difference = largest_difference(&solution.velocity, &exact.velocity);
        assert!(difference < 1e-8, "seed {seed}: {difference:e}");
        sliding += usize::from(report.solves > 1);
    }
    assert!(sliding >= 20, "only {sliding} slide");
}

/// All families: the refined LCP is certified by the ordinary certificate, its solution by the circular cone's.
#[test]
fn families_are_refined() {
    let mut solver = CircularConeSolver::default();
    let (mut count, mut converged) = (0, 0);
    for (k, family) in Family::ALL.into_iter().enumerate() {
        for seed in 0..16 {
            let mut random = Random::new(60_000 + 1000 * k as u64 + seed);
            let parameters = Parameters { gap: Gap::Zero, ..Parameters::random(&mut random) };
            let mut problem = family.small(&mut random, &parameters);
            let mut solution = ContactSolution::default();
            let report = solver.refine_into(&mut problem, None, 1e-6, &mut solution);
            count += 1;
            if report.converged {
                converged += 1;
                assert_eq!(solution.status, SolveStatus::Solved);
                assert!(certify(&problem, &solution).holds(1e-9));
                assert!(report.certificate.holds(1e-6));
            }
            problem.check().expect("balanced unit vectors");
        }
    }
    println!("{converged} of {count} refined");
    assert!(100 * converged >= 97 * count, "{converged} of {count}");
}

/// The LCP whose directions are those of the nonlinear problem's friction has its solution.
#[test]
fn aligned_directions_admit_the_solution_of_the_nonlinear_problem() {
    for seed in 0..20 {
        let mut random = Random::new(1700 + seed);
        let parameters = Parameters { friction: 0.3, motion: Motion::Slide, ..Parameters::default() };
        let mut problem = families::cluster(&mut random, &parameters, 3);
        let exact = CircularConeSolver::default().solve(&problem, None);
        assert_eq!(exact.status, ConeStatus::Solved);
        align_directions(&mut problem, &exact);
        problem.check().expect("balanced unit vectors");
        assert!(certify_cone(&problem, &exact).holds(1e-9));
        // α along the vertices that carry the friction, β the sliding speed.
        let mut claimed = ContactSolution::default();
        claimed.velocity.clone_from(&exact.velocity);
        claimed.alpha = vec![0.0; problem.direction_count()];
        for i in 0..problem.contact_count() {
            let [n, t_1, t_2] = exact.impulse[i];
            let [_, c_1, c_2] = problem.contact_velocity(i, &exact.velocity);
            claimed.lambda_n.push(n);
            claimed.beta.push(problem.directions_of(i).iter().map(|d| -(d[0] * c_1 + d[1] * c_2)).fold(0.0, f64::max));
            split(problem.directions_of(i), [t_1, t_2], &mut claimed.alpha[problem.direction_offsets[i]..]);
        }
        let certificate = certify(&problem, &claimed);
        assert!(certificate.holds(1e-9), "seed {seed}: {certificate:?}");
    }
}

/// `D α = t` with the least sum of `α ≥ 0`, over all pairs of directions.
fn split(directions: &[[f64; 2]], t: [f64; 2], alpha: &mut [f64]) {
    let mut best = (f64::INFINITY, 0, 0, [0.0; 2]);
    for (j, a) in directions.iter().enumerate() {
        for (k, b) in directions.iter().enumerate() {
            let determinant = a[0] * b[1] - a[1] * b[0];
            let pair = [(t[0] * b[1] - t[1] * b[0]) / determinant, (a[0] * t[1] - a[1] * t[0]) / determinant];
            if determinant.abs() > 1e-9 && pair[0] > -1e-15 && pair[1] > -1e-15 && pair[0] + pair[1] < best.0 {
                best = (pair[0] + pair[1], j, k, pair);
            }
        }
    }
    let (_, j, k, pair) = best;
    (alpha[j], alpha[k]) = (pair[0].max(0.0), pair[1].max(0.0));
}

/// The distance of the m-gon's velocity from the nonlinear problem's falls with `1/m` over random orientations; the refined
/// polygon is at the cone from four directions on.
#[test]
fn more_directions_come_nearer_and_refined_ones_arrive() {
    let mut random = Random::new(1902);
    let parameters = Parameters { friction: 0.2, gap: Gap::Zero, motion: Motion::Slide, ..Parameters::default() };
    let problem = families::cluster(&mut random, &parameters, 1);
    let exact = solve(&problem).velocity;
    let mean_distance = |count: usize, random: &mut Random| {
        let mut sum = 0.0;
        for _ in 0..40 {
            let polygon = with_polygon(&problem, count, random.between(0.0, std::f64::consts::TAU));
            let solution = ContactSolver::default().solve(&polygon, None);
            sum += largest_difference(&solution.velocity, &exact) / 40.0;
        }
        sum
    };
    let distances = COUNTS.map(|count| mean_distance(count, &mut random));
    println!("{distances:?}");
    let order = (distances[0] / distances[3]).ln() / 16_f64.ln();
    assert!((0.8..1.3).contains(&order), "order {order}: {distances:?}");
    for count in COUNTS {
        let mut refined = with_polygon(&problem, count, 0.3);
        let mut solution = ContactSolution::default();
        let report = CircularConeSolver::default().refine_into(&mut refined, None, 1e-9, &mut solution);
        assert!(report.converged, "m = {count}: {report:?}");
        assert!(largest_difference(&solution.velocity, &exact) < 1e-8, "m = {count}");
    }
}
