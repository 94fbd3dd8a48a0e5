//! Motions without contact against closed forms and references of high accuracy: the whole step, as it is used.
//!
//! The scheme is of first order where `h` is taken at the beginning of the step, with `v` belonging to the middle of the
//! step before; halving Δt halves the error.

use signorini::multibody::glam::{DMat3, DVec3};
use signorini::multibody::{
    ArticulatedBodies, BodyId, Inertia, Joint, JointKind, Kinematics, Model, ModelBuilder, Pose, State,
    forward_dynamics_into, forward_kinematics_into, rotation_exp,
};
use signorini::{Settings, Simulation};

use crate::support::{G, kinematics, run_certified};

/// A chain of links with hinges along −y that hangs along −z from the origin: masses at the lower ends.
fn chain(masses: &[f64], length: f64, rod: f64) -> Model {
    let mut builder = ModelBuilder::new("chain");
    builder.gravity(DVec3::NEG_Z * G);
    let (mut parent, mut position) = (BodyId::WORLD, DVec3::ZERO);
    for (i, &end) in masses.iter().enumerate() {
        // A thin rod of mass `rod` with a point mass at its end.
        let mass = rod + end;
        let center = -length * (0.5 * rod + end) / mass;
        let about_hinge = length * length * (rod / 3.0 + end);
        let across = about_hinge - mass * center * center;
        let inertia = Inertia {
            mass,
            center_of_mass: DVec3::Z * center,
            rotational: DMat3::from_diagonal(DVec3::new(across, across, 0.0)),
        };
        parent = builder.add_body(format!("link{i}"), parent, Pose::from_position(position), inertia).unwrap();
        builder.add_joint(parent, Joint::new(format!("hinge{i}"), JointKind::Hinge { axis: DVec3::NEG_Y })).unwrap();
        position = DVec3::NEG_Z * length;
    }
    builder.build().unwrap()
}

/// The state after `duration` by steps of the engine.
fn stepped(model: &Model, start: &State, dt: f64, duration: f64) -> State {
    let mut simulation = Simulation::new(model.clone(), Settings::default().with_timestep(dt)).unwrap();
    simulation.set_state(start).unwrap();
    run_certified(&mut simulation, duration);
    simulation.state().clone()
}

/// The same by the classical Runge–Kutta method of fourth order with accelerations of the articulated-body algorithm;
/// hinges only.
fn runge_kutta(model: &Model, start: &State, dt: f64, duration: f64) -> State {
    let mut at = Kinematics::new(model);
    let mut work = ArticulatedBodies::new(model);
    let tau = vec![0.0; model.nv];
    let mut acceleration = |q: &[f64], v: &[f64]| {
        let mut a = vec![0.0; v.len()];
        forward_kinematics_into(model, q, v, &mut at);
        forward_dynamics_into(model, &at, &tau, &mut work, &mut a).unwrap();
        a
    };
    let plus = |x: &[f64], d: &[f64], h: f64| -> Vec<f64> { x.iter().zip(d).map(|(x, d)| x + h * d).collect() };
    let State { mut q, mut v, .. } = start.clone();
    for _ in 0..(duration / dt).round() as u64 {
        let a1 = acceleration(&q, &v);
        let v2 = plus(&v, &a1, 0.5 * dt);
        let a2 = acceleration(&plus(&q, &v, 0.5 * dt), &v2);
        let v3 = plus(&v, &a2, 0.5 * dt);
        let a3 = acceleration(&plus(&q, &v2, 0.5 * dt), &v3);
        let v4 = plus(&v, &a3, dt);
        let a4 = acceleration(&plus(&q, &v3, dt), &v4);
        for k in 0..q.len() {
            q[k] += dt / 6.0 * (v[k] + 2.0 * v2[k] + 2.0 * v3[k] + v4[k]);
            v[k] += dt / 6.0 * (a1[k] + 2.0 * a2[k] + 2.0 * a3[k] + a4[k]);
        }
    }
    State::at(q, v).with_time(duration)
}

fn difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |m, (a, b)| f64::max(m, (a - b).abs()))
}

/// Errors at three steps, each half of the one before, fall by the factor of the order; the last is at most `largest`.
fn check_order(order: i32, largest: f64, error: impl Fn(f64) -> f64, coarse: f64) {
    let errors = [1.0, 0.5, 0.25].map(|part| error(coarse * part));
    println!("errors at Δt, Δt/2, Δt/4: {:.2e} {:.2e} {:.2e}", errors[0], errors[1], errors[2]);
    assert!(errors[2] < largest, "{errors:?}");
    for pair in errors.windows(2) {
        let ratio = pair[0] / pair[1];
        let expected = 2.0_f64.powi(order);
        assert!((ratio / expected - 1.0).abs() < 0.15, "{errors:?}");
    }
}

