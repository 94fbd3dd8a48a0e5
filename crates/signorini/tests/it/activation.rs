//! Actuators that remember: integrators and filters, against MuJoCo and closed forms.

use serde_json::Value;
use signorini::{Settings, Simulation, Snapshot};

const MODEL: &str = include_str!("../../testdata/activation.xml");
/// What MuJoCo 4.0.0 does (make_activation_reference.py).
const REFERENCE: &str = include_str!("../../testdata/activation_reference.json");

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn assert_near(found: &[f64], wanted: &[f64], tolerance: f64, what: &str) {
    assert_eq!(found.len(), wanted.len(), "{what}");
    for (i, (a, b)) in found.iter().zip(wanted).enumerate() {
        assert!((a - b).abs() <= tolerance * (1.0 + b.abs()), "{what}[{i}]: {a} here, {b} in MuJoCo");
    }
}

fn wound() -> Simulation {
    let imported = signorini_formats::load_mjcf_str(MODEL, "").unwrap();
    assert!(imported.report.warnings.is_empty(), "{}", imported.report);
    let mut simulation = Simulation::new(imported.model, Settings::default()).unwrap();
    simulation.reset_to("wound").unwrap();
    simulation
}

/// Activations go step by step as MuJoCo's, and so do the slides whose force is nothing but a gain times the control or activation.
/// Servos end where MuJoCo's end; on the way theirs are explicit in the length.
#[test]
fn activations_are_mujocos() {
    const WITHOUT_FEEDBACK: usize = 4;
    let reference: Value = serde_json::from_str(REFERENCE).unwrap();
    let mut simulation = wound();
    assert_eq!(simulation.state().activation, [0.25, -0.1, 0.5, 0.2, 0.9, -0.4]);
    let run = &reference["run"];
    let steps = run["control"].as_array().unwrap().len();
    for k in 0..steps {
        simulation.input.control = numbers(&run["control"][k]);
        simulation.step().unwrap();
        let (state, what) = (simulation.state(), format!("after step {k}"));
        assert_near(&state.activation, &numbers(&run["act"][k]), 1e-13, &format!("act {what}"));
        for (found, name) in [(&state.q, "qpos"), (&state.v, "qvel")] {
            let wanted = numbers(&run[name][k]);
            assert_near(&found[..WITHOUT_FEEDBACK], &wanted[..WITHOUT_FEEDBACK], 1e-12, &format!("{name} {what}"));
        }
    }
    for _ in 0..4000 {
        simulation.step().unwrap();
    }
    let (state, rest) = (simulation.state(), &reference["rest"]);
    assert_near(&state.activation, &numbers(&rest["act"]), 1e-11, "act at rest");
    assert_near(&state.q[WITHOUT_FEEDBACK..], &numbers(&rest["qpos"])[WITHOUT_FEEDBACK..], 1e-11, "qpos at rest");
}

/// The activations are part of a snapshot: a run that goes on from one has the bits of one that was not interrupted.
#[test]
fn snapshots_hold_activations() {
    let mut whole = wound();
    whole.input.control = vec![0.7; 7];
    (0..20).for_each(|_| drop(whole.step().unwrap().clone()));
    let snapshot = Snapshot::from_bytes(&whole.save().to_bytes()).unwrap();
    let mut resumed = wound();
    resumed.restore(&snapshot).unwrap();
    for _ in 0..50 {
        whole.step().unwrap();
        resumed.step().unwrap();
        assert_eq!(resumed.state(), whole.state());
    }
}

/// A force that grows by 1 N/s against a dry friction of 0.2 N: the slide stays for 0.2 s to the bit, then goes. It must not be
/// taken for asleep while only the activation changes.
#[test]
fn a_resting_slide_breaks_away_when_its_activation_has_grown() {
    let text = "<mujoco><option timestep='0.001' gravity='0 0 0'/><worldbody><body>
        <joint name='rail' type='slide' axis='1 0 0' frictionloss='0.2'/><geom size='0.1' mass='1'/></body></worldbody>
        <actuator><general joint='rail' dyntype='integrator'/></actuator></mujoco>";
    let model = signorini_formats::load_mjcf_str(text, "").unwrap().model;
    for sleeping in [false, true] {
        let mut simulation = Simulation::new(model.clone(), Settings::default().with_sleeping(sleeping)).unwrap();
        simulation.input.control = vec![1.0];
        for k in 0..400 {
            simulation.step().unwrap();
            // Step k is made with the force k Δt.
            let [v] = simulation.state().v[..] else { panic!("one degree of freedom") };
            let sum: f64 = (0..=k).map(|i| (1e-3 * f64::from(i) - 0.2).max(0.0) * 1e-3).sum();
            assert!((v - sum).abs() < 1e-12, "sleeping {sleeping}, step {k}: {v}, not {sum}");
        }
    }
}
