//! Recorded steps of rare kinds, certified again: limits of ball joints about several axes, corrections of which nothing is left to limit,
//! decompressions under other laws of friction, impulses that are last digits.

use signorini::multibody::Model;
use signorini::{FrictionLaw, KeptRow, RestitutionLaw, Settings, Simulation};

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

/// A part θ of corrections of which all are released again is all of them.
#[test]
fn a_step_that_keeps_nothing_is_not_limited() {
    let text = r#"<mujoco><worldbody><geom type="plane" zaxis="-0.168 0 1"/>
        <body pos="0.0008775 -0.009493 0.0074" quat="-0.51822 -0.41376 -0.60593 -0.43942"><freejoint/><geom size="0.002039 0.002385 0.001654"/>
        <body pos="0.004667 -0.004863 -0.004061" quat="0.46293 0.20363 0.80036 0.32194"><joint name="j7" range="0.017 1.298"/><geom size="0.001631"/>
        <body pos="-0.004783 0.00355 -0.00423" quat="-0.4052 0.86386 0.059966 0.2932"><joint name="j10" damping="0.0001733"/>
        <geom size="0.001691 0.0008546 0.0005255"/></body></body></body></worldbody>
        <equality><joint joint1="j7" joint2="j10" polycoef="-0.08064 -0.01205 -0.3574 0 0"/></equality></mujoco>"#;
    let simulation = || Simulation::new(model(text), Settings::default()).unwrap();
    let mut run = simulation();
    for step in 0..10 {
        let report = run.step().unwrap();
        assert_eq!(report.theta < 1.0, !report.kept.is_empty(), "step {step}: {report:?}");
    }
    shows_the_same(simulation(), 10, "released");
}

#[test]
fn decompressions_under_other_laws_of_friction_are_certified_again() {
    let text = r#"<mujoco><option timestep="0.01" gravity="3 0 -9"/><worldbody>
        <geom type="box" size="0.17 0.2 0.12" pos="0.21 0.27 0.3" quat="-0.65 0.26 0.65 0.3"/>
        <body pos="0.03 0.41 0.83" quat="0.4 0 0.2 -0.9"><freejoint/><geom type="capsule" size="0.1 0.12"/></body></worldbody></mujoco>"#;
    for law in [FrictionLaw::Polygon, FrictionLaw::Circular, FrictionLaw::Refined { tolerance: 1e-6 }] {
        let settings = Settings::default().with_restitution(RestitutionLaw::Poisson).with_friction_law(law);
        let simulation = || {
            let mut model = model(text);
            model.geoms.iter_mut().for_each(|geom| geom.restitution = 0.089);
            Simulation::new(model, settings.clone()).unwrap()
        };
        let mut seen = simulation();
        let impacts = (0..25).filter(|_| seen.step().is_ok() && seen.workspace().decompression().is_some()).count();
        assert!(impacts > 0, "{law:?}: nothing strikes");
        shows_the_same(simulation(), 25, &format!("{law:?}"));
    }
}

#[test]
fn impulses_that_are_last_digits_are_certified_again() {
    let text = r#"<mujoco><option timestep="0.001" gravity="0 0 0"/><worldbody><geom type="plane" friction="0"/>
        <geom type="box" size="0.106 0.104 0.081" pos="-0.4272 -0.02422 0.206" quat="-1 -0.2 0 0"/>
        <body pos="-0.3126 -0.08396 0.201" quat="0.3 0.1 0.2 -0.9"><freejoint/>
        <geom type="capsule" size="0.09374 0.1135" condim="6" friction="0 0 0" quat="0.02 -0.17 -0.15 0.97"/></body></worldbody></mujoco>"#;
    shows_the_same(Simulation::new(model(text), Settings::default()).unwrap(), 5, "no weight");
}

/// A weld off its place about the axis of a hinge, where nothing moves it: it is kept, alone and beside a jam that is limited.
#[test]
fn violations_that_nothing_moves_are_certified_again() {
    let jam = r#"<geom type="box" size="0.1 1 1" pos="-0.19 3 0"/><geom type="box" size="0.1 1 1" pos="0.19 3 0"/>
        <body pos="0 3 0"><freejoint/><geom type="box" size="0.1 0.1 0.1" mass="1"/></body>"#;
    for beside in ["", jam] {
        let text = format!(
            r#"<mujoco><worldbody>{beside}<body name="turntable"><joint axis="0 0 1"/><geom size="0.1" mass="1"/></body></worldbody>
            <equality><weld body1="turntable" relpose="0.01 0 0 1 0 0 0"/></equality></mujoco>"#
        );
        let simulation = || Simulation::new(model(&text), Settings::default()).unwrap();
        let mut seen = simulation();
        let report = seen.step().unwrap();
        assert!(report.kept.iter().any(|kept| matches!(kept.row, KeptRow::Bilateral(_))), "{report:?}");
        assert_eq!(report.theta < 1.0, !beside.is_empty(), "{report:?}");
        shows_the_same(simulation(), 5, "turntable");
    }
}
