//! The linearly implicit step without contact.

use signorini_multibody::glam::{DMat3, DVec3};
use signorini_multibody::{
    Actuator, ActuatorKind, BodyId, FreeMotion, FreeMotionError, Inertia, Input, Joint, JointId, JointKind, Model,
    ModelBuilder, Pose, Saturation, State, StateError, Tendon, Transmission, free_motion_into,
};

use crate::identities::{FIXED, bias_force, forward_dynamics, kinematics, mass_matrix, relative_error};
use crate::random_model::for_random_models;

pub fn free_motion(model: &Model, state: &State, input: &Input, dt: f64) -> FreeMotion {
    let mut free = FreeMotion::new(model);
    free_motion_into(model, &kinematics(model, state), state, input, dt, &mut free).unwrap();
    free
}

pub fn actuator(joint: usize, kind: ActuatorKind) -> Actuator {
    let name = format!("actuator{joint}");
    let transmission = Transmission::Joint(JointId(joint as u32));
    Actuator::new(name, transmission, kind)
}

/// A mass on a slide along x, without gravity.
pub fn slider(mass: f64, joint: Joint, actuators: Vec<Actuator>) -> Model {
    let mut builder = ModelBuilder::new("slider");
    builder.gravity(DVec3::ZERO);
    let inertia = Inertia { mass, center_of_mass: DVec3::ZERO, rotational: DMat3::ZERO };
    let body = builder.add_body("mass", BodyId::WORLD, Pose::IDENTITY, inertia).unwrap();
    builder.add_joint(body, joint).unwrap();
    actuators.into_iter().for_each(|a| {
        builder.add_actuator(a);
    });
    builder.build().unwrap()
}

pub fn slide() -> Joint {
    Joint::new("slide", JointKind::Slide { axis: DVec3::X })
}

#[test]
fn without_springs_it_is_forward_dynamics() {
    for_random_models(41, FIXED, |model, state, random| {
        let input = Input::default().with_generalized_force(random.list(model.nv, 10.0));
        let free = free_motion(model, state, &input, 1e-2);
        let mut force = input.generalized_force.clone();
        let inertial = inertial_force(model, state, &free.free_velocity, 1e-2);
        force.iter_mut().zip(&inertial).for_each(|(force, own)| *force += own);
        let acceleration = forward_dynamics(model, &kinematics(model, state), &force);
        let expected: Vec<f64> = state.v.iter().zip(&acceleration).map(|(v, a)| v + 1e-2 * a).collect();
        let error = relative_error(&free.free_velocity, &expected);
        assert!(error < 1e-11, "{error}");
    });
}

/// What the integrators of rotations add to the explicit step, as a force. Of bodies that turn freely: `M (v^f − v)/Δt + h` of a model without
/// springs, dampers and actuators and without applied forces. Of trees: `h` is quadratic in `v`, and its product of the velocities `v` at the
/// beginning and `end` takes the place of the square of `v`.
pub fn inertial_force(model: &Model, state: &State, end: &[f64], dt: f64) -> Vec<f64> {
    let mut bare = model.clone();
    bare.actuators.clear();
    for joint in &mut bare.joints {
        (joint.damping, joint.stiffness) = (0.0, 0.0);
    }
    let free = free_motion(&bare, state, &Input::default(), dt);
    let change: Vec<f64> = free.free_velocity.iter().zip(&state.v).map(|(a, b)| (a - b) / dt).collect();
    let mut force = vec![0.0; model.nv];
    free.mass.matrix.multiply_into(&change, &mut force);
    let bias_at = |sign: f64| {
        let v = state.v.iter().zip(end).map(|(v, end)| v + sign * (end - v)).collect();
        bias_force(model, &kinematics(model, &State::at(state.q.clone(), v)))
    };
    let (ahead, behind) = (bias_at(1.0), bias_at(-1.0));
    for (k, force) in force.iter_mut().enumerate() {
        *force = if turns_freely(model, k) { *force + free.bias[k] } else { 0.25 * (behind[k] - ahead[k]) };
    }
    force
}

/// Whether a degree of freedom is of a body on a free or ball joint that is a tree of its own.
pub fn turns_freely(model: &Model, k: usize) -> bool {
    let joint = &model.joints[model.dof_joint[k].index()];
    let last = joint.v_index + joint.kind.nv() - 1;
    let is_alone = model.dof_parent[joint.v_index].is_none() && !model.dof_parent.contains(&Some(last));
    is_alone && (joint.kind == JointKind::Ball || (joint.kind == JointKind::Free && joint.armature == 0.0))
}

