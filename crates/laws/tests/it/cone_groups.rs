//! Friction groups with the circular cone: closed forms, the polygon with many directions, and both ways to the solution.

use signorini_contact::{
    ConeStatus, ConeWarmStart, ContactProblem, ContactSolution, FrictionBound, FrictionPolygon, SolveStatus,
    UnsupportedFriction, certify, certify_cone,
};
use signorini_laws::CircularConeSolver;
use signorini_multibody::BlockDiagonal;
use signorini_solver::ContactSolver;
use signorini_testkit::{Random, largest_difference};

use crate::circular_cone::with_polygon;
use crate::cone_solver::solve;
use signorini_testkit::reference::{push_random_groups, random_problem};

/// The same problem with `count` directions for every contact and every group in two directions.
fn with_directions(problem: &ContactProblem, count: usize) -> ContactProblem {
    let mut out = with_polygon(problem, count, 0.3);
    let polygon = FrictionPolygon::regular(count, 0.3).expect("even");
    let groups = &mut out.friction_groups;
    let sizes: Vec<usize> = (0..groups.len()).map(|j| groups.directions_of(j).len()).collect();
    let lines: Vec<_> = (0..groups.len()).map(|j| groups.directions_of(j).to_vec()).collect();
    groups.directions.clear();
    groups.direction_offsets.truncate(1);
    for (size, line) in sizes.iter().zip(lines) {
        groups.directions.extend(if *size > 2 { polygon.directions() } else { &line[..] });
        groups.direction_offsets.push(groups.directions.len());
    }
    out.check().expect("valid data");
    out
}

/// Contacts with little friction and some groups: what has one velocity.
fn random_groups(seed: u64) -> ContactProblem {
    let mut random = Random::new(81_000 + seed);
    let nc = random.below(4);
    let mut problem = random_problem(&mut random, nc, 0);
    problem.friction.iter_mut().for_each(|mu| *mu *= 0.3);
    let nf = 1 + random.below(4);
    push_random_groups(&mut problem, &mut random, nf);
    problem.friction_groups.target.fill([0.0; 2]);
    with_directions(&problem, 8)
}

/// A particle of 1 kg pressed with 0.5 N·s on a belt that moves at any angle: friction 0.2 N·s along the difference.
#[test]
fn a_belt_drags_along_its_own_direction() {
    for k in 0..32 {
        let (sin, cos) = (f64::from(k) * 0.2).sin_cos();
        let mass = BlockDiagonal::from_dense(3, &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]).expect("symmetric");
        let mut problem = ContactProblem::new(mass, vec![-0.5, 0.0, 0.0], 0.01).expect("valid data");
        problem.push_contact([(0, [1.0, 0.0, 0.0])], 0.0, 0.0, &FrictionPolygon::frictionless());
        let bound = FrictionBound::Normal { contact: 0, coefficient: 0.4 };
        let polygon = FrictionPolygon::regular(4, 0.0).expect("even");
        problem.push_friction([(1, [1.0, 0.0]), (2, [0.0, 1.0])], [5.0 * cos, 5.0 * sin], bound, &polygon);
        let solution = solve(&problem);
        assert!(largest_difference(&solution.velocity, &[0.0, 0.2 * cos, 0.2 * sin]) < 5e-12, "{solution:?}");
        assert!(largest_difference(&solution.group_impulse[0], &[0.2 * cos, 0.2 * sin]) < 5e-12);
        // A slow one carries it.
        problem.friction_groups.target[0] = [0.1 * cos, 0.1 * sin];
        let solution = solve(&problem);
        assert!(largest_difference(&solution.velocity, &[0.0, 0.1 * cos, 0.1 * sin]) < 5e-12, "{solution:?}");
    }
}

