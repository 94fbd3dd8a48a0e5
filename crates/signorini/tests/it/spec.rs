//! Models that are edited: copies are the same model, what is attached moves as it did alone, what is removed is gone with what refers to it.

use std::path::Path;

use signorini::formats::{LoadOptions, load, load_mjcf_str};
use signorini::multibody::glam::{DQuat, DVec3};
use signorini::multibody::{
    Actuator, ActuatorKind, BodyId, EqualityKind, Geom, Geometry, Inertia, Joint, JointKind, Kinematics, MassMatrix,
    Model, Pose, Sensor, SensorKind, State, forward_kinematics_into, mass_matrix_into,
};
use signorini::spec::{Spec, SpecError, carry_state};

const ARM: &str = r#"<mujoco model="arm"><worldbody><geom name="foot" type="box" size=".1 .1 .02"/><site name="base"/>
    <body name="upper" pos="0 0 .1"><joint name="shoulder" axis="0 1 0" range="-90 90"/><geom name="upper" type="capsule" size=".04 .2" pos="0 0 .2"/>
      <body name="lower" pos="0 0 .4"><joint name="elbow" axis="0 1 0" damping=".2"/><geom name="lower" size=".05"/><site name="tip" pos="0 0 .1"/></body></body>
  </worldbody><contact><exclude body1="upper" body2="world"/></contact>
  <tendon><fixed name="sum"><joint joint="shoulder" coef="1"/><joint joint="elbow" coef="1"/></fixed></tendon>
  <equality><connect name="held" body1="lower" anchor="0 0 .1" active="true"/></equality>
  <actuator><position name="servo" joint="elbow" kp="20"/><motor name="pull" tendon="sum"/></actuator>
  <sensor><framepos name="where" objtype="site" objname="tip"/><actuatorfrc name="effort" actuator="servo"/></sensor>
  <keyframe><key name="bent" qpos=".3 -.7" ctrl=".1 .2"/></keyframe></mujoco>"#;

fn arm() -> Spec {
    Spec::from_model(&load_mjcf_str(ARM, ".").expect("an arm").model)
}

fn mass_matrix(model: &Model, q: &[f64]) -> Vec<f64> {
    let mut kinematics = Kinematics::new(model);
    forward_kinematics_into(model, q, &vec![0.0; model.nv], &mut kinematics);
    let mut mass = MassMatrix::new(model);
    mass_matrix_into(model, &kinematics, &mut mass);
    mass.matrix.to_dense()
}

#[test]
fn a_copy_of_a_model_is_the_model() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    for entry in std::fs::read_dir(folder).expect("the scenes") {
        let path = entry.expect("a file").path();
        if path.extension().is_some_and(|extension| extension == "xml") {
            let model = load(&path, &LoadOptions::default()).expect("a scene").model;
            let compiled = Spec::from_model(&model).compile().expect("a scene is a model");
            assert_eq!(compiled.model.content_hash(), model.content_hash(), "{}", path.display());
        }
    }
    let model = load_mjcf_str(ARM, ".").expect("an arm").model;
    let compiled = arm().compile().expect("an arm");
    assert_eq!(compiled.model.content_hash(), model.content_hash());
    assert!(compiled.joints.iter().enumerate().all(|(i, id)| id.map(|id| id.index()) == Some(i)));
}

/// Two arms that do not touch have the mass matrices of one, side by side.
#[test]
fn what_is_attached_moves_as_it_did_alone() {
    let mut spec = Spec::new("two");
    spec.attach(&arm(), "world", Pose::IDENTITY, "a/").expect("the first");
    let turned = Pose::new(DVec3::new(1.0, 0.0, 0.2), DQuat::from_rotation_z(0.8));
    spec.attach(&arm(), "world", turned, "b/").expect("the second");
    let two = spec.compile().expect("two arms").model;
    let one = arm().compile().expect("one arm").model;
    let (q, own) = ([0.3, -0.7], mass_matrix(&one, &[0.3, -0.7]));
    let whole = mass_matrix(&two, &[q, q].concat());
    for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
        let expected = if i / 2 == j / 2 { own[2 * (i % 2) + j % 2] } else { 0.0 };
        assert!((whole[4 * i + j] - expected).abs() < 1e-13, "({i}, {j})");
    }
    assert_eq!((two.actuators.len(), two.sensors.len(), two.tendons.len(), two.equalities.len()), (4, 4, 2, 2));
    let bent = two.keyframe_named("b/bent").expect("a keyframe came along");
    assert_eq!((&bent.q[..], &bent.control[..]), (&[0.0, 0.0, 0.3, -0.7][..], &[0.0, 0.0, 0.1, 0.2][..]));
    let foot = &two.geoms[two.geom_named("b/foot").expect("what was fixed to the world").index()];
    assert!((foot.placement.position - turned.position).length() < 1e-15);
    let twice = spec.attach(&arm(), "world", Pose::IDENTITY, "a/").expect_err("the names are taken");
    assert!(twice.to_string().contains("'a/upper' already"), "{twice}");
    assert_eq!(spec.compile().expect("nothing has changed").model.content_hash(), two.content_hash());
}

