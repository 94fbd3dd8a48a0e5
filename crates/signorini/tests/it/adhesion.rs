//! What sticks: balances, friction and falls in closed form, sensors, recordings.

use signorini::multibody::{Input, Model, SensorKind};
use signorini::recording::{Frame, Header};
use signorini::{Recertifier, Settings, Simulation, frame_into, recording_header, step_solution_into};

const GRAVITY: f64 = 9.81;

/// A box of 2 kg under a ceiling, one on a wall, one on a plate that hangs in a hinge, with a force sensor in the plate.
const STICKY: &str = r#"<mujoco model="sticky"><option timestep="0.002"/><worldbody>
    <geom name="ceiling" type="box" size="1 1 0.1" pos="0 0 2.1"/><geom name="wall" type="box" size="0.1 1 1" pos="5.1 0 1" friction="0.5"/>
    <body name="under" pos="0 0 1.9"><freejoint/><geom name="under" type="box" size="0.1 0.1 0.1" mass="2"/></body>
    <body name="at" pos="4.9 0 1"><freejoint/><geom name="at" type="box" size="0.1 0.1 0.1" mass="2" friction="0.5"/></body>
    <body name="plate" pos="0 5 1"><joint name="swing" axis="0 1 0" pos="-0.5 0 0" damping="1"/>
      <geom name="plate" type="box" size="0.2 0.2 0.02" mass="1"/><site name="held" pos="-0.5 0 0"/></body>
    <body name="load" pos="0 5 0.88"><freejoint/><geom name="load" type="box" size="0.1 0.1 0.1" mass="0.5" friction="1"/></body>
  </worldbody>
  <actuator><adhesion name="under" body="under" ctrlrange="0 1" gain="40"/><adhesion name="at" body="at" ctrlrange="0 2" gain="30"/>
    <adhesion name="plate" body="plate" ctrlrange="0 1" gain="20"/></actuator>
  <sensor><force name="held" site="held"/><actuatorfrc name="pull" actuator="under"/><actuatorvel name="rate" actuator="under"/>
    <jointactuatorfrc name="moment" joint="swing"/></sensor></mujoco>"#;

fn model() -> Model {
    let imported = signorini_formats::load_mjcf_str(STICKY, "").unwrap();
    assert!(imported.report.warnings.is_empty(), "{}", imported.report);
    imported.model
}

fn run(control: [f64; 3], steps: usize) -> Simulation {
    let mut simulation = Simulation::new(model(), Settings::default()).unwrap();
    simulation.input = Input::default().with_control(control.to_vec());
    for _ in 0..steps {
        let report = simulation.step().unwrap();
        assert!(report.certificate.holds(1e-9) && !report.missed_tolerance);
    }
    simulation
}

/// Impulse of all contacts with a body along their normals.
fn normal_impulse(simulation: &Simulation, name: &str) -> f64 {
    let body = simulation.model().body_named(name).unwrap();
    let points = simulation.workspace().contact_points().iter().enumerate();
    let own = points.filter(|(_, point)| point.body_a == body || point.body_b == body);
    own.map(|(i, _)| simulation.workspace().contact_impulse(i)[0]).sum()
}

#[test]
fn what_sticks_bears_the_pull_less_the_load() {
    let simulation = run([0.7, 2.0, 1.0], 200);
    let dt = 0.002;
    // 28 N against 2 kg under the ceiling.
    assert!((normal_impulse(&simulation, "under") / dt - (28.0 - 2.0 * GRAVITY)).abs() < 1e-7);
    assert!(simulation.state().v[..12].iter().all(|v| v.abs() < 1e-9), "{:?}", &simulation.state().v[..12]);
    // 60 N on the wall bear 30 N of friction and 19.6 N of weight.
    assert!((normal_impulse(&simulation, "at") / dt - 60.0).abs() < 1e-7);
}

#[test]
fn too_little_lets_fall_with_what_is_left() {
    // 16 N hold nothing of 19.6 N: the first step has both, the others the weight alone, once the gap is a gap.
    let simulation = run([0.4, 1.0, 0.0], 1);
    let first = -0.002 * (GRAVITY - 16.0 / 2.0);
    assert!((simulation.state().v[2] - first).abs() < 1e-12);
    // 30 N on the wall bear 15 N of friction: it slides with the rest.
    let slides = -0.002 * (GRAVITY - 15.0 / 2.0);
    assert!((simulation.state().v[8] - slides).abs() < 1e-9, "{}", simulation.state().v[8]);
    let simulation = run([0.0, 0.0, 0.0], 100);
    assert!((simulation.state().v[2] + 0.2 * GRAVITY).abs() < 1e-9);
}

