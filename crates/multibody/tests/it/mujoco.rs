//! The mechanism of `testdata/mujoco_reference.xml` against the numbers MuJoCo computes for it.

use signorini_multibody::glam::{DMat3, DQuat, DVec3};
use signorini_multibody::{
    Actuator, ActuatorKind, BodyId, FreeMotion, Inertia, Input, Joint, JointKind, Model, ModelBuilder, Pose, State,
    Transmission, free_motion_into, kinetic_energy, potential_energy,
};

use crate::free_motion::inertial_force;
use crate::identities::{bias_force, kinematics, mass_matrix, relative_error};

const REFERENCE: &str = include_str!("../../testdata/mujoco_reference.txt");

fn pose(position: [f64; 3], [w, x, y, z]: [f64; 4]) -> Pose {
    Pose::new(position.into(), DQuat::from_xyzw(x, y, z, w))
}

/// Inertia in the order of MJCF's `fullinertia`: xx yy zz xy xz yz.
fn inertia(center_of_mass: [f64; 3], mass: f64, [xx, yy, zz, xy, xz, yz]: [f64; 6]) -> Inertia {
    let rotational = DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]);
    Inertia { mass, center_of_mass: center_of_mass.into(), rotational }
}

fn hinge(name: &str, axis: [f64; 3], anchor: [f64; 3], reference: f64) -> Joint {
    let kind = JointKind::Hinge { axis: axis.into() };
    Joint::new(name, kind).with_anchor(anchor).with_reference(reference)
}

fn slide(name: &str, axis: [f64; 3], reference: f64) -> Joint {
    Joint::new(name, JointKind::Slide { axis: axis.into() }).with_reference(reference)
}

fn ball(name: &str, anchor: [f64; 3]) -> Joint {
    Joint::new(name, JointKind::Ball).with_anchor(anchor)
}

fn build() -> Model {
    const UNIT: [f64; 4] = [1.0, 0.0, 0.0, 0.0];
    const ORIGIN: [f64; 3] = [0.0; 3];
    let mut builder = ModelBuilder::new("reference");
    builder.gravity(DVec3::new(0.7, -1.1, -9.3));
    let mut add = |name: &str, parent: BodyId, placement: Pose, inertia: Inertia, joints: Vec<Joint>| {
        let body = builder.add_body(name, parent, placement, inertia).unwrap();
        for joint in joints {
            builder.add_joint(body, joint).unwrap();
        }
        body
    };
    let world = BodyId::WORLD;
    let torso = add(
        "torso",
        world,
        pose([0.1, 0.2, 1.3], [0.8, 0.2, -0.4, 0.4]),
        inertia([0.05, -0.1, 0.07], 5.1, [0.21, 0.32, 0.27, 0.02, -0.03, 0.01]),
        vec![Joint::new("root", JointKind::Free)],
    );
    let arm = add(
        "arm",
        torso,
        pose([0.2, 0.3, -0.1], [0.6, 0.0, 0.8, 0.0]),
        inertia([0.2, 0.05, 0.02], 1.7, [0.03, 0.05, 0.04, 0.003, 0.002, -0.004]),
        vec![
            slide("arm_slide", [0.6, 0.0, 0.8], 0.1)
                .with_armature(0.3)
                .with_stiffness(11.0)
                .with_spring_reference(0.4)
                .with_damping(0.7),
            hinge("arm_hinge", [0.0, 0.6, -0.8], [0.1, 0.05, -0.2], 0.35).with_armature(0.05).with_damping(0.2),
            hinge("arm_twist", [1.0, 0.0, 0.0], [-0.1, 0.2, 0.1], 0.0).with_stiffness(3.0).with_spring_reference(-0.2),
        ],
    );
    let hand = add(
        "hand",
        arm,
        pose([0.5, 0.1, 0.0], [0.0, 0.6, 0.0, 0.8]),
        inertia([0.0, 0.1, 0.1], 0.6, [0.005, 0.006, 0.004, 0.0, 0.0005, 0.0]),
        vec![ball("hand_ball", [0.03, 0.04, -0.02]).with_armature(0.02).with_damping(0.1)],
    );
    add(
        "tool",
        hand,
        pose([0.1, 0.2, 0.3], [0.28, 0.0, 0.0, 0.96]),
        inertia([0.02, 0.0, 0.05], 0.4, [0.002, 0.003, 0.0025, 0.0001, 0.0, 0.0]),
        vec![],
    );
    add(
        "leg",
        torso,
        pose([-0.2, -0.3, -0.4], UNIT),
        inertia([0.0, 0.0, -0.2], 2.2, [0.06, 0.07, 0.02, 0.0, 0.0, 0.005]),
        vec![
            hinge("leg_hinge", [0.0, 1.0, 0.0], [0.0, 0.0, 0.15], -0.5),
            slide("leg_slide", [0.0, 0.0, 1.0], -0.2),
            hinge("leg_swing", [0.8, 0.6, 0.0], [0.2, 0.0, 0.1], 0.25).with_armature(0.01),
        ],
    );
    let cart = add(
        "cart",
        world,
        pose([3.0, 0.0, 0.5], [0.6, 0.0, 0.0, 0.8]),
        inertia([0.1, 0.0, 0.0], 3.0, [0.1, 0.2, 0.15, 0.0, 0.0, 0.0]),
        vec![slide("cart_slide", [1.0, 0.0, 0.0], 0.4).with_stiffness(20.0).with_damping(1.5)],
    );
    let pole = add(
        "pole",
        cart,
        pose([0.0, 0.1, 0.2], [0.96, 0.0, 0.28, 0.0]),
        inertia([0.0, 0.0, 0.5], 0.8, [0.07, 0.07, 0.001, 0.0, 0.0, 0.0]),
        vec![hinge("pole_hinge", [0.0, 1.0, 0.0], ORIGIN, 0.2).with_armature(0.1)],
    );
    add(
        "bob",
        pole,
        pose([0.0, 0.0, 1.0], UNIT),
        inertia([0.03, 0.02, 0.04], 0.5, [0.002, 0.002, 0.003, 0.0, 0.0002, 0.0]),
        vec![slide("bob_slide", [0.0, 0.6, 0.8], 0.0), ball("bob_ball", [0.05, -0.05, 0.1])],
    );
    add(
        "top",
        world,
        pose([-2.0, 1.0, 0.3], UNIT),
        inertia([0.0, 0.0, 0.1], 1.1, [0.01, 0.01, 0.02, 0.0, 0.0, 0.0]),
        vec![ball("top_ball", [0.0, 0.0, -0.3])],
    );
    add(
        "box",
        world,
        pose([0.0, -4.0, 1.0], [0.5, 0.5, -0.5, 0.5]),
        inertia(ORIGIN, 2.0, [0.02, 0.03, 0.04, 0.0, 0.0, 0.0]),
        vec![Joint::new("box_free", JointKind::Free)],
    );
    let model = builder.clone().build().unwrap();
    let mut drive = |name: &str, joint: &str, kind: ActuatorKind, gear: f64, control_range: Option<[f64; 2]>| {
        let joint = model.joint_named(joint).unwrap();
        builder.add_actuator(Actuator::new(name, joint, kind).with_gear(gear).with_control_range(control_range));
    };
    drive("push", "arm_slide", ActuatorKind::Motor, 3.0, Some([-0.5, 0.5]));
    drive("hold", "leg_hinge", ActuatorKind::Position { kp: 50.0, kv: 2.0 }, -1.5, None);
    drive("turn", "pole_hinge", ActuatorKind::Velocity { kv: 4.0 }, 2.0, None);
    builder.build().unwrap()
}