#[test]
fn a_gripper_is_attached_to_a_hand_and_a_floating_body_is_not() {
    let mut spec = arm();
    spec.remove_equality("held").expect("it is there");
    let mut gripper = Spec::new("gripper");
    gripper.add_body("palm", "world", Pose::IDENTITY, Inertia::ZERO).expect("a palm");
    gripper.add_solid("palm", Geom::new("palm", Geometry::Sphere { radius: 0.03 }), 0.2).expect("its shape");
    gripper.add_body("finger", "palm", [0.03, 0.0, 0.03].into(), Inertia::ZERO).expect("a finger");
    gripper.add_solid("finger", Geom::new("finger", Geometry::Sphere { radius: 0.01 }), 0.05).expect("its shape");
    gripper.add_joint("finger", Joint::slide("grip", DVec3::X).with_limits([0.0, 0.02])).expect("its joint");
    let before = spec.compile().expect("an arm").model;
    spec.attach(&gripper, "lower", [0.0, 0.0, 0.15].into(), "").expect("a gripper at the hand");
    let grip = spec.joint("grip").expect("it is there");
    spec.add_actuator(Actuator::new("grip", grip, ActuatorKind::Motor)).expect("its motor");
    spec.add_sensor(Sensor::new("opening", SensorKind::JointPosition(grip))).expect("its sensor");
    let compiled = spec.compile().expect("an arm with a gripper");
    let model = &compiled.model;
    assert_eq!((model.nv, model.bodies[4].parent.index(), model.dof_parent[2]), (3, 3, Some(1)));
    assert_eq!(compiled.joints[grip.index()].map(|id| id.index()), Some(2));

    let state = State::at(vec![0.4, 0.5], vec![1.0, 2.0]).with_time(3.0);
    let carried = carry_state(&before, &state, model);
    assert_eq!((carried.time, &carried.q[..], &carried.v[..]), (3.0, &[0.4, 0.5, 0.0][..], &[1.0, 2.0, 0.0][..]));

    let mut ball = Spec::new("ball");
    ball.add_body("ball", "world", Pose::IDENTITY, Inertia::ZERO).expect("a ball");
    ball.add_joint("ball", Joint::new("free", JointKind::Free)).expect("its joint");
    let refused = spec.attach(&ball, "lower", Pose::IDENTITY, "").expect_err("it floats");
    assert_eq!(refused, SpecError::FreeJoint { body: "ball".into() });
}

const HELD: &str = r#"<mujoco><worldbody>
    <body name="a" pos="0 0 1"><freejoint/><geom size=".1" mass="1"/></body>
    <body name="b" pos="1 0 1"><joint name="turn" type="ball"/><geom size=".1" mass="1"/></body>
    <body name="hand" pos="0 1 1" mocap="true"/>
  </worldbody>
  <equality><weld name="weld" body1="a"/><connect name="connect" body1="b" anchor="0 0 .2"/></equality>
  <keyframe><key name="k" qpos="0 0 2 .6 0 .8 0 .6 .8 0 0" qvel="1 2 3 4 5 6 7 8 9" mpos="1 2 3" mquat=".6 0 0 .8"/></keyframe></mujoco>"#;

/// What a model says in world axes is said in those of the place where it was put: its constraints hold there, and its keyframe's bodies are,
/// as seen from there, where they were.
#[test]
fn anchors_in_the_world_and_keyframes_move_with_what_is_attached() {
    let alone = load_mjcf_str(HELD, ".").expect("what is held").model;
    let frame = Pose::new(DVec3::new(5.0, -1.0, 0.3), DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 0.9));
    let mut spec = Spec::new("one");
    spec.attach(&Spec::from_model(&alone), "world", frame, "x/").expect("the world takes it");
    let model = spec.compile().expect("a model").model;

    let kinematics = |model: &Model, q: &[f64]| {
        let mut kinematics = Kinematics::new(model);
        forward_kinematics_into(model, q, &vec![0.0; model.nv], &mut kinematics);
        kinematics
    };
    let reference = kinematics(&model, &model.reference_configuration());
    let of = |id: BodyId| reference.pose[id.index()];
    for equality in &model.equalities {
        let off = match equality.kind {
            EqualityKind::Connect { body_a, point_a, body_b, point_b } => {
                of(body_a).transform_point(point_a) - of(body_b).transform_point(point_b)
            }
            EqualityKind::Weld { body_a, frame_a, body_b, frame_b } => {
                let off = (of(body_a) * frame_a).inverse() * (of(body_b) * frame_b);
                off.position + off.rotation.xyz()
            }
            _ => panic!("{} is neither", equality.name),
        };
        assert!(off.length() < 1e-14, "{}: {off}", equality.name);
    }

    let (before, after) = (&alone.keyframes[0], model.keyframe_named("x/k").expect("its keyframe"));
    let [old, new] = [(&alone, before), (&model, after)].map(|(model, key)| kinematics(model, &key.q));
    for body in 1..3 {
        let expected = frame * old.pose[body];
        assert!((new.pose[body].position - expected.position).length() < 1e-14, "{}", model.bodies[body].name);
        assert!(new.pose[body].rotation.dot(expected.rotation).abs() > 1.0 - 1e-14, "{}", model.bodies[body].name);
    }
    let linear = frame.rotation * DVec3::new(1.0, 2.0, 3.0);
    assert!((DVec3::from_slice(&after.v) - linear).length() < 1e-14);
    assert_eq!(after.v[3..], before.v[3..], "in axes of bodies");
    let hand = frame * before.mocap[0];
    assert!((after.mocap[0].position - hand.position).length() < 1e-14);
    assert!(after.mocap[0].rotation.dot(hand.rotation).abs() > 1.0 - 1e-14);

    // At a body of another model, too, what was held in the world is held by it.
    let mut spec = arm();
    let mut held = Spec::from_model(&alone);
    held.remove_body("a").expect("it floats");
    held.remove_body("hand").expect("it is moved from outside");
    spec.attach(&held, "lower", frame, "x/").expect("an arm takes it");
    spec.compile().expect("its points are together");
}

