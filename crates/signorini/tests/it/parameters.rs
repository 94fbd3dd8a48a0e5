//! Parameters changed in a run: the bits of a model that was compiled with them, recordings that can be checked, errors that name the part.

use std::io::Cursor;

use signorini::multibody::{Effect, Model, Parameter, ParameterChange};
use signorini::recording::{Frame, Header, Reader, Recording, Writer};
use signorini::spec::Spec;
use signorini::{
    Batch, Recertifier, RunRecorder, Settings, Simulation, SimulationError, Snapshot, Variation, recorded_model,
    recording_header,
};

use crate::support::bundled;

/// Joints with springs, limits and dry friction, servos of all sorts, a tendon, a pair with its own friction, a belt, sites, shapes of all sorts.
const WORKSHOP: &str = r#"<mujoco model="workshop">
  <option timestep="0.004"/>
  <asset><mesh name="wedge" vertex="0 0 0 0.2 0 0 0 0.2 0 0.2 0.2 0 0 0 0.1 0 0.2 0.1"/></asset>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 1"/>
    <body name="arm" pos="0 0 0.6">
      <joint name="shoulder" axis="0 1 0" range="-70 40" damping="0.2" stiffness="1.5" springref="10" frictionloss="0.02" armature="0.01"/>
      <geom name="upper" type="capsule" fromto="0 0 0 0.4 0 0" size="0.03" mass="0.7"/>
      <body name="hand" pos="0.4 0 0">
        <joint name="elbow" axis="0 1 0" damping="0.1"/>
        <geom name="lower" type="cylinder" fromto="0 0 0 0.3 0 0" size="0.02" mass="0.3"/>
        <site name="tip" pos="0.3 0 0"/>
      </body>
    </body>
    <body name="box" pos="0.5 0 0.11"><freejoint/><geom name="crate" type="box" size="0.1 0.08 0.1" mass="1.2" condim="4"/></body>
    <body name="ball" pos="-0.5 0 0.2"><freejoint/><geom name="ball" size="0.08" mass="0.4" condim="6" friction="0.6 0.01 0.001"/></body>
    <body name="egg" pos="-0.9 0.3 0.2"><freejoint/><geom name="egg" type="ellipsoid" size="0.1 0.06 0.05" mass="0.3"/></body>
    <body name="wedge" pos="-0.2 0.6 0.2"><freejoint/><geom name="wedge" type="mesh" mesh="wedge" mass="0.5"/></body>
  </worldbody>
  <contact><pair geom1="crate" geom2="floor" friction="0.4 0.4 0.01 0.001 0.001"/></contact>
  <tendon><fixed name="cord" stiffness="3" damping="0.4" springlength="0.1 0.2" limited="true" range="-2 2">
    <joint joint="shoulder" coef="1"/><joint joint="elbow" coef="-0.5"/></fixed></tendon>
  <actuator>
    <position name="servo" joint="shoulder" kp="12" kv="1" ctrlrange="-1 1" forcerange="-9 9"/>
    <velocity name="spin" joint="elbow" kv="0.3"/>
    <general name="pull" tendon="cord" gainprm="0.5" biasprm="0.1 -0.2 -0.1" biastype="affine" gear="1.5"/>
  </actuator>
  <sensor><force site="tip"/><jointpos joint="elbow"/><accelerometer site="tip"/></sensor>
</mujoco>"#;

fn workshop() -> Model {
    signorini_formats::load_mjcf_str(WORKSHOP, "").unwrap().model
}

