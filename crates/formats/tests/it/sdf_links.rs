//! SDF: what acts on links, what they weigh and which of them touch, against numbers worked out by hand.

use signorini_formats::{Imported, LoadOptions, load_sdf_str};
use signorini_multibody::{FreeMotion, Input, Kinematics, Model, State, forward_kinematics_into, free_motion_into};

fn import(inner: &str) -> Imported {
    load_sdf_str(&format!("<sdf version='1.11'>\n{inner}\n</sdf>"), "", &LoadOptions::default()).unwrap()
}

/// The velocities after a tenth of a second from rest.
fn free_velocity(model: &Model) -> Vec<f64> {
    let (state, mut kinematics, mut motion) = (State::new(model), Kinematics::new(model), FreeMotion::new(model));
    forward_kinematics_into(model, &state.q, &state.v, &mut kinematics);
    free_motion_into(model, &kinematics, &state, &Input::default(), 0.1, &mut motion).unwrap();
    motion.free_velocity
}

#[test]
fn links_without_gravity_do_not_fall() {
    let link = |name: &str, gravity: &str| {
        let inertial = "<inertial><pose>0.3 0 0 0 0 0</pose><mass>2</mass></inertial>";
        format!("<link name='{name}'>{gravity}{inertial}</link>")
    };
    let world = |gravity: &str| {
        let ball = format!("<model name='ball'>{}</model>", link("l", gravity));
        let joint = "<joint name='j' type='revolute'><parent>world</parent><child>l</child><axis><xyz>0 1 0</xyz></axis></joint>";
        let arm = format!("<model name='arm'>{}{joint}</model>", link("l", gravity));
        import(&format!("<world name='w'><gravity>0 0 -10</gravity>{ball}{arm}</world>"))
    };
    let moment = 2.0 * 10.0 * 0.3 / (1.0 + 2.0 * 0.3 * 0.3);
    for (word, share) in
        [("", 1.0), ("<gravity>1</gravity>", 1.0), ("<gravity>false</gravity>", 0.0), ("<gravity>0</gravity>", 0.0)]
    {
        let Imported { model, report, .. } = world(word);
        assert!(report.warnings.is_empty(), "{report}");
        let expected = [0.0, 0.0, -10.0 * 0.1 * share, 0.0, 0.0, 0.0, 0.1 * moment * share];
        for (v, expected) in free_velocity(&model).iter().zip(expected) {
            assert!((v - expected).abs() < 1e-12, "{word}: {v} instead of {expected}");
        }
    }
}
