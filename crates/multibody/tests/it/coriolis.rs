//! Coriolis forces of trees: the motion is the same read backwards, of second order, and keeps its energy.

use signorini_multibody::glam::DVec3;
use signorini_multibody::{
    BodyId, FreeMotion, Inertia, Input, Joint, JointKind, Model, ModelBuilder, Pose, State, free_motion_into,
    integrate_into, kinetic_energy, potential_energy,
};

use crate::free_motion::turns_freely;
use crate::identities::{forward_dynamics, kinematics};
use crate::random_model::{Recipe, for_random_models};

fn end_of_step(model: &Model, state: &State, dt: f64) -> Vec<f64> {
    let mut motion = FreeMotion::new(model);
    free_motion_into(model, &kinematics(model, state), state, &Input::default(), dt, &mut motion).unwrap();
    assert_eq!(motion.unresolved_rotations, 0);
    motion.free_velocity
}

fn step(model: &Model, state: &mut State, dt: f64) {
    state.v = end_of_step(model, state, dt);
    let q = state.q.clone();
    integrate_into(model, &q, &state.v, dt, &mut state.q);
}

/// Rods of 1 kg and 0.3 m on a string of hinges, level at the beginning; their axes are turned against each other by `twist` radians each.
fn rods(n: usize, twist: f64) -> Model {
    let mut builder = ModelBuilder::new("rods");
    add_rods(&mut builder, "", n, twist);
    builder.build().unwrap()
}

fn add_rods(builder: &mut ModelBuilder, name: &str, n: usize, twist: f64) {
    let mut parent = BodyId::WORLD;
    for i in 0..n {
        let rotational = signorini_multibody::glam::DMat3::from_diagonal(DVec3::new(1e-4, 0.0075, 0.0075));
        let inertia = Inertia { mass: 1.0, center_of_mass: DVec3::X * 0.15, rotational };
        let placement = Pose::from_position(if i == 0 { DVec3::ZERO } else { DVec3::X * 0.3 });
        parent = builder.add_body(format!("{name}rod{i}"), parent, placement, inertia).unwrap();
        let axis = DVec3::new(0.0, (twist * i as f64).cos(), (twist * i as f64).sin());
        builder.add_joint(parent, Joint::new(format!("{name}hinge{i}"), JointKind::Hinge { axis })).unwrap();
    }
}

#[test]
fn a_step_is_the_same_read_backwards() {
    for (seed, floating, armature) in [(1, false, true), (2, true, false), (3, true, true)] {
        for_random_models(seed, Recipe { bodies: 6, floating, armature }, |model, state, _| {
            let end = end_of_step(model, state, 0.02);
            let turned = State::at(state.q.clone(), end.iter().map(|v| -v).collect());
            let begin = end_of_step(model, &turned, 0.02);
            let size = end.iter().chain(&state.v).fold(1.0_f64, |m, v| m.max(v.abs()));
            for (k, (v, begin)) in state.v.iter().zip(&begin).enumerate().filter(|(k, _)| !turns_freely(model, *k)) {
                assert!((v + begin).abs() < 1e-9 * size, "dof {k}: {v} against {begin} of {size}");
            }
        });
    }
}

/// With forces of the beginning of the step alone the first of them loses two fifths of what gravity can do with it in 20 s, and the second one's
/// energy grows beyond all bounds in 7 s.
#[test]
fn chaotic_pendulums_keep_their_energy() {
    for (n, twist, dt) in [(2, 0.0, 0.005), (2, 0.0, 0.02), (3, 0.0, 0.005), (3, 0.7, 0.01), (5, 0.3, 0.005)] {
        let model = rods(n, twist);
        let mut state = State::new(&model);
        // What gravity can do with them.
        let scale = 9.81 * 0.3 * (n * n) as f64;
        let mut all = Vec::new();
        for _ in 0..(20.0 / dt) as usize {
            step(&model, &mut state, dt);
            let at = kinematics(&model, &state);
            let energy = kinetic_energy(&model, &at, &state.v) + potential_energy(&model, &at, &state.q);
            all.push(energy / scale);
        }
        let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
        let quarter = all.len() / 4;
        let drift = mean(&all[3 * quarter..]) - mean(&all[..quarter]);
        let most = all.iter().fold(0.0_f64, |most, energy| most.max(energy.abs()));
        println!("{n} rods, twist {twist}, step {dt}: drift {drift:.4}, most {most:.3}");
        assert!(drift.abs() < 0.15 && most < 0.6, "{n} rods, step {dt}: drift {drift}, most {most}");
    }
}