/// A number in [−1, 1] that follows from its arguments.
fn noise(seed: u64, k: usize) -> f64 {
    let mixed =
        (seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (k as u64).wrapping_mul(0xbf58_476d_1ce4_e5b9)).rotate_left(31);
    (mixed.wrapping_mul(0x94d0_49bb_1331_11eb) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

/// Other values that every part that has the parameter can take.
fn other_values(model: &Model, parameter: Parameter, seed: u64) -> Vec<f64> {
    let (mut values, width) = (model.parameter(parameter), parameter.width());
    for (k, x) in values.iter_mut().enumerate() {
        let noise = noise(seed, k + 1000 * (parameter as usize));
        // The world and what a shape or an actuator has not are zeros that must stay.
        *x = match parameter {
            Parameter::GeomPosition | Parameter::SitePosition | Parameter::JointAnchor => *x + 0.01 * noise,
            Parameter::BodyPosition | Parameter::BodyCenter if k >= width => *x + 0.01 * noise,
            Parameter::GeomRotation | Parameter::SiteRotation => *x + 0.05 * noise,
            Parameter::BodyRotation if k >= width => *x + 0.05 * noise,
            Parameter::BodyRotation => *x,
            Parameter::JointSpringReference => *x + 0.1 * noise,
            Parameter::GeomRestitution | Parameter::GeomMargin => 0.01 * noise.abs(),
            Parameter::GeomSurfaceVelocity => 0.1 * noise,
            Parameter::BodyGravityCompensation if k >= width => 0.1 * noise,
            Parameter::BodyInertia => *x * 1.1,
            Parameter::ActuatorForceRange | Parameter::TendonRest => *x * 1.05,
            _ => *x * (1.0 + 0.2 * noise),
        };
    }
    values
}

fn compiled_with(model: &Model, changes: &[ParameterChange<'_>]) -> Model {
    // Everything that a model has besides these numbers is derived anew by the builder.
    Spec::from_model(&model.with_parameters(changes).unwrap()).compile().unwrap().model
}

fn drive(simulation: &mut Simulation) {
    let nu = simulation.model().actuators.len();
    simulation.input.control = (0..nu).map(|a| 0.3 - 0.2 * a as f64).collect();
}

/// Half of a run with the model's own numbers, then with others: the same bits as a new simulation of a model that was compiled with these.
fn goes_on_as_compiled(model: &Model, changes: &[ParameterChange<'_>], steps: u64, what: &str) {
    let settings = Settings::default();
    let mut run = Simulation::new(model.clone(), settings.clone()).unwrap();
    drive(&mut run);
    for _ in 0..steps {
        run.step().unwrap();
    }
    run.change(changes).unwrap_or_else(|error| panic!("{what}: {error}"));
    let compiled = compiled_with(model, changes);
    assert_eq!(run.model().content_hash(), compiled.content_hash(), "{what}: the model");
    let mut fresh = Simulation::new(compiled, settings).unwrap();
    fresh.set_state(run.state()).unwrap();
    fresh.input.clone_from(&run.input);
    fresh.set_warm_start(&run.workspace().warm_start()).unwrap();
    for step in 0..steps {
        let (a, b) = (run.step().unwrap().clone(), fresh.step().unwrap().clone());
        assert_eq!((a.contacts, a.status.clone()), (b.contacts, b.status.clone()), "{what}: step {step}");
        assert_eq!((&run.state().q, &run.state().v), (&fresh.state().q, &fresh.state().v), "{what}: step {step}");
        assert_eq!(run.sensors(), fresh.sensors(), "{what}: step {step}");
    }
}

#[test]
fn every_parameter_acts_as_if_compiled() {
    let model = workshop();
    for &parameter in Parameter::ALL {
        let values = other_values(&model, parameter, 7);
        assert_ne!(values, model.parameter(parameter), "{}", parameter.name());
        goes_on_as_compiled(&model, &[(parameter, &values)], 40, parameter.name());
    }
}

#[test]
fn all_parameters_of_bundled_scenes_at_once() {
    for (scene, seed) in [("quadruped", 1), ("gripper", 2), ("wall", 3), ("arch", 4)] {
        let model = bundled(scene).model().clone();
        let kept = |parameter: &&Parameter| {
            // Servos whose gains the scene has not, and poses that would make neighbours overlap.
            let values = other_values(&model, **parameter, seed);
            parameter.effect() == Effect::Values && model.with_parameters(&[(**parameter, &values)]).is_ok()
        };
        let parameters: Vec<Parameter> = Parameter::ALL.iter().filter(kept).copied().collect();
        assert!(parameters.len() > 15, "{scene}");
        let values: Vec<Vec<f64>> = parameters.iter().map(|p| other_values(&model, *p, seed)).collect();
        let changes: Vec<ParameterChange<'_>> = parameters.iter().zip(&values).map(|(p, v)| (*p, &v[..])).collect();
        goes_on_as_compiled(&model, &changes, 30, scene);
    }
}

#[test]
fn a_file_with_these_numbers_is_the_same_model() {
    let edits = [
        ("mass=\"1.2\"", "mass=\"2.5\"", Parameter::BodyMass, 3, 0, 2.5),
        ("damping=\"0.2\"", "damping=\"0.7\"", Parameter::JointDamping, 0, 0, 0.7),
        ("stiffness=\"1.5\"", "stiffness=\"4.5\"", Parameter::JointStiffness, 0, 0, 4.5),
        ("size=\"0.08\"", "size=\"0.07\"", Parameter::GeomSize, 4, 0, 0.07),
        ("kp=\"12\"", "kp=\"20\"", Parameter::ActuatorStiffness, 0, 0, 20.0),
        ("friction=\"0.4 0.4", "friction=\"0.9 0.9", Parameter::PairFriction, 0, 0, 0.9),
    ];
    let model = workshop();
    for (old, new, parameter, row, column, value) in edits {
        let edited = signorini_formats::load_mjcf_str(&WORKSHOP.replace(old, new), "").unwrap().model;
        let mut values = model.parameter(parameter);
        values[row * parameter.width() + column] = value;
        let changed = model.with_parameters(&[(parameter, &values)]).unwrap();
        let same = edited.parameter(parameter);
        let close = |(a, b): (&f64, &f64)| a == b || (a - b).abs() < 1e-15;
        assert!(changed.parameter(parameter).iter().zip(&same).all(close), "{}", parameter.name());
    }
}

#[test]
fn a_sleeping_scene_wakes_up() {
    let model = bundled("stack_of_ten").model().clone();
    let mut run = Simulation::new(model.clone(), Settings::default()).unwrap();
    for _ in 0..200 {
        run.step().unwrap();
    }
    run.change(&[(Parameter::Gravity, &[3.0, 0.0, -9.81])]).unwrap();
    for _ in 0..50 {
        run.step().unwrap();
    }
    assert!(run.state().v.iter().any(|v| v.abs() > 0.01), "a slope lets the stack move");
    let before = run.state().clone();
    run.change(&[]).unwrap();
    run.change(&[(Parameter::Gravity, &[3.0, 0.0, -9.81])]).unwrap();
    assert_eq!(run.state(), &before);
}

/// A run of a changed model as a recording in memory.
fn recorded(simulation: &mut Simulation, steps: u64) -> (Header, Vec<Frame>) {
    let header = recording_header(simulation.model(), simulation.settings(), simulation.workspace());
    let mut recorder = RunRecorder::new(Writer::new(Vec::new(), header).unwrap());
    for _ in 0..steps {
        simulation.step().unwrap();
        recorder.add(simulation).unwrap();
    }
    let bytes = recorder.finish(simulation, "done").unwrap();
    let recording = Recording::from_reader(&mut Reader::new("memory", Cursor::new(bytes)).unwrap()).unwrap();
    (recording.header().clone(), recording.frames().to_vec())
}

#[test]
fn a_recording_with_changed_parameters_is_certified_from_the_file() {
    let model = workshop();
    let mut run = Simulation::new(model.clone(), Settings::default()).unwrap();
    drive(&mut run);
    let parameters = [Parameter::BodyMass, Parameter::GeomFriction, Parameter::GeomSize, Parameter::ActuatorForceRange];
    for parameter in parameters {
        let values = other_values(&model, parameter, 11);
        run.change(&[(parameter, &values)]).unwrap();
    }
    let (header, frames) = recorded(&mut run, 60);
    assert!(!header.changes.is_empty());
    assert_eq!(recorded_model(model.clone(), &header).unwrap().content_hash(), header.model_hash);
    let mut recertifier = Recertifier::new(model.clone(), &header).unwrap();
    for frame in frames.iter().filter(|frame| frame.solution.phases > 0) {
        let check = recertifier.check(frame).unwrap();
        assert!(check.fault.is_none() && check.certificate.holds(1e-8), "{:?}", check.certificate);
    }
    // What was not recorded, or is something else, is refused.
    let forgotten = Header { changes: header.changes[1..].to_vec(), ..header.clone() };
    assert!(matches!(Recertifier::new(model.clone(), &forgotten), Err(SimulationError::Recording { .. })));
    let mut unknown = header.clone();
    unknown.changes[0].parameter = "body_colour".into();
    assert!(matches!(Recertifier::new(model.clone(), &unknown), Err(SimulationError::Recording { .. })));
    let mut beyond = header;
    beyond.changes[0].index = 1000;
    assert!(matches!(Recertifier::new(model, &beyond), Err(SimulationError::Model(_))));
}

#[test]
fn batches_change_one_simulation_and_vary_stays_what_it_was() {
    let model = workshop();
    let mut batch = Batch::new(model.clone(), Settings::default(), 3, 1).unwrap();
    let masses = other_values(&model, Parameter::BodyMass, 3);
    batch.change(1, &[(Parameter::BodyMass, &masses)]).unwrap();
    let variation = Variation::default().with_friction(0.5).with_mass(1.3);
    batch.vary(2, &variation).unwrap();
    assert!(batch.step(50));
    let alone = |model: Model| {
        let mut simulation = Simulation::new(model, Settings::default()).unwrap();
        (0..50).for_each(|_| {
            simulation.step().unwrap();
        });
        simulation.state().clone()
    };
    assert_eq!(batch.state(0), &alone(model.clone()));
    assert_eq!(batch.state(1), &alone(compiled_with(&model, &[(Parameter::BodyMass, &masses)])));
    assert_eq!(batch.state(2), &alone(variation.of(&model).unwrap()));
}

#[test]
fn a_snapshot_belongs_to_its_parameters() {
    let model = workshop();
    let mut run = Simulation::new(model.clone(), Settings::default()).unwrap();
    let before: Snapshot = run.save();
    let original = model.parameter(Parameter::BodyMass);
    run.change(&[(Parameter::BodyMass, &other_values(&model, Parameter::BodyMass, 5))]).unwrap();
    assert!(matches!(run.restore(&before), Err(SimulationError::Snapshot { .. })));
    run.change(&[(Parameter::BodyMass, &original)]).unwrap();
    run.restore(&before).unwrap();
}

#[test]
fn errors_name_the_part_and_change_nothing() {
    let model = workshop();
    let mut run = Simulation::new(model.clone(), Settings::default()).unwrap();
    let hash = run.model().content_hash();
    let mut refused = |parameter: Parameter, k: usize, value: f64, expected: &str| {
        let mut values = model.parameter(parameter);
        values[k] = value;
        let error = run.change(&[(parameter, &values)]).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    };
    refused(Parameter::BodyMass, 3, -1.0, "body 'box'");
    refused(Parameter::BodyMass, 3, f64::NAN, "body 'box'");
    refused(Parameter::BodyMass, 0, 1.0, "body 'world'");
    refused(Parameter::GeomSize, 0, 1.0, "geom 'floor': geom_size cannot be changed");
    refused(Parameter::GeomSize, 3 * 6, 1.0, "geom 'wedge': geom_size cannot be changed");
    refused(Parameter::GeomSize, 3 * 4 + 1, 1.0, "geom 'ball': geom_size cannot be changed");
    refused(Parameter::ActuatorStiffness, 1, 1.0, "actuator 'spin': actuator_kp cannot be changed");
    refused(Parameter::ActuatorGain, 0, 1.0, "actuator 'servo': actuator_gain cannot be changed");
    refused(Parameter::GeomFriction, 3, -0.1, "geom 'upper'");
    refused(Parameter::BodyInertia, 9 * 3, 1e3, "body 'box'");
    refused(Parameter::Gravity, 0, f64::INFINITY, "gravity");
    let error = run.change(&[(Parameter::BodyMass, &[1.0])]).unwrap_err().to_string();
    assert!(error.contains("body_mass") && error.contains('7'), "{error}");
    assert_eq!(run.model().content_hash(), hash);
}
