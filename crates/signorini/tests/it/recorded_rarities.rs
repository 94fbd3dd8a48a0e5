//! Recorded steps of rare kinds, certified again: limits of ball joints about several axes.

use signorini::multibody::Model;
use signorini::{Settings, Simulation};

use crate::recertify::shows_the_same;

fn model(text: &str) -> Model {
    signorini_formats::load_mjcf_str(text, "").unwrap().model
}

/// A ball joint in its reference, with whatever velocity its fall gives it, beside a body that strikes it across.
const STRUCK_BALL_JOINT: &str = r#"<mujoco><compiler angle="radian" autolimits="true"/><option timestep="0.005"/><worldbody>
    <body><joint type="ball" range="0 .02"/><geom type="capsule" fromto="0 0 0 .5 0 0" size=".03" mass="1"/></body>
    <body pos=".45 .08 0"><freejoint/><geom size=".05" mass="50"/></body></worldbody></mujoco>"#;

fn struck_ball_joint() -> Simulation {
    let mut simulation = Simulation::new(model(STRUCK_BALL_JOINT), Settings::default()).unwrap();
    let mut state = simulation.state().clone();
    state.v[4] = -10.0;
    simulation.set_state(&state).unwrap();
    simulation
}

/// The angle of its rotation, from the scalar part of the quaternion, stays within the cone up to what its planes are wider by.
#[test]
fn a_ball_joint_stays_within_its_cone_wherever_it_is_struck() {
    let mut simulation = struck_ball_joint();
    for step in 0..20 {
        let report = simulation.step().unwrap();
        assert!(report.certificate.holds(1e-9), "step {step}: {report:?}");
        let angle = 2.0 * simulation.state().q[0].abs().min(1.0).acos();
        assert!(angle < 1.06 * 0.02, "step {step}: {angle} rad");
    }
}

/// The same from all sides: what ends a turn does not depend on the direction that gravity would have taken.
#[test]
fn a_ball_joint_in_its_reference_is_stopped_in_every_direction() {
    let text = r#"<mujoco><compiler angle="radian" autolimits="true"/><option timestep="0.005" gravity="0 0 0"/><worldbody>
        <body><joint type="ball" range="0 .3"/><geom size=".1" mass="1"/></body></worldbody></mujoco>"#;
    let mut simulation = Simulation::new(model(text), Settings::default()).unwrap();
    for direction in 0..12 {
        let mut state = simulation.state().clone();
        state.q = vec![1.0, 0.0, 0.0, 0.0];
        let turn = f64::from(direction);
        let axis = [turn.cos(), turn.sin(), (1.7 * turn).sin()];
        let size = axis.iter().map(|a| a * a).sum::<f64>().sqrt();
        state.v = axis.iter().map(|a| 200.0 * a / size).collect();
        simulation.set_state(&state).unwrap();
        simulation.step().unwrap();
        let q = &simulation.state().q;
        assert!((2.0 * q[0].acos() - 0.3).abs() < 1e-9, "{q:?}");
        for (k, a) in axis.iter().enumerate() {
            assert!((q[1 + k] - a / size * 0.15_f64.sin()).abs() < 1e-9, "{q:?}");
        }
    }
}

#[test]
fn limits_of_ball_joints_are_certified_again() {
    shows_the_same(struck_ball_joint(), 40, "struck");
    let text = r#"<mujoco><worldbody><body pos="-0.03 0.02 0.06" quat="0.1 0.4 -0.6 -0.7"><body pos="-0.01 -0.01 0.02">
        <joint type="ball" range="0 1.1"/><geom size="0.006"/></body></body>
        <body pos="-0.03 0.04 0.07" quat="-0.5 0.5 0.7 0.2"><freejoint/><geom type="capsule" size="0.01 0.01"/></body></worldbody></mujoco>"#;
    shows_the_same(Simulation::new(model(text), Settings::default()).unwrap(), 5, "beside a capsule");
}
