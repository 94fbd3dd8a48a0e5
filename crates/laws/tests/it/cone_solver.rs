//! The circular cone's solver against closed forms, an independent fixed point, generated families and Siconos's problems.

use signorini_contact::problem_file::{self, FrictionalProblem, ProblemFile};
use signorini_contact::{ConeSolution, ConeStatus, ConeWarmStart, ContactProblem, FrictionPolygon, certify_cone};
use signorini_laws::{CircularConeSolver, ConeSettings};
use signorini_lcp::Matrix;
use signorini_multibody::BlockDiagonal;
use signorini_multibody::glam::{DMat3, DVec3};
use signorini_solver::ContactSolver;
use signorini_testkit::{
    Family, Gap, Motion, Parameters, Random, RigidBody, Scene, families, files_in, largest_difference, shared_data,
};

use crate::circular_cone::{with_circular_cone, with_polygon};
use signorini_testkit::particle;
use signorini_testkit::reference::keep;

pub const GRAVITY: f64 = 9.81;

pub fn solve(problem: &ContactProblem) -> ConeSolution {
    let solution = CircularConeSolver::default().solve(problem, None);
    assert_eq!(solution.status, ConeStatus::Solved, "{:e}", solution.certificate.worst());
    assert_eq!(solution.certificate, certify_cone(problem, &solution));
    solution
}

/// A body whose centre of mass lies in the plane of its three feet, so that friction does not change their load.
pub fn tripod(velocity: DVec3, spin: f64, friction: f64, polygon: &FrictionPolygon) -> ContactProblem {
    let mut scene = Scene::default();
    let body = RigidBody::cuboid(DVec3::new(1.0, 1.0, 0.1), 3.0, DVec3::ZERO, DMat3::IDENTITY);
    let body = scene.body(body.moving((velocity, DVec3::Z * spin)));
    for k in 0..3 {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / 3.0 + 0.2).sin_cos();
        scene.contact(None, Some(body), DVec3::new(0.4 * cos, 0.4 * sin, 0.0), DVec3::Z, 0.0);
    }
    scene.problem(|_| (friction, polygon.clone()))
}

/// The tolerances of the closed forms are the residual at which Newton's iterations stop, 1e-12, times the speed.
///
/// Whatever the angle between slip and directions: `λ_N` stops the fall, friction `μ λ_N` takes its share of the speed.
#[test]
fn a_particle_slides_straight_at_any_angle() {
    for k in 0..64 {
        let (sin, cos) = (f64::from(k) * 0.1).sin_cos();
        let problem = particle(-0.5, [5.0 * cos, 5.0 * sin], 0.01, 0.0, 0.4);
        let solution = solve(&problem);
        assert!(
            largest_difference(&solution.velocity, &[0.0, 4.8 * cos, 4.8 * sin]) < 5e-12,
            "{:?}",
            solution.velocity
        );
        assert!(largest_difference(&solution.impulse[0], &[0.5, -0.2 * cos, -0.2 * sin]) < 5e-12);
    }
}

#[test]
fn a_particle_inside_the_cone_sticks() {
    // 0.19 is inside the circle of radius 0.2 but outside the square of the four directions at 45° to it.
    let side = 0.19 / 2_f64.sqrt();
    let solution = solve(&particle(-0.5, [side, side], 0.01, 0.0, 0.4));
    assert!(largest_difference(&solution.velocity, &[0.0; 3]) < 1e-12, "{:?}", solution.velocity);
}

/// Four redundant corners: the deceleration of an oblique slide is `μ g`, straight against it.
#[test]
fn a_box_slides_obliquely() {
    let mut scene = Scene::default();
    let velocity = DVec3::new(1.0, 0.37, 0.0);
    let body = RigidBody::cuboid(DVec3::new(1.0, 0.8, 0.3), 20.0, DVec3::Z * 0.15, DMat3::IDENTITY);
    let body = scene.body(body.moving((velocity, DVec3::ZERO)));
    for (x, y) in [(-0.5, -0.4), (0.5, -0.4), (0.5, 0.4), (-0.5, 0.4)] {
        scene.contact(None, Some(body), DVec3::new(x, y, 0.0), DVec3::Z, 0.0);
    }
    let problem = scene.problem(|_| (0.3, FrictionPolygon::regular(4, 0.0).expect("even")));
    let solution = solve(&problem);
    let slowed = velocity - velocity.normalize() * (0.3 * GRAVITY * scene.timestep);
    let wanted = [slowed.x, slowed.y, 0.0, 0.0, 0.0, 0.0];
    assert!(largest_difference(&solution.velocity, &wanted) < 1e-12, "{:?}", solution.velocity);
}

