//! Sensors against MuJoCo's, whose numbers `testdata/make_sensor_reference.py` stored.

use serde_json::Value;
use signorini::multibody::{Model, State};
use signorini::{Settings, Simulation};

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
        let settings = Settings { timestep: Some(timestep), ..Settings::default() };
        let mut simulation = Simulation::new(model.clone(), settings).unwrap();
        simulation.set_state(start).unwrap();
        simulation.input.control = control.to_vec();
        simulation.step().unwrap();
        simulation.sensors().to_vec()
    };
    for state in run["states"].as_array().unwrap() {
        let time = state["time"].as_f64().unwrap();
        let start = State { time, q: numbers(&state["qpos"]), v: numbers(&state["qvel"]) };
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
