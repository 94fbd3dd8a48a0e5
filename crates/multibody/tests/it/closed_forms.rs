//! Motions with a known formula.

use signorini_multibody::glam::{DMat3, DVec3};
use signorini_multibody::{
    BodyId, FreeMotion, Inertia, Input, Joint, JointKind, Kinematics, Model, ModelBuilder, Pose, State,
    angular_momentum, center_of_mass, forward_kinematics_into, free_motion_into, integrate_into, kinetic_energy,
    potential_energy, rotation_exp,
};

use crate::identities::{FIXED, forward_dynamics, inverse_dynamics, kinematics, relative_error};
use crate::random_model::{Random, for_random_models};

const G: f64 = 9.81;

/// A chain of point masses that swings in the x–z plane, hanging along −z at q = 0.
fn pendulum(masses: &[f64], lengths: &[f64]) -> Model {
    let mut builder = ModelBuilder::new("pendulum");
    let (mut parent, mut position) = (BodyId::WORLD, DVec3::new(1.0, 2.0, 3.0));
    for (i, (&mass, &length)) in masses.iter().zip(lengths).enumerate() {
        let inertia = Inertia { mass, center_of_mass: DVec3::NEG_Z * length, rotational: DMat3::ZERO };
        parent = builder.add_body(format!("link{i}"), parent, Pose::from_position(position), inertia).unwrap();
        builder.add_joint(parent, Joint::new(format!("hinge{i}"), JointKind::Hinge { axis: DVec3::NEG_Y })).unwrap();
        position = DVec3::NEG_Z * length;
    }
    builder.build().unwrap()
}

/// A body on a free joint without gravity.
fn free_body(inertia: Inertia) -> Model {
    let mut builder = ModelBuilder::new("free");
    builder.gravity(DVec3::ZERO);
    let body = builder.add_body("body", BodyId::WORLD, Pose::IDENTITY, inertia).unwrap();
    builder.add_joint(body, Joint::new("free", JointKind::Free)).unwrap();
    builder.build().unwrap()
}

/// One step without contact.
fn step(model: &Model, state: &mut State, dt: f64, free: &mut FreeMotion) {
    let at = kinematics(model, state);
    free_motion_into(model, &at, state, &Input::default(), dt, free).unwrap();
    let q = state.q.clone();
    integrate_into(model, &q, &free.free_velocity, dt, &mut state.q);
    state.v.copy_from_slice(&free.free_velocity);
    state.time += dt;
}

/// The derivative of `(q, v)` in coordinates, quaternions by `½ r (0, ω)`.
fn rates(model: &Model, q: &[f64], v: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let mut at = Kinematics::new(model);
    forward_kinematics_into(model, q, v, &mut at);
    let springs: Vec<f64> = (0..model.nv)
        .map(|k| {
            let joint = &model.joints[model.dof_joint[k].index()];
            if joint.stiffness == 0.0 { 0.0 } else { -joint.stiffness * (q[joint.q_index] - joint.spring_reference) }
        })
        .collect();
    let mut dq = vec![0.0; model.nq];
    for joint in &model.joints {
        let (mut i, mut k) = (joint.q_index, joint.v_index);
        if joint.kind.nv() != 3 {
            let n = joint.kind.nv().min(3);
            dq[i..i + n].copy_from_slice(&v[k..k + n]);
            (i, k) = (i + 3, k + 3);
        }
        if joint.kind.nv() >= 3 {
            let (w, x, y, z) = (q[i], q[i + 1], q[i + 2], q[i + 3]);
            let (a, b, c) = (v[k], v[k + 1], v[k + 2]);
            dq[i] = -0.5 * (x * a + y * b + z * c);
            dq[i + 1] = 0.5 * (w * a + y * c - z * b);
            dq[i + 2] = 0.5 * (w * b + z * a - x * c);
            dq[i + 3] = 0.5 * (w * c + x * b - y * a);
        }
    }
    (dq, forward_dynamics(model, &at, &springs))
}