/// The residual of the implicit equation: dampers and servos at the end of the step, springs at the mean of what was and what will be.
#[test]
fn the_implicit_equation_is_satisfied() {
    for_random_models(42, FIXED, |model, state, random| {
        let (mut model, dt) = (model.clone(), 5e-3);
        for i in 0..model.joints.len() {
            let joint = &mut model.joints[i];
            joint.damping = random.uniform(0.0, 5.0);
            if joint.kind.nv() > 1 {
                continue;
            }
            (joint.stiffness, joint.spring_reference) = (random.uniform(0.0, 1e4), random.uniform(-1.0, 1.0));
            let (kp, kv) = (random.uniform(0.0, 1e4), random.uniform(0.0, 100.0));
            let kind = [ActuatorKind::Motor, ActuatorKind::Position { kp, kv }, ActuatorKind::Velocity { kv }][i % 3];
            let force_range = Some([-random.uniform(0.0, 300.0), random.uniform(0.0, 300.0)]);
            model.actuators.push(actuator(i, kind).with_gear(random.uniform(-2.0, 2.0)).with_force_range(force_range));
        }
        let input = Input::default()
            .with_control(random.list(model.actuators.len(), 1.5))
            .with_generalized_force(random.list(model.nv, 10.0));
        let free = free_motion(&model, state, &input, dt);
        let at = kinematics(&model, state);
        let v = &free.free_velocity;
        let change: Vec<f64> = v.iter().zip(&state.v).map(|(a, b)| (a - b) / dt).collect();
        let mut left = vec![0.0; model.nv];
        mass_matrix(&model, &at).matrix.multiply_into(&change, &mut left);
        left.iter_mut().zip(bias_force(&model, &at)).for_each(|(l, h)| *l += h);
        let mut right = inertial_force(&model, state, v, dt);
        right.iter_mut().zip(&input.generalized_force).for_each(|(r, f)| *r += f);
        for joint in &model.joints {
            for k in joint.v_index..joint.v_index + joint.kind.nv() {
                right[k] -= joint.damping * v[k];
            }
            if joint.stiffness > 0.0 {
                let k = joint.v_index;
                let q = state.q[joint.q_index];
                let mean = ((q - dt * state.v[k]) + (q + dt * v[k])) / 2.0;
                right[k] -= joint.stiffness * (mean - joint.spring_reference);
            }
        }
        for (a, actuator) in model.actuators.iter().enumerate() {
            let Transmission::Joint(joint) = actuator.transmission else { unreachable!() };
            let joint = &model.joints[joint.index()];
            let [lower, upper] = actuator.force_range.unwrap();
            let rate = actuator.gear * v[joint.v_index];
            let length = actuator.gear * state.q[joint.q_index] + dt * rate;
            let law = match actuator.kind {
                ActuatorKind::Motor => input.control[a],
                ActuatorKind::Position { kp, kv } => kp * (input.control[a] - length) - kv * rate,
                ActuatorKind::Velocity { kv } => kv * (input.control[a] - rate),
                ActuatorKind::Affine { .. } | ActuatorKind::Speed | ActuatorKind::Muscle(_) => {
                    unreachable!("no such actuator is made")
                }
            };
            let force = free.actuator_force[a];
            assert!((lower..=upper).contains(&force));
            match free.saturation[a] {
                Saturation::Within => assert!((force - law.clamp(lower, upper)).abs() < 1e-8, "{force} {law}"),
                Saturation::Lower => assert_eq!(force, lower),
                Saturation::Upper => assert_eq!(force, upper),
            }
            right[joint.v_index] += actuator.gear * force;
        }
        let error = relative_error(&left, &right);
        assert!(error < 1e-10, "{error}");
    });
}

/// `(m + Δt c + Δt² k/2) (v⁺ − v) = −Δt (c v + k (q − q_r))`.
#[test]
fn spring_and_damper_on_a_mass() {
    let (m, k, c, dt) = (1.7, 300.0, 4.0, 0.01);
    let joint = slide().with_stiffness(k).with_spring_reference(0.25).with_damping(c);
    let model = slider(m, joint, vec![]);
    let state = State::at(vec![0.6], vec![-0.4]);
    let free = free_motion(&model, &state, &Input::default(), dt);
    let effective = m + dt * c + dt * dt * k / 2.0;
    let expected = -0.4 - dt * (c * -0.4 + k * (0.6 - 0.25)) / effective;
    assert!((free.mass.matrix.get(0, 0) - effective).abs() < 1e-15);
    assert!((free.free_velocity[0] - expected).abs() < 1e-15);
}