/// Each foot of a spinning tripod brakes across its own arm: `Δω = μ m g Δt r / I`.
#[test]
fn a_tripod_spins_down() {
    let (friction, spin, mass, arm) = (0.2, 3.0, 3.0, 0.4);
    let problem = tripod(DVec3::ZERO, spin, friction, &FrictionPolygon::regular(4, 0.0).expect("even"));
    let solution = solve(&problem);
    let inertia = mass * 2.0 / 12.0;
    let slowed = spin - friction * mass * GRAVITY * 0.01 * arm / inertia;
    assert!(
        largest_difference(&solution.velocity, &[0.0, 0.0, 0.0, 0.0, 0.0, slowed]) < 1e-12,
        "{:?}",
        solution.velocity
    );
}

/// A bead on a horizontal wire along x: the wire's row takes the side velocity, friction acts along the wire alone.
#[test]
fn a_bilateral_row_takes_part() {
    let mut problem = particle(-0.5, [3.0, 4.0], 0.01, 0.0, 0.4);
    problem.push_bilateral([(2, [1.0])], 0.0);
    let solution = solve(&problem);
    assert!(largest_difference(&solution.velocity, &[0.0, 2.8, 0.0]) < 1e-13, "{:?}", solution.velocity);
    assert!((solution.bilateral[0] + 4.0).abs() < 1e-12);
}

/// Two opposite directions are a contact in the plane: friction acts along their line.
#[test]
fn a_contact_in_the_plane_keeps_its_line() {
    let problem = with_polygon(&particle(-0.5, [3.0, 4.0], 0.01, 0.0, 0.4), 2, 0.0);
    let solution = solve(&problem);
    assert!(largest_difference(&solution.velocity, &[0.0, 2.8, 4.0]) < 1e-13, "{:?}", solution.velocity);
}

#[test]
fn solutions_agree_with_the_fixed_point() {
    for seed in 0..24 {
        let mut random = Random::new(900 + seed);
        let friction = random.between(0.05, 0.3);
        let motion = random.choice(&[Motion::Impact, Motion::Slide]);
        let parameters = Parameters { friction, gap: Gap::Zero, motion, ..Parameters::default() };
        let problem = families::cluster(&mut random, &parameters, 1);
        let difference = largest_difference(&solve(&problem).velocity, &with_circular_cone(&problem));
        assert!(difference < 1e-9, "seed {seed}: {difference:e}");
    }
}

/// `s_v = 5`, `g = 1`: every law of the sliding particle violated by a known amount.
#[test]
fn the_certificate_measures_each_law() {
    let problem = particle(-0.5, [3.0, 4.0], 0.01, 0.0, 0.4);
    let exact = solve(&problem);
    let certify = |change: &dyn Fn(&mut ConeSolution)| {
        let mut claimed = exact.clone();
        change(&mut claimed);
        certify_cone(&problem, &claimed)
    };
    let near = |found: f64, wanted: f64| assert!((found - wanted).abs() < 1e-12, "{found:e}, not {wanted:e}");
    near(certify(&|s| s.velocity[1] += 0.05).momentum, 0.01);
    near(certify(&|s| s.velocity[0] -= 0.05).signorini, 0.01);
    near(certify(&|s| s.impulse[0][0] += 0.5).signorini, 0.0);
    near(certify(&|s| (s.impulse[0][1], s.impulse[0][2]) = (-0.6, 0.0)).friction, (0.6 - 0.2) / 5.0);
    // Friction turned by δ: the power of 4.8 m/s misses (1 − cos δ), the natural map sees the turn in first order.
    let (sin, cos) = 1e-3_f64.sin_cos();
    let turned =
        certify(&|s| (s.impulse[0][1], s.impulse[0][2]) = (-0.12 * cos + 0.16 * sin, -0.16 * cos - 0.12 * sin));
    near(turned.dissipation, 0.2 * 4.8 * (1.0 - cos) / 25.0);
    assert!(turned.natural_map > 0.99e-3 * 0.2 / 5.0 && turned.natural_map < 1.1e-3 * 0.2 / 5.0, "{turned:?}");
    assert_eq!(certify(&|s| s.impulse.clear()).worst(), f64::INFINITY);
    assert_eq!(certify(&|s| s.velocity[0] = f64::NAN).worst(), f64::INFINITY);
}

/// The first problems of each family whose gaps are not negative, which have a solution.
#[test]
fn every_family_is_solved() {
    let mut solver = CircularConeSolver::default();
    let mut misses = Vec::new();
    for (k, family) in Family::ALL.into_iter().enumerate() {
        let mut count = 0;
        for seed in 0..40 {
            let mut random = Random::new(50_000 + 1000 * k as u64 + seed);
            let parameters = Parameters::random(&mut random);
            let problem = family.small(&mut random, &parameters);
            if matches!(parameters.gap, Gap::Negative | Gap::Mixed) {
                continue;
            }
            count += 1;
            let solution = solver.solve(&problem, None);
            let worst = certify_cone(&problem, &solution).worst();
            if solution.status != ConeStatus::Solved || worst > 1e-9 {
                keep(&problem, &format!("cone_{family:?}_{seed}"));
                misses.push(format!("{family:?} {seed}: {:?}, {worst:.1e}", solution.status));
            }
        }
        assert!(count >= 12, "only {count} problems of {family:?}");
    }
    assert!(misses.is_empty(), "{}", misses.join("\n"));
}