/// The classical Runge–Kutta method of fourth order, in coordinates.
fn runge_kutta(model: &Model, state: &State, time: f64, steps: usize) -> State {
    let h = time / steps as f64;
    let (mut q, mut v) = (state.q.clone(), state.v.clone());
    let plus = |x: &[f64], d: &[f64], h: f64| -> Vec<f64> { x.iter().zip(d).map(|(x, d)| x + h * d).collect() };
    for _ in 0..steps {
        let a = rates(model, &q, &v);
        let b = rates(model, &plus(&q, &a.0, h / 2.0), &plus(&v, &a.1, h / 2.0));
        let c = rates(model, &plus(&q, &b.0, h / 2.0), &plus(&v, &b.1, h / 2.0));
        let d = rates(model, &plus(&q, &c.0, h), &plus(&v, &c.1, h));
        for (x, weight) in [(&a, 1.0), (&b, 2.0), (&c, 2.0), (&d, 1.0)] {
            (q, v) = (plus(&q, &x.0, h * weight / 6.0), plus(&v, &x.1, h * weight / 6.0));
        }
    }
    State::at(q, v).with_time(state.time + time)
}

#[test]
fn double_pendulum_accelerations() {
    let ([m1, m2], [l1, l2]) = ([1.3, 0.7], [0.9, 1.4]);
    let model = pendulum(&[m1, m2], &[l1, l2]);
    let mut random = Random(31);
    for _ in 0..50 {
        // Absolute angles a, b and rates u, w of the two links.
        let [a, b, u, w] = [0; 4].map(|_: i32| random.uniform(-3.0, 3.0));
        let state = State::at(vec![a, b - a], vec![u, w - u]);
        let acceleration = forward_dynamics(&model, &kinematics(&model, &state), &[0.0, 0.0]);
        let (d, total) = (a - b, m1 + m2);
        let bottom = 2.0 * m1 + m2 - m2 * (2.0 * d).cos();
        let du = (-G * (2.0 * m1 + m2) * a.sin()
            - m2 * G * (a - 2.0 * b).sin()
            - 2.0 * d.sin() * m2 * (w * w * l2 + u * u * l1 * d.cos()))
            / (l1 * bottom);
        let dw = 2.0 * d.sin() * (u * u * l1 * total + G * total * a.cos() + w * w * l2 * m2 * d.cos()) / (l2 * bottom);
        let error = relative_error(&acceleration, &[du, dw - du]);
        assert!(error < 1e-12, "{error}");
    }
}

/// Time of a quarter swing from rest at 1.2 rad to the lowest point, by the step of the engine.
fn quarter_period(model: &Model, dt: f64) -> f64 {
    let mut state = State::at(vec![1.2], vec![0.0]);
    let mut free = FreeMotion::new(model);
    loop {
        let before = state.q[0];
        step(model, &mut state, dt, &mut free);
        if state.q[0] <= 0.0 {
            return state.time - dt * state.q[0] / (state.q[0] - before);
        }
    }
}

/// The scheme is the leapfrog method with velocities half a step early, so a pendulum released from rest swings as if
/// released half a step before; what remains is the leapfrog's error of second order.
#[test]
fn pendulum_period_converges_with_second_order() {
    let length = 0.8;
    let model = pendulum(&[2.0], &[length]);
    // T/4 = √(l/g) K(sin(θ₀/2)), K by the arithmetic-geometric mean.
    let (mut a, mut b) = (1.0, (0.6_f64).cos());
    for _ in 0..8 {
        (a, b) = (0.5 * (a + b), f64::sqrt(a * b));
    }
    let exact = (length / G).sqrt() * std::f64::consts::FRAC_PI_2 / a;
    let errors = [4e-3, 2e-3, 1e-3].map(|dt| (quarter_period(&model, dt) + 0.5 * dt - exact).abs());
    assert!(errors[2] < 1e-6 * exact, "{errors:?}");
    for pair in errors.windows(2) {
        assert!((pair[0] / pair[1] - 4.0).abs() < 0.1, "{errors:?}");
    }
}

#[test]
fn free_fall_is_exact_and_leaves_spin_alone() {
    let mut model = free_body(Inertia { mass: 2.0, center_of_mass: DVec3::ZERO, rotational: DMat3::IDENTITY });
    model.gravity = DVec3::new(0.0, 0.0, -G);
    let mut state = State::new(&model);
    state.v = vec![1.0, 2.0, 3.0, 0.3, -0.5, 0.7];
    let mut free = FreeMotion::new(&model);
    step(&model, &mut state, 0.01, &mut free);
    assert_eq!(state.v, [1.0, 2.0, 3.0 - 0.01 * G, 0.3, -0.5, 0.7]);
}