/// A group in two directions bounded by a contact is Coulomb's friction of that contact.
#[test]
fn a_group_bounded_by_a_contact_is_its_circular_friction() {
    let mut compared = 0;
    for seed in 0..60 {
        let mut random = Random::new(82_000 + seed);
        let with_tangents = with_polygon(&random_problem(&mut random, 1, 0), 8, 0.1);
        let (columns, entries) = with_tangents.jacobian.group(0);
        let normal: Vec<_> = columns.iter().zip(entries).map(|(&c, e)| (c, [e[0], 0.0, 0.0])).collect();
        let tangents: Vec<_> = columns.iter().zip(entries).map(|(&c, e)| (c, [e[1], e[2]])).collect();
        let mut with_group = with_tangents.clone();
        with_group.clear_contacts();
        with_group.push_contact(normal, with_tangents.gap[0], 0.0, &FrictionPolygon::frictionless());
        let bound = FrictionBound::Normal { contact: 0, coefficient: with_tangents.friction[0] };
        with_group.push_friction(tangents, [0.0; 2], bound, &FrictionPolygon::regular(4, 0.0).expect("even"));
        let (a, b) = (solve(&with_tangents), solve(&with_group));
        assert!(largest_difference(&a.velocity, &b.velocity) < 1e-8, "seed {seed}");
        compared += usize::from(a.impulse[0][0] > 0.0);
    }
    assert!(compared >= 20, "{compared}");
}

/// Where friction has one direction everywhere the two laws are one.
#[test]
fn friction_along_lines_is_the_polygons() {
    for seed in 0..60 {
        let mut problem = random_groups(seed);
        let line = FrictionPolygon::from_directions(vec![[0.6, 0.8], [-0.6, -0.8]]).expect("balanced");
        problem.directions = line.directions().repeat(problem.contact_count());
        problem.direction_offsets = (0..=problem.contact_count()).map(|i| 2 * i).collect();
        let count = problem.friction_groups.len();
        problem.friction_groups.directions = line.directions().repeat(count);
        problem.friction_groups.direction_offsets = (0..=count).map(|j| 2 * j).collect();
        let polygon = ContactSolver::default().solve(&problem, None);
        assert_eq!(polygon.status, SolveStatus::Solved, "seed {seed}");
        let circle = solve(&problem);
        assert!(largest_difference(&polygon.velocity, &circle.velocity) < 1e-8, "seed {seed}");
    }
}

/// The polygon's velocity goes to the circle's as its directions become many: the direction of friction is off by `π/m` at most.
#[test]
fn polygons_converge_to_the_circle() {
    let (mut apart, mut worst) = (0, [0.0_f64; 3]);
    for seed in 0..100 {
        let problem = random_groups(seed);
        let circle = solve(&problem);
        let error = |count: usize| {
            let polygon = ContactSolver::default().solve(&with_directions(&problem, count), None);
            assert_eq!(polygon.status, SolveStatus::Solved, "seed {seed}");
            largest_difference(&polygon.velocity, &circle.velocity)
        };
        let (coarse, middle, fine) = (error(8), error(32), error(128));
        apart += usize::from(coarse > 1e-4);
        worst = [worst[0].max(coarse), worst[1].max(middle), worst[2].max(fine)];
    }
    println!("{apart} of 100 differ from 8 directions; largest errors with 8, 32, 128: {worst:?}");
    assert!(apart > 20 && worst[1] < worst[0] / 3.0 && worst[2] < worst[1] / 3.0, "{apart} {worst:?}");
}

/// The warm start leads straight back, directions turned into the slip reach the circle's laws, and with directions aligned to the
/// solution the polygon's certificate judges it.
#[test]
fn the_circle_is_reached_by_lcps_too() {
    for seed in 0..40 {
        let problem = random_groups(seed);
        let circle = solve(&problem);
        let mut warm = ConeWarmStart::default();
        circle.impulse.iter().for_each(|p| warm.push(*p));
        circle.group_impulse.iter().for_each(|p| warm.push_group(*p));
        let again = CircularConeSolver::default().solve(&problem, Some(&warm));
        assert_eq!((again.status, again.report.polygon_solves), (ConeStatus::Solved, 0), "seed {seed}");

        let mut solver = CircularConeSolver::default();
        let (mut refined, mut solution) = (problem.clone(), ContactSolution::default());
        let report = solver.refine_into(&mut refined, None, 1e-6, &mut solution);
        assert!(report.converged, "seed {seed}: {report:?}");
        assert!(certify(&refined, &solution).holds(1e-9), "seed {seed}");
        assert!(largest_difference(&solution.velocity, &circle.velocity) < 1e-4, "seed {seed}");

        let (mut aligned, mut expressed) = (problem.clone(), ContactSolution::default());
        solver.express_into(&mut aligned, &circle, &mut expressed);
        assert!(certify(&aligned, &expressed).holds(1e-8), "seed {seed}: {:?}", certify(&aligned, &expressed));
    }
}

