//! Actuators and what goes with them that MuJoCo 4.0.0 reads: taken over with its numbers, or said not to be.

use signorini_formats::{Imported, load_mjcf_str};
use signorini_multibody::{ActivationKind, ActuatorKind};

/// A hinge `j` with a weight, and a tendon `t` along it.
const ARM: &str = "<worldbody><body name='b'><joint name='j' axis='0 1 0'/><geom size='.1' pos='.3 0 0' mass='1'/></body></worldbody>\
                   <tendon><fixed name='t' range='-1 2'><joint joint='j' coef='1'/></fixed></tendon>";

#[track_caller]
fn import(text: &str) -> Imported {
    load_mjcf_str(&format!("<mujoco>{text}</mujoco>"), "").unwrap_or_else(|e| panic!("{e}"))
}

#[track_caller]
fn actuators(inner: &str) -> Imported {
    import(&format!("{ARM}<actuator>\n{inner}</actuator>"))
}

/// Lines of what changes the motion.
fn lines(imported: &Imported) -> Vec<usize> {
    imported.report.motion_warnings().map(|w| w.line as usize).collect()
}

#[test]
fn ranges_of_set_points() {
    let imported = actuators(
        "<intvelocity joint='j'/><intvelocity joint='j' actrange='-1 1' actlimited='false'/>\
         <position tendon='t' inheritrange='1'/><position tendon='t' inheritrange='.5' timeconst='1'/>\
         <intvelocity tendon='t' inheritrange='1'/>",
    );
    assert!(lines(&imported).is_empty(), "{}", imported.report);
    let ranges = |a: usize| {
        let actuator = &imported.model.actuators[a];
        (actuator.control_range, actuator.activation.and_then(|activation| activation.range))
    };
    let found: Vec<_> = (0..5).map(ranges).collect();
    let (whole, half) = (Some([-1.0, 2.0]), Some([-0.25, 1.25]));
    assert_eq!(found, [(None, None), (None, None), (whole, None), (half, None), (None, whole)]);
}

/// Dampers and adhesion have no switch for their range.
#[test]
fn ranges_without_a_switch_count() {
    let text = "<compiler autolimits='false'/><worldbody><body name='b'><joint name='j'/><geom size='1'/></body></worldbody>\
                <actuator><damper joint='j' ctrlrange='0 1'/><adhesion body='b' ctrlrange='0 2'/></actuator>";
    let ranges: Vec<_> = import(text).model.actuators.iter().map(|a| a.control_range).collect();
    assert_eq!(ranges, [Some([0.0, 1.0]), Some([0.0, 2.0])]);
}

#[test]
fn filters_without_a_time_constant_follow_at_once() {
    let imported = actuators("<general joint='j' dyntype='filter' dynprm='0'/>\n<cylinder joint='j' timeconst='0'/>");
    for actuator in &imported.model.actuators {
        let Some(ActivationKind::ExactFilter { time_constant }) = actuator.activation.map(|a| a.kind) else { panic!() };
        assert!(time_constant < 1e-12);
    }
    assert_eq!(lines(&imported), [2, 3]);
}

/// A servo has a damping or a ratio; what a default says of the other one goes.
#[test]
fn dampings_replace_ratios() {
    let servo = |defaults: &str, own: &str| {
        let model = import(&format!("<default>{defaults}</default>{ARM}<actuator>{own}</actuator>")).model;
        model.actuators[0].kind
    };
    let ratio = "<position kp='5' dampratio='1'/>";
    let found = servo(ratio, "<position joint='j' kv='3'/>");
    assert_eq!(found, ActuatorKind::Position { kp: 5.0, kv: 3.0 });
    assert_eq!(servo(ratio, "<velocity joint='j' kv='3'/>"), ActuatorKind::Velocity { kv: 3.0 });
    // MuJoCo 4.0.0: biasprm[2] = -1.3711309.
    for (defaults, own) in
        [(ratio, "<general joint='j'/>"), ("", "<general joint='j' gainprm='5' biastype='affine' biasprm='0 -5 1'/>")]
    {
        let ActuatorKind::Position { kv, .. } = servo(defaults, own) else { panic!("a servo") };
        assert!((kv - 1.3711309).abs() < 1e-6, "{kv}");
    }
}

