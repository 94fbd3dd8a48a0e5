//! Rules of MJCF for joints and geoms, with MuJoCo's numbers.

use signorini::{Settings, Simulation};

use crate::support::run_certified;

fn load(text: &str) -> Simulation {
    let imported = signorini_formats::load_mjcf_str(text, "").unwrap();
    assert!(imported.report.warnings.is_empty(), "{}", imported.report);
    Simulation::new(imported.model, Settings::default()).unwrap()
}

/// The geom with the higher priority says alone what the friction is. MuJoCo 4.0.0 has 0.2, 0.9, 0.9, and no friction in the contact
/// with `condim` 1.
#[test]
fn priority_of_geoms() {
    for (floor, ball, expected) in [
        ("friction='.2' priority='1'", "friction='.9'", 0.2),
        ("friction='.2'", "friction='.9' priority='2'", 0.9),
        ("friction='.2' priority='1'", "friction='.9' priority='1'", 0.9),
        ("friction='.2' condim='1' priority='1'", "friction='.9'", 0.0),
    ] {
        let mut simulation = load(&format!(
            "<mujoco><worldbody><geom type='plane' {floor}/><body pos='0 0 .1'><freejoint/><geom size='.1' mass='1' {ball}/></body>
             </worldbody></mujoco>"
        ));
        run_certified(&mut simulation, 0.01);
        assert_eq!(simulation.workspace().contact_points()[0].friction, expected, "{floor}, {ball}");
    }
}

/// A slide that falls onto its limit stops at the margin before it: MuJoCo 4.0.0 with stiff limits rests at −0.4000 m.
#[test]
fn margin_of_joints() {
    let mut simulation = load(
        "<mujoco><option timestep='0.002'/><worldbody><body><joint type='slide' axis='0 0 1' range='-.5 1' margin='.1'/>
         <geom size='.1' mass='1'/></body></worldbody></mujoco>",
    );
    run_certified(&mut simulation, 1.0);
    assert!((simulation.state().q[0] + 0.4).abs() < 1e-9, "{}", simulation.state().q[0]);
}

/// The force at the joint is cut to its range, whatever the gear and the actuator's own range are. MuJoCo 4.0.0 has the accelerations
/// 3, −2, 1 and 3 m/s².
#[test]
fn bounds_of_all_actuators_of_a_joint() {
    for (actuator, control, expected) in [
        ("<motor joint='j' gear='10'/>", 5.0, 3.0),
        ("<motor joint='j' gear='-10'/>", 5.0, -2.0),
        ("<motor joint='j' gear='2' forcerange='-.5 .5'/>", 5.0, 1.0),
        ("<position joint='j' kp='1000'/>", 5.0, 3.0),
    ] {
        let mut simulation = load(&format!(
            "<mujoco><option timestep='0.001' gravity='0 0 0'/><worldbody><body><joint name='j' type='slide' actuatorfrcrange='-2 3'/>
             <geom size='.1' mass='1'/></body></worldbody><actuator>{actuator}</actuator></mujoco>"
        ));
        simulation.input.control = vec![control];
        simulation.step().unwrap();
        let acceleration = simulation.state().v[0] / 0.001;
        assert!((acceleration - expected).abs() < 1e-9, "{actuator}: {acceleration}");
    }
    let several = "<mujoco><worldbody><body><joint name='j' actuatorfrcrange='-2 3'/><geom size='.1'/></body></worldbody><actuator>
                   <motor joint='j'/><motor joint='j'/></actuator></mujoco>";
    let report = signorini_formats::load_mjcf_str(several, "").unwrap().report;
    assert!(report.to_string().contains("several actuators"), "{report}");
}