#[test]
fn sensors_feel_it() {
    let mut simulation = run([0.7, 2.0, 1.0], 600);
    let values = simulation.sensors().to_vec();
    // The hinge bears plate and load, whatever pulls between them, and the moment of the pull is that of a force of 20 N down on the plate.
    let held = values[..3].iter().map(|x| x * x).sum::<f64>().sqrt();
    assert!((values[3] - 28.0).abs() < 1e-12 && values[4].abs() < 1e-9, "{values:?}");
    let q = simulation.state().q[14];
    // 20 N along the plate's normal, at half a metre: minus the arm of the plate's middle in its own axes.
    assert!((values[5] - 10.0).abs() < 0.2, "{values:?} {q}");
    assert!(held > 0.0 && held.is_finite());
}

/// The forces of pulls in joints are what they change of the motion without contact, `M̂ Δv^f = Δt f`: also of the joints that move both of two links
/// of an arm that touch, and of several actuators that pull at one body. What actuators give by their forces and velocities the joints get.
#[test]
fn joints_feel_pulls_as_their_motion_does() {
    let text = r#"<mujoco><worldbody><body><joint axis="0 0 1"/><geom type="box" size="0.5 0.1 0.1" pos="0.5 0 0" mass="2"/>
        <body name="pad" pos="1 0 0"><joint axis="0 0 1"/><geom type="box" size="0.05 0.3 0.1" pos="0.15 0.3 0" mass="1"/>
        <body name="hand" pos="0.15 0.6 0"><joint axis="0 0 1"/><geom type="box" size="0.4 0.05 0.1" pos="-0.4 0.05 0" mass="0.5"/>
        <body name="tip" pos="-0.8 0 0"><joint axis="0 1 1"/><geom type="box" size="0.05 0.25 0.1" pos="0 -0.25 0" mass="0.5"/></body>
        </body></body></body></worldbody>
        <actuator><adhesion name="weak" body="tip" ctrlrange="0 1" gain="5"/><adhesion name="strong" body="tip" ctrlrange="0 1" gain="20"/></actuator>
        <sensor>JOINTS</sensor></mujoco>"#;
    let names = ["first", "second", "third", "fourth"];
    let mut named = text.to_string();
    names.iter().for_each(|name| named = named.replacen("<joint axis", &format!("<joint name='{name}' axis"), 1));
    let joints: String = names.iter().map(|name| format!("<jointactuatorfrc joint='{name}'/>")).collect();
    let actuators =
        ["weak", "strong"].map(|name| format!("<actuatorfrc actuator='{name}'/><actuatorvel actuator='{name}'/>"));
    let text = named.replace("JOINTS", &(joints + &actuators.concat()));
    let mut model = signorini_formats::load_mjcf_str(&text, "").unwrap().model;
    model.actuators[1].gear = 3.0;
    let v = [0.4, -0.7, 0.5, 0.3];
    let stepped = |control: [f64; 2]| {
        let mut simulation = Simulation::new(model.clone(), Settings::default()).unwrap();
        simulation.input = Input::default().with_control(control.to_vec());
        let mut state = simulation.state().clone();
        state.v = v.to_vec();
        simulation.set_state(&state).unwrap();
        simulation.step().unwrap();
        let problem = simulation.workspace().problem();
        let mut momentum = vec![0.0; problem.nv()];
        problem.mass.multiply_into(&problem.free_velocity, &mut momentum);
        (momentum, problem.timestep, simulation.sensors().to_vec())
    };
    let (without, _, _) = stepped([0.0, 0.0]);
    let (with, dt, felt) = stepped([0.8, 0.6]);
    let wanted: Vec<f64> = with.iter().zip(&without).map(|(a, b)| (a - b) / dt).collect();
    assert!(wanted.iter().filter(|force| force.abs() > 0.1).count() >= 2, "{wanted:?}: something is to touch");
    assert!(felt.iter().zip(&wanted).all(|(a, b)| (a - b).abs() < 1e-9), "{felt:?}, not {wanted:?}");
    let given = felt[4] * felt[5] + felt[6] * felt[7];
    let got: f64 = wanted.iter().zip(v).map(|(force, v)| force * v).sum();
    assert!(given.abs() > 0.1 && (given - got).abs() < 1e-9, "{given} W given, {got} W got");
}