#[test]
fn what_is_removed_takes_what_refers_to_it_along() {
    let mut spec = arm();
    let removed = spec.remove_body("lower").expect("it is there");
    let expected = [
        "body 'lower'",
        "joint 'elbow'",
        "geom 'lower'",
        "site 'tip'",
        "tendon 'sum'",
        "actuator 'servo'",
        "actuator 'pull'",
        "sensor 'where'",
        "sensor 'effort'",
        "equality constraint 'held'",
    ];
    assert_eq!(removed, expected);
    let model = spec.compile().expect("half an arm").model;
    let key = model.keyframe_named("bent").expect("the rest of it");
    assert_eq!((model.nv, &key.q[..], key.control.len()), (1, &[0.3][..], 0));
    assert_eq!(spec.remove_body("world"), Err(SpecError::World { what: "removed" }));
    let missing = spec.joint_mut("shouldr").expect_err("misspelt");
    assert!(missing.to_string().contains("no joint 'shouldr'; did you mean 'shoulder'?"), "{missing}");
}

#[test]
fn what_is_no_mechanism_is_refused_by_name() {
    let mut spec = arm();
    let lower = spec.body("lower").expect("it is there");
    spec.body_mut("upper").expect("it is there").parent = lower;
    assert!(matches!(spec.compile(), Err(SpecError::Circle { body }) if body == "upper"));
    let mut spec = arm();
    spec.body_mut("upper").expect("it is there").inertia.mass = -1.0;
    assert!(spec.compile().expect_err("no mass is negative").to_string().contains("body 'upper'"));
    let mut spec = arm();
    spec.actuator_mut("servo").expect("it is there").transmission = signorini::multibody::JointId(99).into();
    let dangling = spec.compile().expect_err("there is no such joint");
    assert_eq!(dangling.to_string(), "actuator 'servo' refers to a joint that is not there");
}

/// A part that is taken over refers to the parts that have the names here.
#[test]
fn adopted_parts_refer_by_name() {
    let mut spec = Spec::new("two");
    spec.attach(&arm(), "world", Pose::IDENTITY, "a/").expect("an arm");
    let mut bare = arm();
    for (removal, name) in [("tendon", "sum"), ("actuator", "servo")] {
        let removed = if removal == "tendon" { bare.remove_tendon(name) } else { bare.remove_actuator(name) };
        removed.expect("a part");
    }
    spec.attach(&bare, "world", [1.0, 0.0, 0.0].into(), "").expect("a second arm");
    spec.adopt_tendon(&arm(), "sum").expect("a tendon");
    spec.adopt_actuator(&arm(), "servo").expect("a servo");
    spec.adopt_sensor(&arm(), "effort").expect("a sensor");
    let model = spec.compile().expect("two arms").model;
    let elbow = model.joint_named("elbow").expect("the second elbow");
    let servo = &model.actuators[model.actuator_named("servo").expect("a servo").index()];
    assert_eq!(servo.transmission, signorini::multibody::Transmission::Joint(elbow));
    let sum = &model.tendons[model.tendon_named("sum").expect("a tendon").index()];
    assert!(sum.terms.iter().any(|(joint, _)| *joint == elbow));
    let error = spec.adopt_sensor(&arm(), "effort").expect_err("there is one already").to_string();
    assert!(error.contains("effort"), "{error}");
    let error = Spec::new("empty").adopt_actuator(&arm(), "servo").expect_err("nothing to drive").to_string();
    assert!(error.contains("servo") && error.contains("joint"), "{error}");
}
