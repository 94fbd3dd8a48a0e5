//! The certificate: zero for exact solutions, each law's violation in its own residual, independent of units.

use signorini_contact::{Certificate, ContactProblem, ContactSolution, FrictionPolygon, certify};
use signorini_multibody::BlockDiagonal;
use signorini_solver::ContactSolver;
use signorini_testkit::{Family, Parameters, Random, particle};

/// −2 m/s down, 3 m/s along x, φ/Δt = 0.2 m/s, μ = 1/4: λ_N = 1.8 stops the approach, friction takes 0.45 of the 3 m/s.
/// `s_v = 3`, `g = 1`, `max|M| = 1`.
fn sliding() -> (ContactProblem, ContactSolution) {
    let problem = particle(-2.0, [3.0, 0.0], 0.5, 0.1, 0.25);
    let mut solution = ContactSolution::default();
    solution.velocity = vec![-0.2, 2.55, 0.0];
    solution.lambda_n = vec![1.8];
    solution.alpha = vec![0.0, 0.0, 0.45, 0.0];
    solution.beta = vec![2.55];
    (problem, solution)
}

fn residuals(c: &Certificate) -> [f64; 6] {
    [c.momentum, c.natural_map, c.signorini, c.friction, c.dissipation, c.bilateral]
}

fn assert_residuals(found: &Certificate, wanted: [f64; 6], name: &str) {
    for (k, (found, wanted)) in residuals(found).iter().zip(wanted).enumerate() {
        assert!((found - wanted).abs() <= 1e-14, "{name}: residual {k} is {found:e}, expected {wanted:e}");
    }
}

#[test]
fn exact_solution_has_no_residual() {
    let (problem, solution) = sliding();
    assert_residuals(&certify(&problem, &solution), [0.0; 6], "exact");
}