/// A start at the solution stays there at the cost of no factorisation, one near it takes a few.
#[test]
fn warm_starts_are_used() {
    let mut random = Random::new(77);
    let parameters = Parameters { motion: Motion::Slide, ..Parameters::default() };
    let problem = families::stack(&mut random, &parameters, 3);
    let mut solver = CircularConeSolver::default();
    let cold = solver.solve(&problem, None);
    let mut start = ConeWarmStart::default();
    cold.impulse.iter().for_each(|p| start.push(*p));
    let warm = solver.solve(&problem, Some(&start));
    assert_eq!((warm.status, warm.report.polygon_solves), (ConeStatus::Solved, 0));
    assert!(warm.report.factorizations <= 1, "{:?}", warm.report);
    start.clear();
    cold.impulse.iter().for_each(|p| start.push(p.map(|x| 1.01 * x)));
    let near = solver.solve(&problem, Some(&start));
    assert_eq!((near.status, near.report.polygon_solves), (ConeStatus::Solved, 0));
    start.clear();
    start.push([0.0; 3]);
    assert!(solver.solve(&problem, Some(&start)).report.polygon_solves > 0, "a start of another size is no start");
}

#[test]
fn contradictory_walls_are_denied_and_left_without_impulses() {
    let mut random = Random::new(3);
    let parameters = Parameters { friction: 2.0, gap: Gap::Negative, ..Parameters::default() };
    let problem = families::squeeze(&mut random, &parameters, 2);
    let solution = CircularConeSolver::default().solve(&problem, None);
    assert!(matches!(solution.status, ConeStatus::Denied(_)), "{:?}", solution.status);
    assert!(solution.certificate.worst() <= 1.0 && solution.certificate.worst() > 1e-3);
}

#[test]
fn settings_out_of_range_are_refused() {
    for settings in [
        ConeSettings::default().with_tolerance(0.0),
        ConeSettings::default().with_polish(f64::NAN),
        ConeSettings::default().with_max_newton_iterations(0),
    ] {
        assert!(CircularConeSolver::new(settings, ContactSolver::default()).is_err());
    }
}

/// `W = J M⁻¹ Jᵀ` and `q` of a contact problem: the two solvers find the same velocities.
#[test]
fn impulse_space_agrees_with_velocity_space() {
    let polygon = FrictionPolygon::regular(4, 0.0).expect("even");
    let problem = tripod(DVec3::new(0.5, 0.2, -0.1), 2.0, 0.3, &polygon);
    let n = 3 * problem.contact_count();
    let row = |r: usize| {
        let mut unit = [0.0; 3];
        unit[r % 3] = 1.0;
        let mut x = vec![0.0; problem.nv()];
        problem.jacobian.add_transposed(r / 3, unit, &mut x);
        x
    };
    let delassus = Matrix::from_fn(n, n, |r, c| {
        let mut x = row(c);
        problem.mass_factor.solve_in_place(&mut x);
        row(r).iter().zip(&x).map(|(a, b)| a * b).sum()
    });
    let free_velocity = (0..n).map(|r| problem.contact_velocity(r / 3, &problem.free_velocity)[r % 3]).collect();
    let frictional = FrictionalProblem { delassus, free_velocity, friction: vec![0.3; 3], dimension: 3 };
    let (a, b) = (solve(&problem), CircularConeSolver::default().solve_frictional(&frictional));
    assert_eq!(b.status, ConeStatus::Solved);
    assert!(largest_difference(a.impulse.as_flattened(), b.impulse.as_flattened()) < 1e-10);
}

/// Siconos's problems in circular-cone form of moderate size, some with singular or unsymmetric `W`.
#[test]
fn siconos_problems_are_solved() {
    const MAX_CONTACTS: usize = 110;
    let Some(folder) = shared_data("contact_problems") else { return };
    let mut solver = CircularConeSolver::default();
    let mut count = 0;
    for path in files_in(&folder, "npz") {
        let Ok(ProblemFile::Frictional(problem)) = problem_file::read(&path) else { continue };
        if problem.friction.len() > MAX_CONTACTS {
            continue;
        }
        let solution = solver.solve_frictional(&problem);
        let worst = problem.certify_cone(&solution.impulse).worst();
        assert!(solution.status == ConeStatus::Solved && worst <= 1e-9, "{}: {worst:e}", path.display());
        count += 1;
    }
    assert!(count >= 22, "only {count} problems read");
}

/// Nothing moves and nothing is asked for.
#[test]
fn empty_and_still_problems_are_solved() {
    let mass = BlockDiagonal::from_dense(1, &[2.0]).expect("symmetric");
    let empty = ContactProblem::new(mass, vec![1.5], 0.01).expect("valid data");
    assert_eq!(solve(&empty).velocity, [1.5]);
    assert_eq!(solve(&particle(0.0, [0.0; 2], 0.01, 0.0, 0.4)).velocity, [0.0; 3]);
}
