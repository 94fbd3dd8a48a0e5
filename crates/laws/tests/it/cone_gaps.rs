//! The gaps between polygon and cone against their bounds and against the solution with the cone.

use signorini_contact::{ConeGap, ContactProblem, FrictionPolygon, cone_gaps, velocity_error_bound};
use signorini_multibody::glam::DVec3;
use signorini_solver::ContactSolver;
use signorini_testkit::{Family, Gap, Parameters, Random};

use crate::circular_cone::with_polygon;
use crate::cone_solver::{solve, tripod};
use signorini_contact::{ConeStatus, SolveStatus};
use signorini_laws::CircularConeSolver;
use signorini_testkit::particle;

/// `‖x − y‖_M`, √J.
fn energy_distance(problem: &ContactProblem, x: &[f64], y: &[f64]) -> f64 {
    let difference: Vec<f64> = x.iter().zip(y).map(|(x, y)| x - y).collect();
    let mut momentum = vec![0.0; difference.len()];
    problem.mass.multiply_into(&difference, &mut momentum);
    difference.iter().zip(&momentum).map(|(d, p)| d * p).sum::<f64>().sqrt()
}

/// A slip of almost 5 m/s at 20° to the nearest of four directions, `μ λ_N = 0.2`: friction stays at the vertex.
#[test]
fn a_particle_has_the_gap_of_its_angle() {
    let (sin, cos) = 20_f64.to_radians().sin_cos();
    let problem = particle(-0.5, [5.0 * cos, 5.0 * sin], 0.01, 0.0, 0.4);
    let solution = ContactSolver::default().solve(&problem, None);
    let (x, y) = (5.0 * cos - 0.2, 5.0 * sin);
    let (slip, angle) = (x.hypot(y), y.atan2(x));
    let [gap] = cone_gaps(&problem, &solution)[..] else { panic!("one contact") };
    let eta = std::f64::consts::FRAC_PI_4;
    let wanted = ConeGap {
        angle,
        angle_bound: eta,
        missing_dissipation: 0.2 * slip * (1.0 - angle.cos()),
        missing_dissipation_bound: 0.2 * slip * (1.0 - eta.cos()),
        missing_impulse: 0.4 * (0.5 * angle).sin(),
        missing_impulse_bound: 0.4 * (0.5 * eta).sin(),
    };
    for (found, wanted) in [
        (gap.angle, wanted.angle),
        (gap.angle_bound, wanted.angle_bound),
        (gap.missing_dissipation, wanted.missing_dissipation),
        (gap.missing_dissipation_bound, wanted.missing_dissipation_bound),
        (gap.missing_impulse, wanted.missing_impulse),
        (gap.missing_impulse_bound, wanted.missing_impulse_bound),
    ] {
        assert!((found - wanted).abs() < 1e-12, "{found}, not {wanted}: {gap:?}");
    }
}

#[test]
fn open_sticking_and_frictionless_contacts_have_no_gap() {
    for problem in [
        particle(0.5, [3.0, 4.0], 0.01, 0.0, 0.4),
        particle(-0.5, [0.1, 0.0], 0.01, 0.0, 0.4),
        particle(-0.5, [3.0, 4.0], 0.01, 0.0, 0.0),
        with_polygon(&particle(-0.5, [3.0, 4.0], 0.01, 0.0, 0.4), 2, 0.3),
    ] {
        let solution = ContactSolver::default().solve(&problem, None);
        let [gap] = cone_gaps(&problem, &solution)[..] else { panic!("one contact") };
        assert!(gap.missing_dissipation < 1e-15 && gap.missing_impulse < 0.1, "{gap:?}");
        assert!(gap.missing_impulse <= gap.missing_impulse_bound + 1e-15, "{gap:?}");
    }
}

/// Every contact's gap is within its bound, and the distance between the two solutions within the inequality from which
/// [`velocity_error_bound`] follows, normal impulses included.
#[test]
fn gaps_are_within_their_bounds() {
    let mut compared = 0;
    for (k, family) in Family::ALL.into_iter().enumerate() {
        for seed in 0..20 {
            let mut random = Random::new(80_000 + 1000 * k as u64 + seed);
            let parameters = Parameters { gap: Gap::Zero, ..Parameters::random(&mut random) };
            let problem = family.small(&mut random, &parameters);
            let polygon = ContactSolver::default().solve(&problem, None);
            let cone = CircularConeSolver::default().solve(&problem, None);
            assert_eq!((&polygon.status, &cone.status), (&SolveStatus::Solved, &ConeStatus::Solved));
            let gaps = cone_gaps(&problem, &polygon);
            // Rounding of the solver: its tolerance times impulses and speeds.
            let fuzz = 1e-9 * problem.velocity_scale().max(1.0);
            let mut right = 0.0;
            for (i, gap) in gaps.iter().enumerate() {
                let within =
                    |value: f64, bound: f64| value <= bound * (1.0 + 1e-9) + fuzz * (1.0 + polygon.lambda_n[i]);
                assert!(within(gap.missing_dissipation, gap.missing_dissipation_bound), "{family:?} {seed} {gap:?}");
                let speed = |v: &[f64]| {
                    let [_, c_1, c_2] = problem.contact_velocity(i, v);
                    c_1.hypot(c_2)
                };
                if speed(&polygon.velocity) > 1e-6 {
                    assert!(within(gap.angle, gap.angle_bound), "{family:?} {seed} {gap:?}");
                    assert!(within(gap.missing_impulse, gap.missing_impulse_bound), "{family:?} {seed} {gap:?}");
                }
                let coupling = polygon.lambda_n[i] - cone.impulse[i][0];
                right += gap.missing_dissipation
                    + problem.friction[i] * coupling * (speed(&cone.velocity) - speed(&polygon.velocity));
            }
            let left = energy_distance(&problem, &polygon.velocity, &cone.velocity).powi(2);
            let total: f64 = polygon.lambda_n.iter().sum();
            assert!(left <= right * (1.0 + 1e-9) + fuzz * (1.0 + total), "{family:?} {seed}: {left:e} > {right:e}");
            compared += usize::from(left > 1e-6);
        }
    }
    assert!(compared >= 30, "only {compared} problems differ");
}

/// Where the loads agree the distance of the velocities is within the root of the missing dissipation.
#[test]
fn velocity_is_within_its_bound_where_loads_agree() {
    let mut random = Random::new(5);
    for k in 0..60 {
        let count = [4, 6, 8, 16][k % 4];
        let polygon = FrictionPolygon::regular(count, random.between(0.0, 1.0)).expect("even");
        let velocity = DVec3::new(random.normal(), random.normal(), 0.0);
        let problem = tripod(velocity, 2.0 * random.normal(), random.between(0.1, 1.0), &polygon);
        let found = ContactSolver::default().solve(&problem, None);
        let exact = solve(&problem);
        let distance = energy_distance(&problem, &found.velocity, &exact.velocity);
        let bound = velocity_error_bound(&cone_gaps(&problem, &found));
        assert!(distance <= bound * (1.0 + 1e-9) + 1e-9, "m = {count}: {distance:e} > {bound:e}");
        assert!(distance > 0.0 && bound < 1.0);
    }
}