/// Without actuation there is no force, and activations stay: `act_dot` is zero.
#[test]
fn activations_stay_where_actuation_is_off() {
    let text = "<option><flag actuation='disable'/></option>\
                <worldbody><body><joint name='j'/><geom size='1'/></body></worldbody><actuator>\
                <general joint='j' dyntype='integrator'/><cylinder joint='j' timeconst='.3'/><motor joint='j'/></actuator>";
    let model = import(text).model;
    assert!(model.actuators.iter().all(|a| a.force_range == Some([0.0; 2])));
    for actuator in &model.actuators[..2] {
        let kind = actuator.activation.map(|a| a.kind);
        assert_eq!((kind, actuator.control_range), (Some(ActivationKind::Integrator), Some([0.0; 2])));
    }
}

/// Along the axes of the parent a free joint is pulled as along the world's, which are those of its velocity; turned it is not.
#[test]
fn what_turns_a_joint_in_the_parent_is_left_out() {
    let free = "<worldbody><body><freejoint name='f'/><geom size='1'/></body></worldbody><actuator>\n\
                <motor jointinparent='f' gear='1 2 3'/>\n<motor jointinparent='f' gear='0 0 0 1'/>\n<motor joint='f' gear='0 0 0 1'/></actuator>";
    let imported = import(free);
    assert_eq!((imported.model.actuators.len(), lines(&imported)), (2, vec![3]));
}

#[test]
fn gravity_compensation_by_actuators_is_said_not_to_be_supported() {
    let body = |gravcomp: &str| {
        format!(
            "<worldbody>\n<body gravcomp='{gravcomp}'>\n<joint actuatorgravcomp='true'/><geom size='1'/></body></worldbody>"
        )
    };
    assert_eq!((lines(&import(&body("1"))), lines(&import(&body("0")))), (vec![3], vec![]));
}

#[test]
fn sensors_that_lag_or_are_off_are_said_to_tell_the_present() {
    let text = |flag: &str, sensor: &str| {
        format!("<option>\n<flag sensor='{flag}'/></option>{ARM}<sensor>\n<jointpos joint='j' {sensor}/></sensor>")
    };
    let warned = |flag: &str, sensor: &str| -> Vec<usize> {
        import(&text(flag, sensor)).report.warnings.iter().map(|w| w.line as usize).collect()
    };
    assert_eq!(warned("enable", "delay='0' nsample='3'"), [0; 0]);
    assert_eq!(warned("disable", "delay='.1' nsample='100'"), [2, 3]);
    assert_eq!(warned("enable", "interval='.1'"), [3]);
}

#[test]
fn frames_of_meshes_are_said_to_be_those_of_their_files() {
    let text = "<asset><mesh name='m' vertex='0 0 0 3 0 0 0 2 0 0 0 1'/></asset><worldbody><body><geom name='g' type='mesh' mesh='m'/>\
                <geom name='b' size='1'/></body></worldbody><sensor><framepos objtype='geom' objname='b'/>\n\
                <framepos objtype='geom' objname='g'/></sensor>";
    let imported = import(text);
    let found: Vec<_> = imported.report.warnings.iter().map(|w| (w.line as usize, w.changes_motion)).collect();
    assert_eq!((found, imported.model.sensors.len()), (vec![(2, false)], 2));
}

/// MuJoCo has no limit where the lower number is not first, and negative springs and dampers, which are none here.
#[test]
fn ranges_and_springs_that_are_the_wrong_way_round() {
    let joint = |attributes: &str| {
        import(&format!("<worldbody><body>\n<joint {attributes}/><geom size='1'/></body></worldbody>"))
    };
    for attributes in ["range='10 -10'", "stiffness='-1'", "damping='-1'"] {
        let imported = joint(attributes);
        let joint = &imported.model.joints[0];
        assert_eq!((joint.limits, joint.stiffness, joint.damping), (None, 0.0, 0.0));
        assert_eq!(lines(&imported), [2], "{attributes}");
    }
}