/// Against Runge–Kutta's method on the forward dynamics. The velocity of a state is the mean of the step to it.
#[test]
fn trees_converge_with_the_square_of_the_step() {
    let model = rods(3, 0.7);
    let acceleration = |state: &State| forward_dynamics(&model, &kinematics(&model, state), &[0.0; 3]);
    let start = State::at(vec![0.3, -0.2, 0.4], vec![0.5, 1.0, -2.0]);
    let moved = |state: &State, [v, a]: [&[f64]; 2], dt: f64| {
        let along = |x: &[f64], rate: &[f64]| x.iter().zip(rate).map(|(x, rate)| x + dt * rate).collect();
        State::at(along(&state.q, v), along(&state.v, a))
    };
    let mut exact = start.clone();
    let dt = 1e-3;
    for _ in 0..400 {
        let first = acceleration(&exact);
        let second = moved(&exact, [&exact.v, &first], 0.5 * dt);
        let third = moved(&exact, [&second.v, &acceleration(&second)], 0.5 * dt);
        let fourth = moved(&exact, [&third.v, &acceleration(&third)], dt);
        let of = [&first, &acceleration(&second), &acceleration(&third), &acceleration(&fourth)];
        let mean = |of: [&[f64]; 4]| -> Vec<f64> {
            (0..3).map(|k| (of[0][k] + 2.0 * of[1][k] + 2.0 * of[2][k] + of[3][k]) / 6.0).collect()
        };
        let (v, a) = (mean([&exact.v, &second.v, &third.v, &fourth.v]), mean(of.map(|a| &a[..])));
        exact = moved(&exact, [&v, &a], dt);
    }
    let error = |steps: usize| {
        let dt = 0.4 / steps as f64;
        let mut state = start.clone();
        state.v = moved(&start, [&start.v, &acceleration(&start)], -0.5 * dt).v;
        (0..steps).for_each(|_| step(&model, &mut state, dt));
        state.q.iter().zip(&exact.q).fold(0.0_f64, |most, (q, exact)| most.max((q - exact).abs()))
    };
    let (coarse, fine) = (error(100), error(200));
    assert!(coarse < 1e-3 && (3.7..4.3).contains(&(coarse / fine)), "{coarse:e}, {fine:e}");
}

/// A tree that turns by many radians in the step is counted, and moves as it would from rest: its velocity gains what gravity gives. A slower one
/// beside it moves as it does alone.
#[test]
fn trees_too_fast_for_the_step_feel_no_coriolis_forces() {
    let mut builder = ModelBuilder::new("two");
    add_rods(&mut builder, "slow ", 2, 0.3);
    add_rods(&mut builder, "fast ", 4, 0.7);
    let model = builder.build().unwrap();
    let (q, dt) = ([0.3, -0.8, 0.3, -0.8, 0.4, 1.1], 0.01);
    let state = State::at(q.to_vec(), vec![2.0, -3.0, -300.0, 700.0, 200.0, -500.0]);
    let mut motion = FreeMotion::new(&model);
    free_motion_into(&model, &kinematics(&model, &state), &state, &Input::default(), dt, &mut motion).unwrap();
    assert_eq!(motion.unresolved_rotations, 1);
    let rest = kinematics(&model, &State::at(q.to_vec(), vec![0.0; 6]));
    let falling = forward_dynamics(&model, &rest, &[0.0; 6]);
    for k in 2..6 {
        let (found, expected) = (motion.free_velocity[k] - state.v[k], dt * falling[k]);
        assert!((found - expected).abs() < 1e-9, "dof {k}: {found} instead of {expected}");
    }
    let alone = end_of_step(&rods(2, 0.3), &State::at(q[..2].to_vec(), state.v[..2].to_vec()), dt);
    assert!(alone.iter().zip(&motion.free_velocity).all(|(a, b)| (a - b).abs() < 1e-13));
}