/// A mass on a spring without damping, from the step's least resolution to springs that the step does not resolve at all: the
/// largest swings among the last ten cycles of a hundred are those among the first ten, and none is larger than the energy of the
/// beginning allows.
#[test]
fn a_spring_keeps_its_energy() {
    for omega_dt in [0.014, 0.14, 0.3, 1.0, 1.9, 2.5, 7.0, 1e3] {
        let (m, dt) = (0.7, 2e-3);
        let stiffness = m * (omega_dt / dt) * (omega_dt / dt);
        let model = slider(m, slide().with_stiffness(stiffness).with_spring_reference(0.1), vec![]);
        let mut state = State::at(vec![0.3], vec![0.0]);
        // Every ωΔt gives s = (ωΔt)²/(1 + (ωΔt)²/2), and 2 − s is twice the cosine of the angle of a step.
        let angle = (1.0 - 0.5 * omega_dt * omega_dt / (1.0 + 0.5 * omega_dt * omega_dt)).acos();
        let cycle = std::f64::consts::TAU / angle;
        let (mut early, mut late) = (0.0f64, 0.0f64);
        for step in 0..(100.0 * cycle) as usize {
            state.v = free_motion(&model, &state, &Input::default(), dt).free_velocity;
            state.q[0] += dt * state.v[0];
            let swing = (state.q[0] - 0.1).abs();
            assert!(swing <= 0.2 * 2f64.sqrt() * (1.0 + 1e-9), "ωΔt = {omega_dt}: {swing} in step {step}");
            let part = if (step as f64) < 10.0 * cycle { &mut early } else { &mut late };
            *part = part.max(if step as f64 <= 10.0 * cycle || step as f64 >= 90.0 * cycle { swing } else { 0.0 });
        }
        assert!((late / early - 1.0).abs() < 1e-3, "ωΔt = {omega_dt}: {early} and {late}");
    }
}

/// Three masses in a row, four springs: tendons between neighbours, all on one path to the root; and a force on the last one. What the
/// scheme conserves changes by the work of the force on the mean velocity, to rounding.
#[test]
fn springs_change_their_energy_by_the_work_of_others_alone() {
    let mut builder = ModelBuilder::new("row");
    builder.gravity(DVec3::ZERO);
    let inertia = |mass: f64| Inertia { mass, center_of_mass: DVec3::ZERO, rotational: DMat3::ZERO };
    let mut parent = BodyId::WORLD;
    let mut joints = Vec::new();
    for (name, mass, stiffness) in [("a", 0.5, 400.0), ("b", 1.5, 900.0), ("c", 0.3, 5e4)] {
        parent = builder.add_body(name, parent, Pose::IDENTITY, inertia(mass)).unwrap();
        let joint =
            Joint::new(name, JointKind::Slide { axis: DVec3::X }).with_stiffness(stiffness).with_spring_reference(0.02);
        joints.push(builder.add_joint(parent, joint).unwrap());
    }
    let terms = vec![(joints[0], 1.0), (joints[2], 2.0)];
    builder.add_tendon(Tendon::new("cross", terms).with_stiffness(700.0));
    let model = builder.build().unwrap();
    let (dt, push) = (0.01, [0.0, 0.0, 3.0]);
    let potential = |q: &[f64]| {
        let along: f64 = [400.0, 900.0, 5e4].iter().zip(q).map(|(k, q)| 0.5 * k * (q - 0.02) * (q - 0.02)).sum();
        along + 0.5 * 700.0 * (q[0] + 2.0 * q[2]) * (q[0] + 2.0 * q[2])
    };
    let energy = |state: &State| {
        // The speeds in world are the partial sums of those of the joints.
        let (a, b, c) = (state.v[0], state.v[0] + state.v[1], state.v[0] + state.v[1] + state.v[2]);
        let before: Vec<f64> = state.q.iter().zip(&state.v).map(|(q, v)| q - dt * v).collect();
        0.5 * (0.5 * a * a + 1.5 * b * b + 0.3 * c * c) + 0.5 * (potential(&before) + potential(&state.q))
    };
    let mut state = State::at(vec![0.1, -0.05, 0.01], vec![0.5, 0.2, -1.0]);
    let input = Input::default().with_generalized_force(push.to_vec());
    for step in 0..1000 {
        let (before, v) = (energy(&state), state.v.clone());
        state.v = free_motion(&model, &state, &input, dt).free_velocity;
        (0..3).for_each(|k| state.q[k] += dt * state.v[k]);
        let work: f64 = (0..3).map(|k| dt * push[k] * (v[k] + state.v[k]) / 2.0).sum();
        assert!((energy(&state) - before - work).abs() < 1e-11 * before.max(1.0), "step {step}");
    }
}

