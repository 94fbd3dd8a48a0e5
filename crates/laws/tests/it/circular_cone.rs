//! The polygon against the circular cone (formulation §9), which an independent method solves: De Saxcé's fixed point.
//!
//! What theory says: where a contact sticks inside both cones the two agree. Where it slides, the polygon's impulse is a point
//! of the polygon while the cone's is on the circle. Along the sliding direction the two differ by at most
//! `1 − cos(π/m) ≈ π²/2m²` of `μ λ_N`; across it by up to `sin(π/m) ≈ π/m`, because the impulse sits at the vertex nearest to
//! the sliding direction. So the velocity vector converges with `1/m`, and with `1/m²` what the sliding loses in speed and in
//! energy, if tangential impulses do not change the normal ones; if they do, the energy also has a part in `1/m`.

use std::f64::consts::{PI, TAU};

use signorini_contact::{ContactProblem, FrictionPolygon, SolveStatus};
use signorini_multibody::glam::{DMat3, DVec3};
use signorini_solver::ContactSolver;
use signorini_testkit::{Dense, Gap, Motion, Parameters, Random, RigidBody, Scene, families, largest_difference};

use signorini_testkit::particle;

const COUNTS: [usize; 4] = [4, 8, 16, 64];

/// `v⁺` with the circular cone: `λ ← P_K(λ − ρ (u + μ‖u_T‖ n))` contact after contact (De Saxcé, Feng 1998) until
/// `‖λ − P_K(λ − ρ …)‖` is at rounding.
pub fn with_circular_cone(problem: &ContactProblem) -> Vec<f64> {
    let (nv, nc) = (problem.free_velocity.len(), problem.gap.len());
    let mut J = Dense::zeros(3 * nc, nv);
    for i in 0..nc {
        let (columns, entries) = problem.jacobian.group(i);
        for (&c, e) in columns.iter().zip(entries) {
            (0..3).for_each(|r| J[(3 * i + r, c as usize)] = e[r]);
        }
    }
    let response = Dense::from_fn(nv, nv, |i, j| problem.mass.get(i, j)).inverse().times(&J.transposed());
    let mut v = problem.free_velocity.clone();
    let mut impulses = vec![[0.0; 3]; nc];
    let scale = v.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
    for _ in 0..2_000_000 {
        let mut moved = 0.0_f64;
        for i in 0..nc {
            let mut u: [f64; 3] = std::array::from_fn(|r| (0..nv).map(|k| J[(3 * i + r, k)] * v[k]).sum());
            u[0] += problem.gap[i] / problem.timestep;
            let mu = problem.friction[i];
            let g: f64 =
                (0..3).map(|r| (0..nv).map(|k| J[(3 * i + r, k)] * response[(k, 3 * i + r)]).sum::<f64>()).sum();
            let rho = 1.0 / g;
            let p = impulses[i];
            let slip = u[1].hypot(u[2]);
            let next = onto_cone(mu, [p[0] - rho * (u[0] + mu * slip), p[1] - rho * u[1], p[2] - rho * u[2]]);
            for r in 0..3 {
                let step = next[r] - p[r];
                (0..nv).for_each(|k| v[k] += response[(k, 3 * i + r)] * step);
                moved = moved.max(g * step.abs());
            }
            impulses[i] = next;
        }
        if moved <= 1e-15 * scale {
            break;
        }
    }
    v
}

/// Euclidean projection onto `‖λ_T‖ ≤ μ λ_N`.
fn onto_cone(mu: f64, p: [f64; 3]) -> [f64; 3] {
    let t = p[1].hypot(p[2]);
    if t <= mu * p[0] {
        return p;
    }
    if mu * t <= -p[0] {
        return [0.0; 3];
    }
    let n = (p[0] + mu * t) / (1.0 + mu * mu);
    [n, mu * n * p[1] / t, mu * n * p[2] / t]
}

