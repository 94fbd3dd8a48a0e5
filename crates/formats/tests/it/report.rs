//! What is left out is said.

use signorini_formats::{Imported, LoadOptions, load_mjcf_str, load_urdf_str, write_mjcf, write_urdf};
use signorini_multibody::Model;

fn import(inner: &str) -> Imported {
    load_mjcf_str(&format!("<mujoco>\n{inner}\n</mujoco>"), "").unwrap()
}

#[test]
fn ignored_attributes_are_grouped_and_placed() {
    let text = "<default>\n<geom solref='.01 1'/></default><worldbody>\n<geom size='1' solref='.02 1'/>\n\
                <geom size='1' solref='.03 1'/><geom size='1' solref='.04 1' colour='red'/></worldbody>";
    let Imported { report, .. } = import(text);
    let [solref, colour] = &report.warnings[..] else { panic!("{report}") };
    assert_eq!((solref.line, solref.count, solref.element.as_str()), (3, 3, "geom"));
    assert!(solref.changes_motion && solref.effect.contains("rigid"), "{solref}");
    assert!(colour.what.contains("'colour' is not a known attribute") && colour.line == 5, "{colour}");
}

#[test]
fn unsupported_sections_are_listed() {
    let text = "<worldbody><body name='b'><joint name='j'/><geom size='.1'/><site name='s'/><camera/><light/></body></worldbody>\n\
                <equality><joint joint1='j'/></equality>\n<deformable/>\n\
                <actuator><general slidersite='s' cranksite='s'/><motor name='m' joint='j'/></actuator>\n<sensor><gyro site='s'/><tactile geom='g' mesh='m'/></sensor>\n\
                <keyframe><key ctrl='3 4'/></keyframe>";
    let Imported { model, report, .. } = import(text);
    let motion: Vec<(u32, &str)> = report.motion_warnings().map(|w| (w.line, w.element.as_str())).collect();
    assert_eq!(motion, [(5, "general"), (4, "deformable")]);
    let other: Vec<&str> = report.warnings.iter().filter(|w| !w.changes_motion).map(|w| w.element.as_str()).collect();
    assert_eq!(other, ["tactile"]);
    // The control of the actuator that is left out is left out of the keyframe too.
    assert_eq!((model.actuators[0].name.as_str(), model.keyframes[0].control.as_slice()), ("m", &[4.0][..]));
}

/// The flag asks simulations to sleep, and bodies ask to begin so; where no tree begins with one that is told.
#[test]
fn a_file_asks_for_sleep() {
    let bodies = "<worldbody><body sleep='never'><freejoint/><geom size='.1'/></body>\n\
                  <body sleep='init'><freejoint/><geom size='.1'/>\n\
                  <body sleep='init'><joint/><geom size='.1'/></body></body><body sleep='init'/></worldbody>";
    assert!(!import(bodies).model.sleeping);
    let Imported { model, report, .. } =
        import(&format!("<option sleep_tolerance='1e-2'><flag sleep='enable'/></option>{bodies}"));
    let warnings: Vec<_> = report.warnings.iter().map(|w| (w.line, w.what.as_str(), w.changes_motion)).collect();
    let told = "sleep='init' of a body that no tree of joints begins with";
    assert_eq!(warnings, [(4, told, true)]);
    assert_eq!(report.warnings[0].count, 2);
    let again = load_mjcf_str(&write_mjcf(&model).text, "").unwrap().model;
    let asleep = |model: &Model| model.bodies.iter().map(|body| body.begins_asleep).collect::<Vec<_>>();
    assert_eq!(asleep(&model), [false, false, true, false, false]);
    assert!(model.sleeping && again.sleeping && asleep(&again) == asleep(&model));
    assert_eq!(again.content_hash(), model.content_hash());
    let urdf = write_urdf(&model);
    assert!(urdf.left_out.iter().any(|what| what.ends_with("begins asleep; it begins awake")), "{:?}", urdf.left_out);
    assert_ne!(model.content_hash(), import(bodies).model.content_hash());
    assert!(load_mjcf_str("<mujoco><worldbody><body sleep='deeply'/></worldbody></mujoco>", "").is_err());
}

#[test]
fn a_plain_file_has_no_warnings() {
    let text = "<worldbody><geom type='plane' size='1 1 1'/><body pos='0 0 1'><freejoint/><geom size='.1'/></body>\
                </worldbody>";
    let Imported { model, report, .. } = import(text);
    assert!(report.warnings.is_empty(), "{report}");
    assert_eq!((model.nq, model.nv), (7, 6));
}

#[test]
fn generated_names_do_not_clash() {
    let text = "<worldbody><geom name='geom1' size='1'/><geom size='1'/><geom name='geom3' size='1'/><geom size='1'/>\
                <body name='body2'/><body/></worldbody>";
    let names: Vec<String> = import(text).model.geoms.into_iter().map(|g| g.name).collect();
    assert_eq!(names, ["geom1", "geom1_2", "geom3", "geom3_2"]);
}

/// What is read is not called unknown, what is left out is told once, and of what is given twice the second one.
#[test]
fn urdf_says_what_is_not_read_once() {
    let text = "<robot name='r'><link name='a'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1'/></inertial>
        <collision><geometry><ellipsoid radii='1 2 3'/></geometry></collision>
        <collision><geometry><cone radius='1' length='2'/></geometry></collision>
        <inertial/></link><link name='b'/>
        <joint name='j' type='fixed'><parent link='a'/><child link='b'/><origin xyz='1 0 0'/>
        <origin xyz='2 0 0'/></joint></robot>";
    let imported = load_urdf_str(text, "", &LoadOptions::default()).unwrap();
    let told: Vec<(u32, &str)> = imported.report.warnings.iter().map(|w| (w.line, w.element.as_str())).collect();
    assert_eq!(told, [(3, "geometry"), (4, "inertial"), (6, "origin")], "{}", imported.report);
}

#[test]
fn inertia_of_no_body_is_told() {
    let inertial = "<inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/>";
    let text = format!(
        "<worldbody>\n{inertial}<body><joint/><frame>{inertial}</frame><replicate count='2'>\n{inertial}</replicate></body></worldbody>"
    );
    let Imported { model, report, .. } = import(&text);
    let told: Vec<(u32, usize, &str)> = report.motion_warnings().map(|w| (w.line, w.count, w.what.as_str())).collect();
    assert_eq!(told, [(3, 2, "stands in no body")], "{report}");
    assert_eq!(model.bodies[1].inertia.mass, 1.0);
}