/// The axis of a symmetric body without torque goes round its angular momentum L with the rate |L|/A, A the moment across.
#[test]
fn symmetric_top_precesses_about_its_angular_momentum() {
    let (across, along) = (0.4, 0.7);
    let rotational = DMat3::from_diagonal(DVec3::new(across, across, along));
    let model = free_body(Inertia { mass: 1.0, center_of_mass: DVec3::ZERO, rotational });
    let mut random = Random(33);
    let r = random.rotation();
    let state = State::at(vec![0.0, 0.0, 0.0, r.w, r.x, r.y, r.z], vec![0.0, 0.0, 0.0, 0.8, -0.5, 2.0]);
    let momentum = angular_momentum(&model, &kinematics(&model, &state), DVec3::ZERO);
    let time = 1.7;
    let end = kinematics(&model, &runge_kutta(&model, &state, time, 2000));
    let turn = rotation_exp(momentum * (time / across));
    let error = (end.rotation[1].z_axis - turn * (r * DVec3::Z)).length();
    assert!(error < 1e-11, "{error}");
}

/// The error in the energy of a fourth-order method is its own, and falls with the fourth power of the step or better.
#[test]
fn energy_is_conserved() {
    for_random_models(35, FIXED, |model, state, random| {
        let mut model = model.clone();
        for joint in model.joints.iter_mut().filter(|joint| joint.kind.nv() == 1) {
            (joint.armature, joint.stiffness) = (joint.armature + 0.1, random.uniform(0.0, 10.0));
        }
        let energy = |state: &State| {
            let at = kinematics(&model, state);
            kinetic_energy(&model, &at, &state.v) + potential_energy(&model, &at, &state.q)
        };
        let scale = 1.0 + energy(state).abs() + kinetic_energy(&model, &kinematics(&model, state), &state.v);
        let drift = |steps| (energy(&runge_kutta(&model, state, 0.2, steps)) - energy(state)).abs() / scale;
        let (coarse, fine) = (drift(100), drift(200));
        assert!(fine < 1e-7 && (fine < coarse / 10.0 || fine < 1e-12), "{coarse:e} {fine:e}");
    });
}

/// A mass without extent has weight and inertia by its distance from the hinge, and a wheel without mass the moment of its turning: `m g l cos q +
/// m l² q̈` and `I q̈`.
#[test]
fn points_have_no_moment_of_their_own_and_wheels_need_no_mass() {
    let rotational = DMat3::from_diagonal(DVec3::new(0.2, 0.3, 0.4));
    let point = |mass| Inertia { mass, center_of_mass: DVec3::ZERO, rotational: DMat3::ZERO };
    let wheel = Inertia { mass: 0.0, center_of_mass: DVec3::ZERO, rotational };
    let (length, q, acceleration): (f64, f64, f64) = (0.7, 0.4, 1.5);
    for inertia in [point(1.0), point(2.5), wheel] {
        let mut builder = ModelBuilder::new("hinged");
        let body = builder.add_body("part", BodyId::WORLD, Pose::IDENTITY, inertia).unwrap();
        let hinge =
            Joint::new("hinge", JointKind::Hinge { axis: DVec3::NEG_Y }).with_anchor(DVec3::new(-length, 0.0, 0.0));
        builder.add_joint(body, hinge).unwrap();
        let model = builder.build().unwrap();
        let at = kinematics(&model, &State::at(vec![q], vec![3.0]));
        let found = inverse_dynamics(&model, &at, &[acceleration])[0];
        let own = inertia.rotational.y_axis.y * acceleration;
        let expected = own + inertia.mass * length * (9.81 * q.cos() + length * acceleration);
        assert!((found - expected).abs() < 1e-13 * expected, "{inertia:?}: {found} instead of {expected}");
        let center = if inertia.mass > 0.0 { at.pose[1].position } else { DVec3::ZERO };
        assert!((center_of_mass(&model, &at) - center).length() < 1e-15);
    }
}
