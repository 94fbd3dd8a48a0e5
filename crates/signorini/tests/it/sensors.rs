//! Sensors against MuJoCo's, whose numbers `testdata/make_sensor_reference.py` stored.

use serde_json::Value;
use signorini::multibody::glam::{DMat3, DVec3};
use signorini::multibody::{Input, Model, SpatialVector, State};
use signorini::{RestitutionLaw, Settings, Simulation, contact_wrenches_into};

const REFERENCE: &str = include_str!("../../testdata/sensor_reference.json");

fn model(name: &str) -> Model {
    let path = format!("{}/testdata/{name}.xml", env!("CARGO_MANIFEST_DIR"));
    let imported = signorini_formats::load(path, &Default::default()).unwrap();
    let soft = |what: &str| what.contains("solref") || what.contains("solimp");
    assert!(imported.report.warnings.iter().all(|w| soft(&w.what)), "{}", imported.report);
    imported.model
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

/// Compares number by number; `tolerance` is asked for each sensor: whether it needs a step.
fn compare(model: &Model, ours: &[f64], run: &Value, state: &Value, tolerance: impl Fn(bool) -> f64) {
    let theirs = numbers(&state["sensordata"]);
    assert_eq!(ours.len(), theirs.len());
    let names = run["sensors"].as_array().unwrap();
    assert_eq!(model.sensors.len(), names.len());
    for (sensor, entry) in model.sensors.iter().zip(names) {
        assert_eq!(sensor.kind.size() as u64, entry[1].as_u64().unwrap(), "{entry}");
        let range = sensor.address..sensor.address + sensor.kind.size();
        let (ours, theirs) = (&ours[range.clone()], &theirs[range]);
        let scale = theirs.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
        // A quaternion and its negative are the same orientation.
        let sign = if sensor.kind.size() == 4 && ours[0] * theirs[0] < 0.0 { -1.0 } else { 1.0 };
        for (a, b) in ours.iter().zip(theirs) {
            let off = (sign * a - b).abs() / scale;
            assert!(off <= tolerance(sensor.kind.needs_step()), "{entry} {:?}: {ours:?}, not {theirs:?}", sensor.kind);
        }
    }
}

fn reference(run: &str) -> Value {
    serde_json::from_str::<Value>(REFERENCE).unwrap()[run].take()
}

/// The mean accelerations of two short steps are extrapolated to that of the instant. Nothing touches.
#[test]
fn moving_sensors_are_mujocos() {
    let run = reference("moving");
    let mut model = model("sensors");
    model.geoms.iter_mut().for_each(|geom| (geom.contact_type, geom.contact_affinity) = (0, 0));
    let measure = |timestep: f64, start: &State, control: &[f64]| {
        let settings = Settings::default().with_timestep(timestep);
        let mut simulation = Simulation::new(model.clone(), settings).unwrap();
        simulation.set_state(start).unwrap();
        simulation.input.control = control.to_vec();
        simulation.step().unwrap();
        simulation.sensors().to_vec()
    };
    for state in run["states"].as_array().unwrap() {
        let time = state["time"].as_f64().unwrap();
        let start = State::at(numbers(&state["qpos"]), numbers(&state["qvel"])).with_time(time);
        let control = numbers(&state["ctrl"]);
        let [long, short] = [2e-7, 1e-7].map(|timestep| measure(timestep, &start, &control));
        let instant: Vec<f64> = short.iter().zip(&long).map(|(s, l)| 2.0 * s - l).collect();
        compare(&model, &instant, &run, state, |step| if step { 1e-5 } else { 1e-12 });
    }
}

/// MuJoCo's contacts give way by micrometres; what carries the weight is the same.
#[test]
fn resting_sensors_are_mujocos() {
    let run = reference("resting");
    let model = model("resting");
    let mut simulation = Simulation::new(model.clone(), Settings::default()).unwrap();
    let state = &run["states"][0];
    simulation.input.control = numbers(&state["ctrl"]);
    for _ in 0..20_000 {
        simulation.step().unwrap();
    }
    compare(&model, simulation.sensors(), &run, state, |_| 2e-4);
    // The whole weight stands on the sole.
    let weight = (2.0 + 0.4 + 0.3) * 9.81;
    assert!((simulation.sensors()[0] - weight).abs() < 1e-6, "{}", simulation.sensors()[0]);
}

/// A simulation of MJCF text after ten steps.
fn stepped(text: &str, control: &[f64]) -> Simulation {
    let imported = signorini_formats::load_mjcf_str(text, "").unwrap();
    assert!(imported.report.warnings.is_empty(), "{}", imported.report);
    let mut simulation = Simulation::new(imported.model, Settings::default()).unwrap();
    simulation.input.control = control.to_vec();
    for _ in 0..10 {
        simulation.step().unwrap();
    }
    simulation
}

fn assert_near(found: &[f64], wanted: &[f64]) {
    assert_eq!(found.len(), wanted.len());
    let off = found.iter().zip(wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off < 1e-9, "{found:?}, not {wanted:?}");
}

/// A beam whose end is held by a point carries half its weight at the hinge; a weld beside a slide carries all of a weight and
/// leaves its moment to the slide; one on the axis of a hinge leaves the hinge the weight, but no moment about its axis.
#[test]
fn joints_do_not_carry_what_points_and_welds_do() {
    let text = "<mujoco><worldbody>
        <body name='beam'><joint axis='0 1 0'/><site name='beam'/>
            <inertial pos='.5 0 0' mass='2' diaginertia='.01 .2 .2'/></body>
        <body name='weight' pos='0 1 0'><joint type='slide' axis='0 0 1'/><site name='weight'/>
            <inertial pos='0 0 0' mass='3' diaginertia='.1 .1 .1'/></body>
        <body name='arm' pos='0 2 0'><joint axis='1 0 0'/><site name='arm'/>
            <inertial pos='0 .2 0' mass='1' diaginertia='.1 .1 .1'/></body>
        <body name='table' pos='.3 1 0'/><body name='pivot' pos='0 2 0'/><site name='world'/></worldbody>
        <equality><connect body1='beam' anchor='1 0 0'/><weld body1='weight' body2='table'/>
            <weld body1='arm' body2='pivot'/></equality>
        <sensor><force site='beam'/><torque site='beam'/><force site='weight'/><torque site='weight'/>
            <force site='arm'/><torque site='arm'/><force site='world'/><torque site='world'/></sensor></mujoco>";
    let mut simulation = stepped(text, &[]);
    let numbers = simulation.sensors();
    assert_near(&numbers[..6], &[0.0, 0.0, 9.81, 0.0, 0.0, 0.0]);
    assert_near(&numbers[6..12], &[0.0, 0.0, 0.0, 0.0, 0.3 * 3.0 * 9.81, 0.0]);
    assert_near(&numbers[12..18], &[0.0, 0.0, 9.81, 0.0, 0.0, 0.0]);
    // The world holds all three, with what its table and its pivot hold, but for the half of the beam that it is connected to.
    assert_near(&numbers[18..], &[0.0, 0.0, 5.0 * 9.81, (3.0 * 1.0 + 1.0 * 2.2) * 9.81, 0.0, 0.0]);
}

/// Two hinges with a site on the world, on the first and on the second body, whose forces and moments are measured.
fn held(gravity: f64, others: &str, input: impl Fn(&mut Input)) -> Vec<f64> {
    let text = format!(
        "<mujoco><option gravity='0 0 {gravity}' timestep='1e-7'/><worldbody><site name='o'/>
        <body><joint axis='0 0 1'/><geom size='.1' mass='1'/><site name='a' pos='.1 .2 0'/>
            <body><joint axis='0 1 0'/><geom size='.1' pos='.2 0 0' mass='1'/><site name='b' pos='.3 0 0'/></body></body>
        <site name='w' pos='1 1 1'/></worldbody>{others}
        <sensor><force site='o'/><torque site='o'/><force site='a'/><torque site='a'/><force site='b'/><torque site='b'/>
        </sensor></mujoco>"
    );
    let model = signorini_formats::load_mjcf_str(&text, "").unwrap().model;
    let mut simulation = Simulation::new(model, Settings::default()).unwrap();
    input(&mut simulation.input);
    simulation.step().unwrap();
    simulation.sensors().to_vec()
}

/// What acts on bodies from outside, wrenches and strings, is not their parents'; forces of sites are. Numbers of MuJoCo 4.0.0 (sensordata).
#[test]
fn parents_do_not_carry_what_acts_from_outside() {
    let near = |found: Vec<f64>, wanted: [f64; 18]| {
        let off = found.iter().zip(&wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(found.len() == 18 && off < 1e-5, "{found:?}, not {wanted:?}");
    };
    #[rustfmt::skip]
    near(held(-9.81, "", |_| ()), [
        0.0, 0.0, 10.7018182, 0.0, 0.0, 0.0, 0.0, 0.0, 10.7018182, -2.14036364, 1.07018182, 0.0,
        0.0, 0.0, 0.891818182, 0.0, 0.267545455, 0.0,
    ]);
    let wrench = SpatialVector { angular: DVec3::new(0.1, 0.2, 0.3), linear: DVec3::new(1.0, 2.0, 3.0) };
    #[rustfmt::skip]
    near(held(0.0, "", |input| input.wrench = vec![SpatialVector::ZERO, SpatialVector::ZERO, wrench]), [
        -1.0, 0.916666667, -1.18181818, -0.1, 0.0, 0.0, -1.0, 0.916666667, -1.18181818, 0.136363636, -0.118181818, -0.291666667,
        -1.0, 0.916666667, -1.18181818, -0.1, -0.354545455, -0.333333333,
    ]);
    let spring = |path: &str| format!("<tendon><spatial stiffness='18' springlength='0'>{path}</spatial></tendon>");
    #[rustfmt::skip]
    near(held(0.0, &spring("<site site='w'/><site site='a'/>"), |_| ()), [
        -16.2, -21.9, -18.0, -3.6, 1.8, 0.0, -16.2, -21.9, -18.0, 0.0, 0.0, -1.05, 0.0, -7.5, 0.0, 0.0, 0.0, 0.6,
    ]);
    #[rustfmt::skip]
    near(held(0.0, &spring("<site site='a'/><site site='b'/>"), |_| ()), [
        0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 3.6, -3.6, 0.0, 0.0, 0.0, 0.0,
    ]);
    let path = "<site site='w'/><site site='b'/><pulley divisor='2'/><site site='o'/><site site='a'/>";
    #[rustfmt::skip]
    near(held(0.0, &spring(path), |_| ()), [
        -6.69152146, 18.4212771, 7.00921653, 0.0, 0.0, 0.0, -6.69152146, 18.4212771, 7.00921653, -1.40184331, 0.700921653, -3.180432,
        -13.4927418, 4.81883636, 7.00921653, 0.0, 2.10276496, -1.92753455,
    ]);
    let motor = "<tendon><spatial name='t'><site site='w'/><site site='b'/></spatial></tendon><actuator><motor tendon='t' gear='2'/></actuator>";
    #[rustfmt::skip]
    near(held(0.0, motor, |input| input.control = vec![1.0]), [
        0.887213951, -0.316862125, -0.460890364, 0.0, 0.0, 0.0,
        0.887213951, -0.316862125, -0.460890364, 0.0921780728, -0.0460890364, 0.209129003,
        0.887213951, -0.316862125, -0.460890364, 0.0, -0.138267109, 0.12674485,
    ]);
    let thruster = "<actuator><motor site='b' gear='1 2 3 0 0 0'/></actuator>";
    #[rustfmt::skip]
    near(held(0.0, thruster, |input| input.control = vec![1.0]), [
        0.0, 2.5, 4.09090909, 0.0, -0.9, 0.6, 0.0, 2.5, 4.09090909, -0.818181818, -0.490909091, 0.35,
        0.0, 2.5, 4.09090909, 0.0, 0.327272727, -0.2,
    ]);
}

/// A weight on a string at its limit hangs on it, not on its slide: so it does on a string that is coupled to nothing.
#[test]
fn strings_carry_at_their_limits_and_where_they_are_constrained() {
    let string = |constraint: &str, limit: &str| {
        format!(
            "<mujoco><worldbody><site name='hook' pos='0 0 1'/><body><joint type='slide' axis='0 0 1'/>
            <geom size='.1' mass='2'/><site name='s'/></body></worldbody>
            <tendon><spatial name='t' {limit}><site site='hook'/><site site='s'/></spatial></tendon>{constraint}
            <sensor><force site='s'/></sensor></mujoco>"
        )
    };
    let coupled = "<equality><tendon tendon1='t' polycoef='0 0 0 0 0'/></equality>";
    for text in [string("", "range='0 1'"), string(coupled, "")] {
        assert_near(stepped(&text, &[]).sensors(), &[0.0; 3]);
    }
}

/// Weights on strings that follow each other, with springs, dampers and several motors, hang on these alone: slides bear nothing along their axes,
/// neither while the weights move nor where one string is at its limit.
#[test]
fn strings_carry_what_those_that_follow_them_take() {
    let hung = |limit: &str| {
        format!(
            "<mujoco><worldbody><site name='hook' pos='0 0 1'/><site name='hoop' pos='1 0 1'/>
            <body><joint type='slide' axis='0 0 1'/><geom size='.1' mass='2'/><site name='a'/></body>
            <body pos='1 0 0'><joint type='slide' axis='0 0 1'/><geom size='.1' mass='3'/><site name='b'/></body></worldbody>
            <tendon><spatial name='a' stiffness='5' springlength='.2' damping='3'><site site='hook'/><site site='a'/></spatial>
            <spatial name='b' stiffness='7' springlength='.3' {limit}><site site='hoop'/><site site='b'/></spatial></tendon>
            <equality><tendon tendon1='a' tendon2='b' polycoef='0 2 .5 0 0'/></equality>
            <actuator><motor tendon='a' gear='3'/><motor tendon='a' gear='-2'/><motor tendon='b' gear='2'/></actuator>
            <sensor><force site='a'/><force site='b'/><tendonpos tendon='b'/></sensor></mujoco>"
        )
    };
    for (limit, lowest) in [("", 1.02), ("range='0 1.005'", 1.005)] {
        let mut simulation = stepped(&hung(limit), &[0.7, 0.4, 1.1]);
        (0..60).for_each(|_| _ = simulation.step().unwrap());
        let numbers = simulation.sensors();
        assert!((numbers[6] - lowest).abs() < 1e-9 || numbers[6] > lowest && limit.is_empty(), "{numbers:?}");
        assert_near(&numbers[..6], &[0.0; 6]);
    }
}

/// A foot that the friction of its contact keeps from spinning hands the motor's moment to the floor.
#[test]
fn joints_do_not_carry_what_friction_against_spinning_does() {
    let text = "<mujoco><worldbody><geom type='plane' size='1 1 1'/>
        <body name='foot' pos='0 0 .1'><joint type='slide' axis='0 0 1'/><joint name='turn' axis='0 0 1'/>
            <geom size='.1' mass='2' condim='4' friction='1 .01 0'/><site name='foot'/></body></worldbody>
        <actuator><motor name='motor' joint='turn'/></actuator>
        <sensor><torque site='foot'/><actuatorfrc actuator='motor'/></sensor></mujoco>";
    let mut simulation = stepped(text, &[0.05]);
    assert_near(simulation.sensors(), &[0.0, 0.0, 0.05, 0.05]);
    assert_near(&simulation.state().v, &[0.0, 0.0]);
}

/// In the step of an impact both compression and decompression are felt: `Δt f = m (v⁺ − v + Δt g)`.
#[test]
fn both_phases_of_an_impact_are_felt() {
    let text = "<mujoco><custom><numeric name='signorini:restitution' data='.5'/></custom>
        <worldbody><geom type='plane' size='1 1 1'/>
        <body pos='0 0 .1'><joint type='slide' axis='0 0 1'/><geom size='.1' mass='2'/><site name='s' size='.2'/></body>
        </worldbody><sensor><touch site='s'/><accelerometer site='s'/></sensor></mujoco>";
    for restitution in [RestitutionLaw::Newton, RestitutionLaw::Poisson] {
        let model = signorini_formats::load_mjcf_str(text, "").unwrap().model;
        let mut simulation = Simulation::new(model, Settings::default().with_restitution(restitution)).unwrap();
        let mut state = simulation.state().clone();
        state.v[0] = -3.0;
        simulation.set_state(&state).unwrap();
        simulation.step().unwrap();
        let after = simulation.state().v[0];
        assert!((after - 1.5).abs() < 0.03, "{after} m/s");
        let felt = (after + 3.0) / 0.002 + 9.81;
        let numbers = simulation.sensors();
        assert!((numbers[0] - 2.0 * felt).abs() < 1e-6 && (numbers[3] - felt).abs() < 1e-6, "{numbers:?}, not {felt}");
    }
}

/// What contacts do to a box that tumbles and slides is what changes its momentum beside gravity and gyroscopic moments, step by
/// step, also where they rub against spinning and rolling; and the floor gets the opposite force.
#[test]
fn wrenches_of_contacts_change_the_momentum() {
    for condim in [3, 6] {
        let text = format!(
            "<mujoco><option timestep='.002'/><worldbody><geom type='plane' size='1 1 1'/>
            <body pos='0 0 .25' euler='20 30 10'><freejoint/><geom type='box' size='.2 .1 .05' mass='2' condim='{condim}'
            friction='.5 .02 .01'/></body></worldbody></mujoco>"
        );
        let model = signorini_formats::load_mjcf_str(&text, "").unwrap().model;
        let inertia = DVec3::new(0.01 + 0.0025, 0.04 + 0.0025, 0.04 + 0.01) * 2.0 / 3.0;
        let mut simulation = Simulation::new(model, Settings::default()).unwrap();
        let mut state = simulation.state().clone();
        state.v = vec![1.0, 0.0, -0.5, 0.5, 2.0, 1.0];
        simulation.set_state(&state).unwrap();
        let mut touched = 0;
        for _ in 0..300 {
            let before = simulation.state().clone();
            simulation.step().unwrap();
            let mut wrenches = [0.0; 12];
            contact_wrenches_into(simulation.workspace(), &mut wrenches);
            let (after, free) = (&simulation.state().v, &simulation.workspace().problem().free_velocity);
            let change =
                |from: &[f64], k: usize| (DVec3::from_slice(&after[k..]) - DVec3::from_slice(&from[k..])) / 0.002;
            let force = 2.0 * (change(&before.v, 0) + DVec3::Z * 9.81);
            let moment = inertia * change(free, 3);
            let [w, x, y, z] = [3, 4, 5, 6].map(|k| before.q[k]);
            let to_world = DMat3::from_quat(signorini::multibody::glam::DQuat::from_xyzw(x, y, z, w));
            let scale = 1.0 + force.length();
            let near = |found: &[f64], wanted: DVec3| (DVec3::from_slice(found) - wanted).length() < 1e-8 * scale;
            assert!(near(&wrenches[6..9], to_world * moment), "{wrenches:?}, not {}", to_world * moment);
            assert!(near(&wrenches[9..], force) && near(&wrenches[3..6], -force), "{wrenches:?}, not {force}");
            let about_origin = DVec3::from_slice(&wrenches[6..]) + DVec3::from_slice(&before.q).cross(force);
            assert!(near(&wrenches[..3], -about_origin), "{wrenches:?}, not {about_origin} on the floor");
            touched += u32::from(force.length() > 1.0);
        }
        assert!(touched > 100, "{touched}");
    }
}

/// Level arms and a weight on a string: what holds them is the moment and the weight that gravity has, and limits that nothing meets have no force.
#[test]
fn limits_carry_what_leans_on_them() {
    let text = "<mujoco><option timestep='0.002'/><compiler angle='radian'/><worldbody>
        <body><joint name='down' axis='0 1 0' limited='true' range='-1 0'/>
          <geom type='sphere' size='0.05' pos='0.5 0 0' mass='2' contype='0' conaffinity='0'/></body>
        <body pos='0 3 0'><joint name='ball' type='ball' limited='true' range='0 0.3'/>
          <geom type='sphere' size='0.05' pos='0.5 0 0' mass='2' contype='0' conaffinity='0'/></body>
        <site name='nail' pos='0 5 1'/><body pos='0 5 0'><joint name='slide' type='slide' axis='0 0 1'/>
          <geom type='sphere' size='0.05' mass='3' contype='0' conaffinity='0'/><site name='eye'/></body></worldbody>
      <tendon><spatial name='string' limited='true' range='0 1'><site site='nail'/><site site='eye'/></spatial></tendon>
      <sensor><jointlimitfrc joint='down'/><jointlimitfrc joint='ball'/><jointlimitfrc joint='slide'/><tendonlimitfrc tendon='string'/>
        <jointlimitpos joint='down'/><tendonlimitpos tendon='string'/></sensor></mujoco>";
    let mut simulation = stepped(text, &[]);
    // The arm on a ball joint falls until its cone ends, and rests there.
    (0..200).for_each(|_| _ = simulation.step().unwrap());
    let weight = 2.0 * 9.81 * 0.5;
    let found = simulation.sensors().to_vec();
    assert_near(&found, &[weight, weight * 0.3_f64.cos(), 0.0, 3.0 * 9.81, 0.0, 0.0]);
}