/// One state of the reference file; quantities by name.
fn quantity(lines: &[(&str, Vec<f64>)], name: &str) -> Vec<f64> {
    lines.iter().find(|line| line.0 == name).unwrap_or_else(|| panic!("the reference has no {name}")).1.clone()
}

fn check_state(model: &Model, lines: &[(&str, Vec<f64>)]) {
    const TOLERANCE: f64 = 1e-13;
    let state = State::at(quantity(lines, "qpos"), quantity(lines, "qvel"));
    state.check(model).unwrap();
    let at = kinematics(model, &state);
    let positions: Vec<f64> = at.pose.iter().flat_map(|x| x.position.to_array()).collect();
    assert!(relative_error(&positions, &quantity(lines, "xpos")) < TOLERANCE);
    for (x, reference) in at.pose.iter().zip(quantity(lines, "xquat").chunks(4)) {
        let r = DQuat::from_xyzw(reference[1], reference[2], reference[3], reference[0]);
        assert!((x.rotation.dot(r).abs() - 1.0).abs() < TOLERANCE, "{:?} {reference:?}", x.rotation);
    }
    let mass = mass_matrix(model, &at).matrix.to_dense();
    assert!(relative_error(&mass, &quantity(lines, "mass")) < TOLERANCE);
    let bias = bias_force(model, &at);
    assert!(relative_error(&bias, &quantity(lines, "bias")) < TOLERANCE);
    let energy = [potential_energy(model, &at, &state.q), kinetic_energy(model, &at, &state.v)];
    assert!(relative_error(&energy, &quantity(lines, "energy")) < TOLERANCE);
    let mut force = quantity(lines, "passive");
    force.iter_mut().zip(quantity(lines, "actuator")).for_each(|(f, a)| *f += a);
    let input = Input::default().with_control(quantity(lines, "ctrl"));
    assert!(relative_error(&joint_force(model, &state, &input), &force) < 1e-10);
}

/// Forces of springs, dampers and actuators, read back from the equation of the free motion:
/// `M̂ (v^f − v) / Δt = force − h − Δt S v` with the stiffness `S` of servos, plus what freely turning bodies get.
fn joint_force(model: &Model, state: &State, input: &Input) -> Vec<f64> {
    let (dt, at) = (1e-3, kinematics(model, state));
    let mut free = FreeMotion::new(model);
    free_motion_into(model, &at, state, input, dt, &mut free).unwrap();
    let change: Vec<f64> = free.free_velocity.iter().zip(&state.v).map(|(a, b)| (a - b) / dt).collect();
    let mut force = vec![0.0; model.nv];
    free.mass.matrix.multiply_into(&change, &mut force);
    let mut stiffness = vec![0.0; model.nv];
    for actuator in &model.actuators {
        if let ActuatorKind::Position { kp, .. } = actuator.kind {
            let Transmission::Joint(joint) = actuator.transmission else { unreachable!() };
            stiffness[model.joints[joint.index()].v_index] += actuator.gear * actuator.gear * kp;
        }
    }
    let rotation = inertial_force(model, state, &free.free_velocity, dt);
    for k in 0..model.nv {
        force[k] += free.bias[k] - rotation[k] + dt * stiffness[k] * state.v[k];
    }
    force
}

#[test]
fn agrees_with_mujoco() {
    let model = build();
    let lines: Vec<(&str, Vec<f64>)> = REFERENCE
        .lines()
        .map(|line| {
            let mut words = line.split_whitespace();
            (words.next().unwrap(), words.map(|x| x.parse().unwrap()).collect())
        })
        .collect();
    let states: Vec<_> = lines.chunk_by(|_, next| next.0 != "qpos").collect();
    assert_eq!(states.len(), 6);
    states.into_iter().for_each(|state| check_state(&model, state));
}