/// An explicit step of this servo is unstable: Δt² kp / m = 2.5 · 10³.
#[test]
fn a_stiff_servo_settles_at_its_target() {
    let servo = actuator(0, ActuatorKind::Position { kp: 1e4, kv: 10.0 });
    let model = slider(1e-4, slide(), vec![servo]);
    let mut state = State::at(vec![0.0], vec![50.0]);
    let input = Input::default().with_control(vec![0.3]);
    for _ in 0..200 {
        state.v = free_motion(&model, &state, &input, 5e-3).free_velocity;
        state.q[0] += 5e-3 * state.v[0];
    }
    assert!((state.q[0] - 0.3).abs() < 1e-12 && state.v[0].abs() < 1e-10, "{state:?}");
}

#[test]
fn a_servo_out_of_its_range_pushes_with_the_end_of_it() {
    let servo = actuator(0, ActuatorKind::Position { kp: 1e4, kv: 10.0 })
        .with_force_range([-2.0, 3.0])
        .with_control_range([-1.0, 1.0])
        .with_gear(4.0);
    let model = slider(2.0, slide(), vec![servo]);
    let state = State::at(vec![0.1], vec![0.5]);
    let pushed = |control: f64| free_motion(&model, &state, &Input::default().with_control(vec![control]), 0.01);
    let up = pushed(5.0);
    assert_eq!((up.saturation[0], up.actuator_force[0]), (Saturation::Upper, 3.0));
    assert!((up.free_velocity[0] - (0.5 + 0.01 * 4.0 * 3.0 / 2.0)).abs() < 1e-15);
    assert_eq!(up.mass.matrix.get(0, 0), 2.0);
    let down = pushed(-5.0);
    assert_eq!((down.saturation[0], down.actuator_force[0]), (Saturation::Lower, -2.0));
    assert!((down.free_velocity[0] - (0.5 - 0.01 * 4.0 * 2.0 / 2.0)).abs() < 1e-15);
}

/// Two masses `m` on slides of their own, tied by a tendon of stiffness `k` on `q₁ − q₂`: an explicit step is unstable
/// (Δt² k / m = 250). The common motion is that of free masses, and the stretch, critically damped, dies down.
#[test]
fn a_stiff_tendon_between_two_trees_is_stable() {
    let mut builder = ModelBuilder::new("pair");
    builder.gravity(DVec3::ZERO);
    let inertia = Inertia { mass: 0.1, center_of_mass: DVec3::ZERO, rotational: DMat3::ZERO };
    let joints = ["a", "b"].map(|name| {
        let body = builder.add_body(name, BodyId::WORLD, Pose::IDENTITY, inertia).unwrap();
        builder.add_joint(body, Joint::new(name, JointKind::Slide { axis: DVec3::X })).unwrap()
    });
    let terms = vec![(joints[0], 1.0), (joints[1], -1.0)];
    builder.add_tendon(Tendon::new("tie", terms).with_stiffness(1e6).with_damping(450.0));
    let model = builder.build().unwrap();
    let (dt, mut state) = (5e-3, State::at(vec![0.01, 0.0], vec![3.0, 1.0]));
    for _ in 0..2000 {
        state.v = free_motion(&model, &state, &Input::default(), dt).free_velocity;
        (0..2).for_each(|k| state.q[k] += dt * state.v[k]);
        assert!((state.v[0] + state.v[1] - 4.0).abs() < 1e-9, "momentum: {state:?}");
    }
    assert!((state.q[0] - state.q[1]).abs() < 1e-9 && (state.v[0] - 2.0).abs() < 1e-9, "{state:?}");
}

