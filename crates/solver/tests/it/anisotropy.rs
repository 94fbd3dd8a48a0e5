//! Anisotropic friction: directions of unequal length.

use signorini_contact::{ContactProblem, FrictionPolygon, SolveStatus};
use signorini_lcp::Lemke;
use signorini_solver::{ContactSolver, solve_as_lcp};
use signorini_testkit::{Family, Gap, Parameters, Random, largest_difference};

use signorini_testkit::particle;
use signorini_testkit::reference::worst_violation;

/// A particle of 1 kg on a plane with friction coefficients `axes` along x and y that slides with `(v_x, v_y)`. By maximum
/// dissipation over the ellipse the impulse is `−λ_N A² v / |A v|` with `A = diag(axes)`; on a polygon of 720 corners the
/// implicit step agrees with the fixed point of that law to the polygon's error.
#[test]
fn a_skate_is_turned_into_its_track() {
    let (axes, free) = ([0.05, 0.8], [3.0, 2.0]);
    let polygon = FrictionPolygon::ellipse(720, axes, 0.0).expect("an ellipse");
    let mut problem = particle(-1.0, free, 0.1, 0.0, 1.0);
    let columns = [(0, [1.0, 0.0, 0.0]), (1, [0.0, 1.0, 0.0]), (2, [0.0, 0.0, 1.0])];
    problem.clear_contacts();
    problem.push_contact(columns, 0.0, 1.0, &polygon);
    let solution = ContactSolver::default().solve(&problem, None);
    assert_eq!(solution.status, SolveStatus::Solved, "{:e}", solution.certificate.worst());
    let mut v = free;
    for _ in 0..200 {
        let norm = (axes[0] * v[0]).hypot(axes[1] * v[1]);
        v = [0, 1].map(|k| free[k] - axes[k] * axes[k] * v[k] / norm);
    }
    let difference = (solution.velocity[1] - v[0]).hypot(solution.velocity[2] - v[1]);
    assert!(difference < 1e-3, "{:?} and {v:?}", solution.velocity);
    // Far from parallel to the sliding velocity: the slow direction along the track takes next to nothing.
    assert!(solution.impulse[0][1].abs() < 0.02 && solution.impulse[0][2] < -0.79, "{:?}", solution.impulse[0]);
}

/// Turning the ellipse turns the answer.
#[test]
fn the_axes_of_the_ellipse_turn_with_its_angle() {
    let solve = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        let turned = [3.0 * cos - 2.0 * sin, 3.0 * sin + 2.0 * cos];
        let mut problem = particle(-1.0, turned, 0.1, 0.0, 1.0);
        let polygon = FrictionPolygon::ellipse(12, [0.1, 0.6], angle).expect("an ellipse");
        problem.directions = polygon.directions().to_vec();
        problem.direction_offsets = vec![0, 12];
        problem.check().expect("valid directions");
        let [_, x, y] = ContactSolver::default().solve(&problem, None).velocity[..] else { unreachable!() };
        [cos * x + sin * y, cos * y - sin * x]
    };
    let straight = solve(0.0);
    for angle in [0.3, 1.1, 2.5] {
        assert!(largest_difference(&solve(angle), &straight) < 1e-12);
    }
}

#[test]
fn ellipses_out_of_range_are_refused() {
    for axes in [[0.0, 1.0], [1.0, -1.0], [f64::NAN, 1.0], [f64::INFINITY, 1.0]] {
        let error = FrictionPolygon::ellipse(8, axes, 0.0).expect_err("out of range").to_string();
        assert!(error.contains("semi-axes"), "{error}");
    }
    assert!(FrictionPolygon::ellipse(2, [1.0; 2], 0.0).is_err() && FrictionPolygon::ellipse(7, [1.0; 2], 0.0).is_err());
    let mut problem = particle(-1.0, [1.0, 0.0], 0.1, 0.0, 1.0);
    problem.directions = FrictionPolygon::ellipse(4, [1.0, 0.5], 0.0).expect("an ellipse").directions().to_vec();
    assert!(problem.with_directions(8).expect_err("anisotropic").to_string().contains("contact 0"));
}