#[test]
fn each_tampered_number_raises_its_own_residuals_by_a_known_amount() {
    let delta = 1e-3;
    let tampered = |name: &str, change: fn(&mut ContactSolution, f64), wanted: [f64; 6]| {
        let (problem, mut solution) = sliding();
        change(&mut solution, delta);
        assert_residuals(&certify(&problem, &solution), wanted.map(|r| r * delta), name);
    };
    // columns: momentum, natural map, Signorini, friction, dissipation, bilateral; each per unit of the change
    tampered("v normal", |s, d| s.velocity[0] += d, [1.0 / 3.0, 0.0, 1.0 / 3.0, 0.0, 0.0, 0.0]);
    tampered("v tangential", |s, d| s.velocity[2] += d, [1.0 / 3.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    // the velocity of the impulses separates by δ; the claimed one does not. The bound is μδ too wide for β = 2.55.
    let slack = 0.25 * 2.55 / 9.0;
    tampered("lambda_n", |s, d| s.lambda_n[0] += d, [1.0 / 3.0, 1.0 / 3.0, 0.0, 0.0, slack, 0.0]);
    // beyond the bound by δ: more than the largest dissipation, which is no violation of that law
    tampered("alpha", |s, d| s.alpha[2] += d, [1.0 / 3.0, 1.0 / 3.0, 0.0, 1.0 / 3.0, 0.0, 0.0]);
    tampered("negative alpha", |s, d| s.alpha[1] -= d, [1.0 / 3.0, 1.0 / 3.0, 0.0, 1.0 / 3.0, 0.0, 0.0]);
    // δ of the friction is turned by 90°: it dissipates nothing. The row of +y reads w = β + δ with α = δ.
    let turned = |s: &mut ContactSolution, d: f64| {
        s.alpha[1] += d;
        s.alpha[2] -= d;
    };
    tampered("turned friction", turned, [1.0 / 3.0, 1.0 / 3.0, 0.0, 0.0, 2.55 / 9.0, 0.0]);
    tampered("beta", |s, d| s.beta[0] += d, [0.0, 1.0 / 3.0, 0.0, 0.0, 0.0, 0.0]);
}

/// A ton that stops on the floor, and a gram that flies by itself: the gram's velocity counts by the gram.
#[test]
fn a_light_body_is_not_judged_by_the_mass_of_a_heavy_one() {
    let mass = BlockDiagonal::from_dense(2, &[1e3, 0.0, 0.0, 1e-3]).expect("symmetric");
    let mut problem = ContactProblem::new(mass, vec![-2.0, 0.5], 0.01).expect("valid data");
    problem.push_contact([(0, [1.0, 0.0, 0.0])], 0.0, 0.0, &FrictionPolygon::frictionless());
    let mut solution = ContactSolution::default();
    (solution.velocity, solution.lambda_n, solution.beta) = (vec![0.0, 0.5], vec![2e3], vec![0.0]);
    assert_residuals(&certify(&problem, &solution), [0.0; 6], "exact");
    solution.velocity[1] += 1e-3;
    assert_residuals(&certify(&problem, &solution), [5e-4, 0.0, 0.0, 0.0, 0.0, 0.0], "the gram's velocity");
}

/// A gram that two contacts press from both sides with impulses whose difference keeps ten digits: what is left of them is rounding.
#[test]
fn impulses_that_cancel_are_judged_by_their_size() {
    let mass = BlockDiagonal::from_dense(1, &[1e-3]).expect("symmetric");
    let mut problem = ContactProblem::new(mass, vec![-1.0], 0.01).expect("valid data");
    for side in [1.0, -1.0] {
        problem.push_contact([(0, [side, 0.0, 0.0])], 0.0, 0.0, &FrictionPolygon::frictionless());
    }
    let mut solution = ContactSolution::default();
    (solution.velocity, solution.lambda_n, solution.beta) = (vec![0.0], vec![1e6 + 1e-3, 1e6], vec![0.0; 2]);
    // The velocity misses the impulses by 1e-6 m/s.
    solution.velocity[0] = 1e-6;
    let momentum = certify(&problem, &solution).momentum;
    assert!((momentum - 1e-9 / 2.0).abs() < 1e-10, "{momentum:e}: 1e-9 N·s by 1e-6 of 2e6 N·s");
}

#[test]
fn bilateral_row_has_a_residual_of_its_own() {
    // 2 v_x + 0.1/0.5 = 0 by λ_B: v_x = −0.1 from 3, so 2 λ_B = −3.1. No contact: s_v = |2·3 + 0.2| = 6.2.
    let mut problem = particle(1.0, [3.0, 0.0], 0.5, 0.1, 0.25);
    problem.clear_contacts();
    problem.push_bilateral([(1, [2.0])], 0.1);
    let mut solution = ContactSolution::default();
    solution.velocity = vec![1.0, -0.1, 0.0];
    solution.bilateral = vec![-1.55];
    assert_residuals(&certify(&problem, &solution), [0.0; 6], "exact");
    solution.velocity[1] += 1e-3;
    assert_residuals(&certify(&problem, &solution), [1e-3 / 6.2, 0.0, 0.0, 0.0, 0.0, 2e-3 / 6.2], "velocity");
    solution.velocity[1] -= 1e-3;
    solution.bilateral[0] += 1e-3;
    assert_residuals(&certify(&problem, &solution), [2e-3 / 6.2, 4e-3 / 6.2, 0.0, 0.0, 0.0, 0.0], "impulse");
}

#[test]
fn zero_data_accept_rest_and_nothing_else() {
    let problem = particle(0.0, [0.0, 0.0], 0.5, 0.0, 0.25);
    let mut solution = ContactSolution::default();
    solution.velocity = vec![0.0; 3];
    solution.lambda_n = vec![0.0];
    solution.alpha = vec![0.0; 4];
    solution.beta = vec![0.0];
    assert_eq!(certify(&problem, &solution).worst(), 0.0);
    for (dof, v) in [(0, 1e-12), (0, -1e-12), (1, 1e-12), (1, -1e-12), (2, 1e-12), (2, -1e-12)] {
        solution.velocity[dof] = v;
        assert_eq!(certify(&problem, &solution).worst(), f64::INFINITY, "{v} along {dof}");
        solution.velocity[dof] = 0.0;
    }
    solution.lambda_n[0] = 1e-12;
    assert_eq!(certify(&problem, &solution).worst(), f64::INFINITY);
}

/// A way to spoil the data, with its name.
type Damage = (&'static str, fn(&mut ContactProblem));

type Entry = (&'static str, fn(&mut ContactSolution, f64));

const ENTRIES: [Entry; 4] = [
    ("v", |s, x| s.velocity[0] = x),
    ("lambda_n", |s, x| s.lambda_n[0] = x),
    ("alpha", |s, x| s.alpha[3] = x),
    ("beta", |s, x| s.beta[0] = x),
];

#[test]
fn a_number_that_is_none_makes_the_certificate_infinite() {
    let open = particle(1.0, [0.5, 0.0], 0.5, 0.1, 0.25);
    let mut flying = ContactSolution::default();
    flying.velocity = vec![1.0, 0.5, 0.0];
    flying.lambda_n = vec![0.0];
    flying.alpha = vec![0.0; 4];
    flying.beta = vec![0.5];
    assert_eq!(certify(&open, &flying).worst(), 0.0);
    for (problem, solution) in [sliding(), (open, flying)] {
        for (name, set) in ENTRIES {
            for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
                let mut damaged = solution.clone();
                set(&mut damaged, value);
                assert_eq!(certify(&problem, &damaged).worst(), f64::INFINITY, "{name} = {value}");
            }
        }
    }
}

#[test]
fn data_that_are_no_numbers_are_never_certified() {
    let (problem, solution) = sliding();
    let damages: [Damage; 5] = [
        ("phi", |p| p.gap[0] = f64::NAN),
        ("mu", |p| p.friction[0] = f64::NAN),
        ("v_free", |p| p.free_velocity[2] = f64::NAN),
        ("dt", |p| p.timestep = f64::NAN),
        ("D", |p| p.directions[1] = [f64::NAN; 2]),
    ];
    for (name, damage) in damages {
        let mut damaged = problem.clone();
        damage(&mut damaged);
        assert!(damaged.check().is_err(), "{name}");
        let certificate = certify(&damaged, &solution);
        assert_eq!([certificate.worst(), certificate.natural_map], [f64::INFINITY; 2], "{name}");
        let mut zero = solution.clone();
        (zero.lambda_n, zero.alpha, zero.beta) = (vec![0.0], vec![0.0; 4], vec![0.0]);
        zero.velocity.clone_from(&damaged.free_velocity);
        assert_eq!(certify(&damaged, &zero).worst(), f64::INFINITY, "{name}, no impulses");
    }
}

#[test]
fn arrays_of_wrong_sizes_are_no_solution() {
    let (problem, solution) = sliding();
    let changes: [fn(&mut ContactSolution); 7] = [
        |s| s.velocity.truncate(2),
        |s| s.lambda_n.push(0.0),
        |s| s.alpha.truncate(3),
        |s| s.beta.clear(),
        |s| s.bilateral.push(0.0),
        |s| s.group_alpha.push(0.0),
        |s| s.group_beta.push(0.0),
    ];
    for change in changes {
        let mut other = solution.clone();
        change(&mut other);
        let certificate = certify(&problem, &other);
        assert!(residuals(&certificate).iter().all(|r| *r == f64::INFINITY), "{certificate:?}");
    }
    assert_eq!(certify(&problem, &ContactSolution::default()).worst(), f64::INFINITY);
}

#[test]
fn merging_keeps_the_larger_of_each() {
    let (mut a, mut b) = (Certificate::default(), Certificate::default());
    (a.momentum, a.friction) = (1.0, 2.0);
    (b.momentum, b.signorini, b.dissipation) = (0.5, 3.0, f64::NAN);
    a.merge(&b);
    assert_eq!(residuals(&a), [1.0, 0.0, 3.0, 2.0, f64::INFINITY, 0.0]);
    assert!(!a.holds(1e300) && Certificate::default().holds(0.0));
}

/// The same problem and solution in other units of mass and time (and of length, for what translates).
fn in_units(
    problem: &ContactProblem,
    solution: &ContactSolution,
    m: f64,
    l: f64,
    t: f64,
) -> (ContactProblem, ContactSolution) {
    let scaled = |x: &[f64], factor: f64| x.iter().map(|x| x * factor).collect::<Vec<f64>>();
    let nv = problem.nv();
    let mass = BlockDiagonal::from_dense(nv, &scaled(&problem.mass.to_dense(), m)).expect("symmetric");
    let mut out =
        ContactProblem::new(mass, scaled(&problem.free_velocity, l / t), problem.timestep * t).expect("valid");
    out.jacobian = problem.jacobian.clone();
    out.gap = scaled(&problem.gap, l);
    out.friction.clone_from(&problem.friction);
    out.directions.clone_from(&problem.directions);
    out.direction_offsets.clone_from(&problem.direction_offsets);
    let mut other = ContactSolution::default();
    other.velocity = scaled(&solution.velocity, l / t);
    other.lambda_n = scaled(&solution.lambda_n, m * l / t);
    other.alpha = scaled(&solution.alpha, m * l / t);
    other.beta = scaled(&solution.beta, l / t);
    (out, other)
}

/// Lengths are scaled with the lever arms kept: the same as another unit of length for the linear degrees of freedom with an
/// angular velocity in units of its own.
#[test]
fn residuals_do_not_depend_on_units() {
    let mut solver = ContactSolver::default();
    for seed in 0..40 {
        let mut random = Random::new(seed);
        let parameters = Parameters::random(&mut random);
        let problem = Family::ALL[seed as usize % Family::ALL.len()].small(&mut random, &parameters);
        let mut solution = solver.solve(&problem, None);
        let scale = problem.velocity_scale();
        solution.velocity.iter_mut().for_each(|v| *v += 1e-3 * scale * random.normal());
        solution.lambda_n.iter_mut().chain(&mut solution.alpha).for_each(|p| *p *= random.between(0.9, 1.2));
        solution.beta.iter_mut().for_each(|b| *b *= random.between(0.9, 1.2));
        let here = residuals(&certify(&problem, &solution));
        for (m, l, t) in [(1e3, 1.0, 1.0), (1.0, 1e-3, 1.0), (1.0, 1.0, 3600.0), (0.4536, 0.3048, 1e-3)] {
            let (other, moved) = in_units(&problem, &solution, m, l, t);
            let there = residuals(&certify(&other, &moved));
            for (a, b) in here.iter().zip(there) {
                assert!(
                    (a - b).abs() <= 1e-9 * here.iter().fold(0.0, |x: f64, y| x.max(*y)),
                    "seed {seed}: {here:?} and {there:?}"
                );
            }
        }
    }
}

/// Another unit of length for free bodies, lever arms included: angular velocities keep their numbers, moments of inertia
/// change with its square. Only the momentum residual may change, because the largest entry of a body's `|M|` then is another: kg and
/// kg·m² have no common scale.
#[test]
fn contact_laws_do_not_depend_on_the_unit_of_length() {
    let mut solver = ContactSolver::default();
    for seed in 0..40 {
        let mut random = Random::new(300 + seed);
        let parameters = Parameters::random(&mut random);
        let family = random.choice(&[Family::Box, Family::Stack, Family::Pyramid, Family::Cluster]);
        let problem = family.small(&mut random, &parameters);
        let mut solution = solver.solve(&problem, None);
        solution.lambda_n.iter_mut().chain(&mut solution.alpha).for_each(|p| *p *= random.between(0.9, 1.2));
        let here = residuals(&certify(&problem, &solution));
        for length in [100.0, 1e-3] {
            let (other, moved) = in_length(&problem, &solution, length);
            let there = residuals(&certify(&other, &moved));
            for k in 1..5 {
                let most = here.iter().fold(0.0, |x: f64, y| x.max(*y));
                assert!((here[k] - there[k]).abs() <= 1e-9 * most, "seed {seed}: {here:?} and {there:?}");
            }
        }
    }
}

/// Free bodies with six degrees of freedom each, the last three angular.
fn in_length(problem: &ContactProblem, solution: &ContactSolution, l: f64) -> (ContactProblem, ContactSolution) {
    let nv = problem.nv();
    let unit = |dof: usize| if dof % 6 < 3 { 1.0 } else { l };
    let velocity = |v: &[f64]| v.iter().enumerate().map(|(k, v)| v * l / unit(k)).collect::<Vec<f64>>();
    let dense = problem.mass.to_dense();
    let dense: Vec<f64> = (0..nv * nv).map(|k| dense[k] * unit(k / nv) * unit(k % nv)).collect();
    let mass = BlockDiagonal::from_dense(nv, &dense).expect("symmetric");
    let mut out = ContactProblem::new(mass, velocity(&problem.free_velocity), problem.timestep).expect("valid");
    for i in 0..problem.contact_count() {
        let (columns, entries) = problem.jacobian.group(i);
        let group = columns.iter().zip(entries).map(|(&c, e)| (c, e.map(|e| e * unit(c as usize))));
        let polygon = FrictionPolygon::from_directions(problem.directions_of(i).to_vec()).expect("valid");
        out.push_contact(group, problem.gap[i] * l, problem.friction[i], &polygon);
    }
    let mut moved = solution.clone();
    moved.velocity = velocity(&solution.velocity);
    for x in [&mut moved.lambda_n, &mut moved.alpha, &mut moved.beta] {
        x.iter_mut().for_each(|x| *x *= l);
    }
    (out, moved)
}