/// What damped tendons add to the mass matrix is `Δt d ∇l ∇lᵀ` where degrees of freedom lie on one way to the root; what is between branches adds its
/// size to both diagonal entries.
#[test]
fn tendons_couple_ways_and_bound_branches() {
    for_random_models(43, FIXED, |model, state, random| {
        let mut model = model.clone();
        let dt = 5e-3;
        let straight: Vec<usize> = (0..model.joints.len()).filter(|&i| model.joints[i].kind.nv() == 1).collect();
        let mut expected = vec![0.0; model.nv * model.nv];
        for _ in 0..3 {
            let mut terms: Vec<_> = straight.iter().map(|&i| (JointId(i as u32), random.uniform(-2.0, 2.0))).collect();
            terms.retain(|_| random.below(3) > 0);
            let damping = random.uniform(0.0, 5.0);
            model.tendons.push(Tendon::new("tie", terms.clone()).with_damping(damping));
            for &(a, x) in &terms {
                for &(b, y) in &terms {
                    let [k, l] = [a, b].map(|joint| model.joints[joint.index()].v_index);
                    let entry = dt * damping * x * y;
                    let (first, second) = (k.min(l), k.max(l));
                    let is_before = std::iter::successors(Some(second), |&m| model.dof_parent[m]).any(|m| m == first);
                    expected[k * model.nv + if is_before { l } else { k }] +=
                        if is_before { entry } else { entry.abs() };
                }
            }
        }
        let rigid = mass_matrix(&model, &kinematics(&model, state)).matrix.to_dense();
        let free = free_motion(&model, state, &Input::default(), dt).mass.matrix.to_dense();
        let added: Vec<f64> = free.iter().zip(&rigid).map(|(a, b)| a - b).collect();
        let apart = added.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-12 * (1.0 + rigid.iter().fold(0.0, |a: f64, b| a.max(b.abs()))), "{apart}");
    });
}

/// The same servo as a general actuator, and one with a bias of its own: at rest `kp (u − q) + b₀ = 0`.
#[test]
fn a_stiff_affine_actuator_settles_at_its_target() {
    let kind = ActuatorKind::Affine { gain: [1e4, 0.0, 0.0], bias: [500.0, -1e4, -10.0] };
    let model = slider(1e-4, slide(), vec![actuator(0, kind)]);
    let mut state = State::at(vec![0.0], vec![50.0]);
    let input = Input::default().with_control(vec![0.3]);
    for _ in 0..200 {
        state.v = free_motion(&model, &state, &input, 5e-3).free_velocity;
        state.q[0] += 5e-3 * state.v[0];
    }
    assert!((state.q[0] - 0.35).abs() < 1e-12 && state.v[0].abs() < 1e-10, "{state:?}");
}

/// Half its weight taken away, a body falls with half of g; its centre of mass is where the force acts.
#[test]
fn gravity_compensation_takes_weight_away() {
    let mut builder = ModelBuilder::new("balloon");
    let (c, rotational) = (DVec3::new(0.1, 0.2, 0.3), DMat3::from_diagonal(DVec3::new(0.1, 0.12, 0.13)));
    let inertia = Inertia { mass: 2.0, center_of_mass: c, rotational };
    let body = builder.add_body("balloon", BodyId::WORLD, Pose::IDENTITY, inertia).unwrap();
    builder.add_joint(body, Joint::new("free", JointKind::Free)).unwrap();
    builder.set_gravity_compensation(body, 0.5).unwrap();
    let model = builder.build().unwrap();
    let free = free_motion(&model, &State::new(&model), &Input::default(), 0.01);
    for (v, expected) in free.free_velocity.iter().zip([0.0, 0.0, -0.5 * 9.81 * 0.01, 0.0, 0.0, 0.0]) {
        assert!((v - expected).abs() < 1e-15, "{:?}", free.free_velocity);
    }
}

#[test]
fn wrong_input_is_an_error_that_names_the_part() {
    let model = slider(1.0, slide(), vec![actuator(0, ActuatorKind::Motor)]);
    let at = kinematics(&model, &State::new(&model));
    let error = |state: &State, input: &Input, dt: f64| {
        free_motion_into(&model, &at, state, input, dt, &mut FreeMotion::new(&model)).unwrap_err()
    };
    let (state, input) = (State::new(&model), Input::default());
    let wrong = state.clone().with_v(vec![f64::NAN]);
    assert!(error(&wrong, &input, 0.01).to_string().starts_with("v[0] (joint 'slide') is NaN"));
    let wrong = state.clone().with_q(vec![]);
    let expected = StateError::WrongLength { quantity: "q", expected: 1, found: 0 };
    assert_eq!(error(&wrong, &input, 0.01), FreeMotionError::State(expected));
    let wrong = input.clone().with_control(vec![1.0, 2.0]);
    let expected = StateError::WrongLength { quantity: "control", expected: 1, found: 2 };
    assert_eq!(error(&state, &wrong, 0.01), FreeMotionError::State(expected));
    let wrong = input.clone().with_control(vec![f64::INFINITY]);
    assert!(error(&state, &wrong, 0.01).to_string().starts_with("control[0] (actuator 'actuator0') is inf"));
    let expected = StateError::InvalidTimeStep { found: 0.0 };
    assert_eq!(error(&state, &input, 0.0), FreeMotionError::State(expected));
}