/// The same problem with `count` directions from `angle` on.
pub fn with_polygon(problem: &ContactProblem, count: usize, angle: f64) -> ContactProblem {
    let polygon = FrictionPolygon::regular(count, angle).expect("even");
    let mut out = problem.clone();
    out.directions = polygon.directions().repeat(problem.contact_count());
    out.direction_offsets = (0..=problem.contact_count()).map(|i| i * count).collect();
    out.check().expect("valid data");
    out
}

fn velocity(problem: &ContactProblem) -> Vec<f64> {
    let solution = ContactSolver::default().solve(problem, None);
    assert_eq!(solution.status, SolveStatus::Solved, "{:e}", solution.certificate.worst());
    solution.velocity
}

/// The oracle itself against a closed form: a particle pressed on a plane that slides or sticks.
#[test]
fn oracle_solves_a_particle() {
    let problem = particle(-0.5, [3.0, 4.0], 0.01, 0.0, 0.4);
    let v = with_circular_cone(&problem);
    assert!(largest_difference(&v, &[0.0, 3.0 * (1.0 - 0.2 / 5.0), 4.0 * (1.0 - 0.2 / 5.0)]) < 1e-12, "{v:?}");
    let v = with_circular_cone(&particle(-0.5, [0.1, -0.1], 0.01, 0.0, 0.4));
    assert!(largest_difference(&v, &[0.0; 3]) < 1e-12, "{v:?}");
}

#[test]
fn sticking_is_the_same_for_every_number_of_directions() {
    for count in COUNTS {
        for angle in [0.0, 0.4] {
            let problem = with_polygon(&particle(-0.5, [0.1, -0.09], 0.01, 0.0, 0.4), count, angle);
            assert!(largest_difference(&velocity(&problem), &[0.0; 3]) < 1e-14);
        }
    }
}

/// The particle at 5 m/s; over all orientations of the polygon, the worst speed is off by `μ λ_N (1 − cos(π/m))` and the worst
/// velocity by `2 μ λ_N sin(π/2m)`, the distance from a vertex to the middle of its arc.
#[test]
fn sliding_particle_has_the_worst_errors_that_theory_gives() {
    let (mu, lambda) = (0.4, 0.5);
    let exact = with_circular_cone(&particle(-lambda, [3.0, 4.0], 0.01, 0.0, mu));
    for count in COUNTS {
        let (mut of_speed, mut of_velocity) = (0.0_f64, 0.0_f64);
        for k in 0..2000 {
            let angle = TAU * f64::from(k) / 2000.0 / count as f64;
            let v = velocity(&with_polygon(&particle(-lambda, [3.0, 4.0], 0.01, 0.0, mu), count, angle));
            of_speed = of_speed.max((v[1].hypot(v[2]) - exact[1].hypot(exact[2])).abs());
            of_velocity = of_velocity.max((v[1] - exact[1]).hypot(v[2] - exact[2]));
        }
        let half = PI / count as f64;
        println!("m = {count}: speed off by {of_speed:.2e}, velocity by {of_velocity:.2e}");
        let (speed, distance) = (mu * lambda * (1.0 - half.cos()), 2.0 * mu * lambda * (0.5 * half).sin());
        // Friction is small against 5 m/s: the final direction, which picks the vertex, is close to the first.
        assert!(of_speed <= 1.01 * speed && of_speed >= 0.9 * speed, "m = {count}: {of_speed:e}, theory {speed:e}");
        assert!(
            of_velocity <= 1.01 * distance && of_velocity >= 0.9 * distance,
            "m = {count}: {of_velocity:e}, {distance:e}"
        );
    }
}