/// sn and cn of the elliptic functions by the descending Landen transformation (Abramowitz, Stegun 16.4), m = k².
fn jacobi(u: f64, m: f64) -> (f64, f64) {
    let (mut a, mut c) = (vec![1.0], vec![m.sqrt()]);
    let mut b = (1.0 - m).sqrt();
    while c[c.len() - 1] > 1e-16 {
        let last = a[a.len() - 1];
        c.push(0.5 * (last - b));
        a.push(0.5 * (last + b));
        b = (last * b).sqrt();
    }
    let mut phi = 2.0_f64.powi(a.len() as i32 - 1) * a[a.len() - 1] * u;
    for i in (1..a.len()).rev() {
        phi = 0.5 * (phi + (c[i] / a[i] * phi.sin()).asin());
    }
    phi.sin_cos()
}

/// `sin(θ/2) = k sn(K − ω t)` with `k = sin(θ₀/2)`, from rest at θ₀.
#[test]
fn a_pendulum_converges_to_the_elliptic_function() {
    let (length, theta, duration) = (0.8, 2.0_f64, 3.0);
    let model = chain(&[1.3], length, 0.0);
    let omega = (G / length).sqrt();
    let m = (0.5 * theta).sin().powi(2);
    let (mut a, mut b) = (1.0, (1.0 - m).sqrt());
    for _ in 0..8 {
        (a, b) = (0.5 * (a + b), f64::sqrt(a * b));
    }
    let quarter = std::f64::consts::FRAC_PI_2 / a;
    let exact = 2.0 * (m.sqrt() * jacobi(quarter - omega * duration, m).0).asin();
    let start = State::at(vec![theta], vec![0.0]);
    check_order(1, 5e-3, |dt| (stepped(&model, &start, dt, duration).q[0] - exact).abs(), 4e-3);
    // With the velocity half a step before the start the scheme is the leapfrog method.
    let shifted = |dt: f64| start.clone().with_v(vec![0.5 * dt * omega * omega * theta.sin()]);
    check_order(2, 1e-5, |dt| (stepped(&model, &shifted(dt), dt, duration).q[0] - exact).abs(), 4e-3);
}

#[test]
fn a_double_pendulum_converges() {
    let model = chain(&[1.0, 0.6], 0.7, 0.2);
    let start = State::at(vec![1.1, 0.8], vec![0.0, 0.0]);
    let exact = runge_kutta(&model, &start, 1e-4, 1.5);
    let check = runge_kutta(&model, &start, 2e-4, 1.5);
    assert!(difference(&exact.q, &check.q) < 1e-10, "the reference is exact enough");
    check_order(1, 1e-2, |dt| difference(&stepped(&model, &start, dt, 1.5).q, &exact.q), 2e-3);
}

/// Fifty links of 0.1 kg that carry 100 kg: a mass ratio of a thousand along a chain.
#[test]
fn a_chain_with_a_heavy_end_converges() {
    let mut masses = [0.0; 50];
    masses[49] = 100.0;
    let model = chain(&masses, 0.1, 0.1);
    let mut start = State::new(&model);
    start.q[0] = 0.4;
    let duration = 0.4;
    let exact = runge_kutta(&model, &start, 1e-4, duration);
    let check = runge_kutta(&model, &start, 2e-4, duration);
    // A fifteenth of the difference is the reference's error.
    assert!(difference(&exact.q, &check.q) < 1e-7, "{:e}", difference(&exact.q, &check.q));
    check_order(1, 2e-2, |dt| difference(&stepped(&model, &start, dt, duration).q, &exact.q), 1e-3);
}

/// A free symmetric body: `R(t) = exp(L t / A) exp((A − C)/A ω_z t z)`.
#[test]
fn a_free_symmetric_top_converges_to_its_closed_form() {
    let (across, along) = (0.03, 0.05);
    let rotational = DMat3::from_diagonal(DVec3::new(across, across, along));
    let mut builder = ModelBuilder::new("top");
    builder.gravity(DVec3::ZERO);
    let inertia = Inertia { mass: 1.0, center_of_mass: DVec3::ZERO, rotational };
    let body = builder.add_body("top", BodyId::WORLD, Pose::IDENTITY, inertia).unwrap();
    builder.add_joint(body, Joint::new("free", JointKind::Free)).unwrap();
    let model = builder.build().unwrap();
    let (omega, duration) = (DVec3::new(3.0, -1.0, 8.0), 2.0);
    let momentum = rotational * omega;
    let rate = (across - along) / across * omega.z;
    let exact = rotation_exp(momentum * (duration / across)) * rotation_exp(DVec3::Z * (rate * duration));
    let error = |dt: f64, shift: f64| {
        let mut simulation = Simulation::new(model.clone(), Settings::default().with_timestep(dt)).unwrap();
        let mut state = State::new(&model);
        let earlier = rotation_exp(DVec3::Z * (rate * shift)) * omega;
        state.v[3..].copy_from_slice(&earlier.to_array());
        simulation.set_state(&state).unwrap();
        run_certified(&mut simulation, duration);
        let rotation = kinematics(&simulation).pose[1].rotation;
        (rotation * DVec3::Z - exact * DVec3::Z).length().max((rotation * DVec3::X - exact * DVec3::X).length())
    };
    check_order(1, 1e-1, |dt| error(dt, 0.0), 4e-3);
    // Half a step before the start.
    check_order(2, 1e-3, |dt| error(dt, 0.5 * dt), 4e-3);
}