fn with_random_ellipses(problem: &ContactProblem, random: &mut Random) -> ContactProblem {
    let mut other = problem.clone();
    other.directions.clear();
    other.direction_offsets = vec![0];
    for i in 0..problem.contact_count() {
        if !problem.directions_of(i).is_empty() {
            let axes = [random.between(0.05, 1.0), random.between(0.05, 1.0)];
            let count = 4 + 2 * random.below(4);
            let polygon = FrictionPolygon::ellipse(count, axes, random.between(0.0, 3.0)).expect("an ellipse");
            other.directions.extend_from_slice(polygon.directions());
        }
        other.direction_offsets.push(other.directions.len());
    }
    other.check().expect("valid directions");
    other
}

/// The structured solver and Lemke's method on the families with an ellipse for every contact: both certified by dense matrices.
#[test]
fn ellipses_are_solved_by_every_route() {
    let mut solver = ContactSolver::default();
    let mut solved = [0; 2];
    for seed in 0..60 {
        let mut random = Random::new(9100 + seed);
        let parameters = Parameters { gap: Gap::Positive, mass_ratio: 1.0, ..Parameters::random(&mut random) };
        let family = random.choice(&[Family::Box, Family::Stack, Family::Cluster, Family::Articulated]);
        let problem = with_random_ellipses(&family.small(&mut random, &parameters), &mut random);
        let structured = solver.solve(&problem, None);
        let lemke = solve_as_lcp(&problem, &mut Lemke::default(), 1e-9).expect("finite data");
        for (k, solution) in [&structured, &lemke].into_iter().enumerate() {
            if solution.status == SolveStatus::Solved {
                solved[k] += 1;
                assert!(worst_violation(&problem, solution) <= 1e-8, "seed {seed}, route {k}");
            }
        }
    }
    assert_eq!(solved[0], 60, "structured; Lemke {}", solved[1]);
}

/// A particle of 1 kg pressed with 1 N·s, μ = 1/2, with friction along one line whose two directions have the length l: it takes up to
/// l/2 of the velocity along the line, and what is across stays.
#[test]
fn directions_of_a_line_have_their_length_as_a_coefficient() {
    for length in [0.4, 1.0, 1.5] {
        for (speed, angle) in [(3.0, 0.0), (3.0, 0.7), (-2.0, 2.5), (0.1, 0.0), (-0.1, 0.7), (0.19, 0.7)] {
            let along = [f64::cos(angle), f64::sin(angle)];
            let across = 0.3;
            let free = [speed * along[0] - across * along[1], speed * along[1] + across * along[0]];
            let mut problem = particle(-1.0, free, 0.1, 0.0, 0.5);
            let directions = [1.0, -1.0].map(|sign| along.map(|x| sign * length * x));
            let line = FrictionPolygon::from_directions(directions.to_vec()).expect("balanced");
            problem.directions = line.directions().to_vec();
            problem.direction_offsets = vec![0, 2];
            problem.check().expect("valid directions");
            let solution = ContactSolver::default().solve(&problem, None);
            assert_eq!(solution.status, SolveStatus::Solved, "{:e}", solution.certificate.worst());
            let left = speed.signum() * (speed.abs() - 0.5 * length).max(0.0);
            let wanted = [0.0, left * along[0] - across * along[1], left * along[1] + across * along[0]];
            let apart = largest_difference(&solution.velocity, &wanted);
            assert!(apart < 1e-9, "length {length}, {speed} m/s: {:?}, expected {wanted:?}", solution.velocity);
            let part = speed.abs().min(0.5 * length) / length;
            assert!((solution.alpha.iter().sum::<f64>() - part).abs() < 1e-9, "{:?}", solution.alpha);
            assert_eq!(solution.report.lemke_islands, 0, "the projection solves it");
        }
    }
}