/// Root mean squares over orientations of the polygon of the errors in `v⁺` and in the kinetic energy after the step, both
/// relative to what friction changes.
fn errors(problem: &ContactProblem, count: usize, random: &mut Random) -> [f64; 2] {
    let exact = with_circular_cone(problem);
    let mut smooth = problem.clone();
    smooth.friction.fill(0.0);
    let smooth = velocity(&smooth);
    let energy = |v: &[f64]| {
        let mut p = vec![0.0; v.len()];
        problem.mass.multiply_into(v, &mut p);
        v.iter().zip(&p).map(|(v, p)| 0.5 * v * p).sum::<f64>()
    };
    let distance = |a: &[f64], b: &[f64]| energy(&a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<f64>>()).sqrt();
    let (effect, lost) = (distance(&exact, &smooth), (energy(&exact) - energy(&smooth)).abs());
    let mut sums = [0.0; 2];
    const ORIENTATIONS: usize = 40;
    for _ in 0..ORIENTATIONS {
        let v = velocity(&with_polygon(problem, count, random.between(0.0, TAU)));
        sums[0] += (distance(&v, &exact) / effect).powi(2);
        sums[1] += ((energy(&v) - energy(&exact)) / lost).powi(2);
    }
    sums.map(|s| (s / ORIENTATIONS as f64).sqrt())
}

/// First order in the velocity vector and, if `uncoupled`, second order in the energy that friction takes, over sixteen times
/// as many directions. `uncoupled`: tangential impulses do not change normal ones.
///
/// Returns false where the contacts stick: both errors then vanish for every number of directions.
fn assert_orders(problem: &ContactProblem, uncoupled: bool, random: &mut Random, name: &str) -> bool {
    let all: Vec<[f64; 2]> = COUNTS.iter().map(|&count| errors(problem, count, random)).collect();
    println!("{name}: {all:?}");
    if all.iter().flatten().all(|e| *e <= 1e-9) {
        return false;
    }
    let order = |k: usize| (all[0][k] / all[3][k]).ln() / 16_f64.ln();
    assert!(order(0) >= 0.8, "{name}: velocity converges with order {:.2}: {all:?}", order(0));
    let least = if uncoupled { 1.8 } else { 0.8 };
    assert!(order(1) >= least, "{name}: energy converges with order {:.2}: {all:?}", order(1));
    for (count, [v, e]) in COUNTS.iter().zip(&all) {
        let half = PI / *count as f64;
        let most = if uncoupled { half * half } else { half };
        assert!(*v <= half && *e <= most, "{name}, m = {count}: {v:e}, {e:e}");
    }
    true
}

#[test]
fn one_body_problems_converge_to_the_cone() {
    let mut sliding = 0;
    for seed in 0..12 {
        let mut random = Random::new(700 + seed);
        let friction = random.between(0.05, 0.3);
        let parameters = Parameters { friction, gap: Gap::Zero, motion: Motion::Impact, ..Parameters::default() };
        let problem = families::cluster(&mut random, &parameters, 1);
        sliding += usize::from(assert_orders(&problem, false, &mut random, &format!("body {seed}")));
    }
    assert!(sliding >= 8, "only {sliding} of 12 slide");
}

/// A box that slides without spin on its four corners, and a three-legged table that slides and spins (with four legs the
/// share of each leg, and with it the braking of the spin, would not be unique).
#[test]
fn sliding_boxes_and_spinning_tables_converge_to_the_cone() {
    let four = vec![(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)];
    let three = vec![(0.5, 0.0), (-0.25, 0.4), (-0.25, -0.4)];
    for (name, feet, spin) in [("sliding box", four, 0.0), ("spinning table", three, 2.0)] {
        // Friction below the centre of mass shifts weight between the legs; without spin all legs brake alike.
        let uncoupled = spin == 0.0;
        let mut scene = Scene::default();
        let body = RigidBody::cuboid(DVec3::new(1.0, 1.0, 0.5), 20.0, DVec3::Z * 0.25, DMat3::IDENTITY);
        let body = scene.body(body.moving((DVec3::new(0.8, 0.6, 0.0), DVec3::Z * spin)));
        for (x, y) in feet {
            scene.contact(None, Some(body), DVec3::new(x, y, 0.0), DVec3::Z, 0.0);
        }
        let problem = scene.problem(|_| (0.2, FrictionPolygon::regular(4, 0.0).expect("even")));
        assert!(assert_orders(&problem, uncoupled, &mut Random::new(9), name), "{name} sticks");
    }
}