#[test]
fn a_swinging_plate_with_its_load_moves_as_one_body() {
    let swing = |text: &str| {
        let mut simulation =
            Simulation::new(signorini_formats::load_mjcf_str(text, "").unwrap().model, Settings::default()).unwrap();
        simulation.input = Input::default().with_control(vec![1.0; simulation.model().actuators.len()]);
        (0..50).for_each(|_| _ = simulation.step().unwrap());
        let values = simulation.sensors().to_vec();
        let hinge = simulation.model().joints.iter().find(|joint| joint.name == "swing").unwrap();
        (simulation.state().q[hinge.q_index], values)
    };
    let body = r#"<mujoco><option timestep="0.001"/><worldbody><body name="plate"><joint name="swing" axis="0 1 0" pos="-0.5 0 0"/>
        <geom type="box" size="0.2 0.2 0.02" mass="1"/><site name="held" pos="-0.5 0 0"/>"#;
    let sensor = r#"<sensor><force site="held"/><torque site="held"/></sensor></mujoco>"#;
    let load = r#"<body name="load" pos="0 0 -0.12">JOINT<geom type="box" size="0.1 0.1 0.1" mass="0.5" friction="3"/></body>"#;
    let stuck = format!(
        r#"{body}</body>{}</worldbody><actuator><adhesion body="load" ctrlrange="0 1" gain="60"/></actuator>{sensor}"#,
        load.replace("JOINT", "<freejoint/>")
    );
    let welded = format!("{body}{}</body></worldbody>{sensor}", load.replace("JOINT", ""));
    let ((a, ours), (b, theirs)) = (swing(&stuck), swing(&welded));
    assert!(b > 0.01 && (a - b).abs() < 2e-5, "{a} {b}");
    for (x, y) in ours.iter().zip(&theirs) {
        assert!((x - y).abs() < 5e-3, "{ours:?} {theirs:?}");
    }
}

#[test]
fn within_the_gap_of_a_geom_it_pulls_from_afar() {
    let text = r#"<mujoco><option timestep="0.001"/><worldbody><geom type="box" size="1 1 0.1" pos="0 0 1.1"/>
        <body name="b" pos="0 0 0.895"><freejoint/><geom type="box" size="0.1 0.1 0.1" mass="1" gap="0.01"/></body></worldbody>
        <actuator><adhesion body="b" ctrlrange="0 1" gain="20"/></actuator></mujoco>"#;
    let model = signorini_formats::load_mjcf_str(text, "").unwrap().model;
    let mut simulation = Simulation::new(model, Settings::default()).unwrap();
    simulation.input = Input::default().with_control(vec![1.0]);
    simulation.step().unwrap();
    assert!((simulation.state().v[2] - 0.001 * (20.0 - GRAVITY)).abs() < 1e-12);
    (0..200).for_each(|_| _ = simulation.step().unwrap());
    assert!((simulation.state().q[2] - 0.9).abs() < 1e-9 && simulation.state().v[2].abs() < 1e-9);
    // Let go, it falls.
    simulation.input = Input::default().with_control(vec![0.0]);
    (0..10).for_each(|_| _ = simulation.step().unwrap());
    assert!((simulation.state().v[2] + 0.01 * GRAVITY).abs() < 1e-9);
}

#[test]
fn recorded_steps_are_certified_again() {
    let mut simulation = Simulation::new(model(), Settings::default()).unwrap();
    simulation.input = Input::default().with_control(vec![0.6, 1.2, 0.9]);
    let header: Header = recording_header(simulation.model(), simulation.settings(), simulation.workspace());
    let mut checker = Recertifier::new(simulation.model().clone(), &header).unwrap();
    for i in 0..100 {
        let before = simulation.state().clone();
        let report = simulation.step().unwrap().clone();
        let mut frame = Frame::default();
        frame_into(simulation.model(), i, &before, simulation.workspace(), &report, &mut frame);
        step_solution_into(&simulation.input, simulation.workspace(), &report, &mut frame);
        let check = checker.check(&frame).unwrap();
        assert!(check.holds(1e-9, 1e-9), "{check:?}");
    }
}

#[test]
fn a_file_keeps_it_and_errors_name_it() {
    let model = model();
    let written = signorini_formats::write_mjcf(&model);
    assert!(written.left_out.is_empty(), "{:?}", written.left_out);
    let again = signorini_formats::load_mjcf_str(&written.text, "").unwrap().model;
    assert_eq!(again.content_hash(), model.content_hash());
    assert!(model.sensors.iter().any(|s| matches!(s.kind, SensorKind::ActuatorVelocity(_))));
    let refused = |actuator: &str| {
        let text = STICKY.replace(r#"<adhesion name="plate" body="plate" ctrlrange="0 1" gain="20"/>"#, actuator);
        signorini_formats::load_mjcf_str(&text, "").unwrap_err().to_string()
    };
    assert!(refused("<adhesion body='plate'/>").contains("ctrlrange"));
    assert!(refused("<adhesion body='plate' ctrlrange='-1 1'/>").contains("only pull"));
    assert!(refused("<adhesion body='plat' ctrlrange='0 1'/>").contains("plate"));
}
