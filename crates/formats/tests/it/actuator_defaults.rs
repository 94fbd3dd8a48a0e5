//! Actuators with defaults of every other sort against what MuJoCo 4.0.0 made of them (`testdata/make_actuator_defaults.py`).

use serde_json::Value;
use signorini_formats::load_mjcf_str;
use signorini_multibody::{ActivationKind, Actuator, ActuatorKind};

const TOLERANCE: f64 = 1e-9;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().map(|list| list.iter().map(|x| x.as_f64().unwrap()).collect()).unwrap_or_default()
}

/// Gain and bias of an affine law.
fn affine(actuator: &Actuator) -> [[f64; 3]; 2] {
    match actuator.kind {
        ActuatorKind::Motor => [[1.0, 0.0, 0.0], [0.0; 3]],
        ActuatorKind::Position { kp, kv } => [[kp, 0.0, 0.0], [0.0, -kp, -kv]],
        ActuatorKind::Velocity { kv } => [[kv, 0.0, 0.0], [0.0, 0.0, -kv]],
        ActuatorKind::Affine { gain, bias } => [gain, bias],
        _ => panic!("not affine: {:?}", actuator.kind),
    }
}

/// Dynamics and time constants as MuJoCo has them.
fn dynamics(actuator: &Actuator) -> (&'static str, Vec<f64>) {
    match actuator.activation.map(|activation| activation.kind) {
        None => ("none", vec![]),
        Some(ActivationKind::Integrator) => ("integrator", vec![]),
        Some(ActivationKind::Filter { time_constant }) => ("filter", vec![time_constant]),
        Some(ActivationKind::ExactFilter { time_constant }) => ("filterexact", vec![time_constant]),
        Some(ActivationKind::Muscle { times, .. }) => ("muscle", times.to_vec()),
    }
}

#[track_caller]
fn assert_close(ours: &[f64], theirs: &[f64], what: &str) {
    let close = ours.len() == theirs.len() && ours.iter().zip(theirs).all(|(a, b)| (a - b).abs() <= TOLERANCE);
    assert!(close, "{what}: {ours:?} instead of {theirs:?}");
}

#[test]
fn sorts_share_one_record_of_defaults() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/testdata/reference/actuator_defaults.json");
    let rows: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let rows = rows.as_array().unwrap();
    assert!(rows.len() > 300);
    for row in rows {
        let xml = row["xml"].as_str().unwrap();
        let model = load_mjcf_str(xml, "").unwrap_or_else(|e| panic!("{xml}: {e}")).model;
        let actuator = &model.actuators[0];
        let (name, times) = dynamics(actuator);
        assert_eq!(name, row["dynamics"], "{xml}");
        assert_close(&times, &numbers(&row["times"])[..times.len()], xml);
        let (gain, bias) = (numbers(&row["gain"]), numbers(&row["bias"]));
        if let ActuatorKind::Muscle(muscle) = actuator.kind {
            assert_eq!(gain, bias);
            assert_close(
                &[muscle.range[0], muscle.range[1], muscle.shortest, muscle.longest],
                &[gain[0], gain[1], gain[4], gain[5]],
                xml,
            );
            assert_close(&[muscle.fastest, muscle.passive, muscle.lengthening], &gain[6..], xml);
            assert!(gain[2] < 0.0 || gain[2] == muscle.force, "{xml}");
            continue;
        }
        let [our_gain, our_bias] = affine(actuator);
        assert_close(&our_gain, &gain, xml);
        assert_close(&our_bias, &bias, xml);
        let range = |range: Option<[f64; 2]>| range.map(|range| range.to_vec()).unwrap_or_default();
        assert_close(&range(actuator.control_range), &numbers(&row["ctrlrange"]), xml);
        assert_close(&range(actuator.activation.and_then(|a| a.range)), &numbers(&row["actrange"]), xml);
    }
}