/// Each law of a group has its residual: v_free = (3, 4), target 0, mass 1, bound 1 gives v⁺ = (2.4, 3.2); s_v = 5, g = 1.
#[test]
fn each_law_of_a_group_is_certified() {
    let mass = BlockDiagonal::from_dense(2, &[1.0, 0.0, 0.0, 1.0]).expect("symmetric");
    let mut problem = ContactProblem::new(mass, vec![3.0, 4.0], 0.1).expect("valid data");
    let polygon = FrictionPolygon::regular(4, 0.0).expect("even");
    problem.push_friction([(0, [1.0, 0.0]), (1, [0.0, 1.0])], [0.0; 2], FrictionBound::Impulse(1.0), &polygon);
    let exact = solve(&problem);
    assert!(largest_difference(&exact.velocity, &[2.4, 3.2]) < 1e-11, "{exact:?}");
    let d = 1e-3;
    let shifted = |f: [f64; 2]| {
        let mut claimed = exact.clone();
        claimed.group_impulse[0] = [exact.group_impulse[0][0] + f[0], exact.group_impulse[0][1] + f[1]];
        claimed.velocity = vec![exact.velocity[0] + f[0], exact.velocity[1] + f[1]];
        certify_cone(&problem, &claimed)
    };
    let beyond = shifted([-0.6 * d, -0.8 * d]);
    assert!((beyond.friction - d / 5.0).abs() < 1e-11 && beyond.momentum < 1e-11, "{beyond:?}");
    let lazy = shifted([0.6 * d, 0.8 * d]);
    assert!((lazy.dissipation - d * (4.0 + d) / 25.0).abs() < 1e-11 && lazy.friction < 1e-11, "{lazy:?}");
    let turned = shifted([0.8 * d, -0.6 * d]);
    assert!(turned.natural_map > 0.9 * d / 5.0 && turned.dissipation < 1e-6, "{turned:?}");
    let mut missing = exact;
    missing.group_impulse.clear();
    assert_eq!(certify_cone(&problem, &missing).worst(), f64::INFINITY);
}

#[test]
fn an_anisotropic_group_is_refused() {
    let mut problem = random_groups(1);
    let polygon = FrictionPolygon::ellipse(8, [1.0, 0.5], 0.0).expect("positive");
    let group = problem.friction_groups.len();
    problem.push_friction([(0, [1.0, 0.5])], [0.0; 2], FrictionBound::Impulse(1.0), &polygon);
    let solution = CircularConeSolver::default().solve(&problem, None);
    assert_eq!(solution.status, ConeStatus::Unsupported(UnsupportedFriction::AnisotropicGroup { group }));
}

/// Contacts with all sorts of friction, rows, and groups that pull: whatever the polygon solves the circle solves, too.
#[test]
fn the_circle_has_a_solution_where_the_polygon_has_one() {
    let mut solved = 0;
    for seed in 0..1000 {
        let mut random = Random::new(900_000 + seed);
        let (nc, nb) = (random.below(5), random.below(2));
        let mut problem = random_problem(&mut random, nc, nb);
        let nf = 1 + random.below(5);
        push_random_groups(&mut problem, &mut random, nf);
        let problem = with_directions(&problem, 8);
        if ContactSolver::default().solve(&problem, None).status == SolveStatus::Solved {
            let circle = CircularConeSolver::default().solve(&problem, None);
            assert_eq!(circle.status, ConeStatus::Solved, "seed {seed}: {:e}", circle.certificate.worst());
            solved += 1;
        }
    }
    assert!(solved > 950, "{solved}");
}
