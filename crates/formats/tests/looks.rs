//! Cameras, lights and materials of MJCF files, beside the numbers that MuJoCo's documentation gives them.

use std::path::Path;

use signorini_formats::load_mjcf_str;
use signorini_multibody::glam::DVec3;
use signorini_multibody::{BodyId, CameraMode};

const FILE: &str = r#"
<mujoco>
  <default><camera fovy="30"/><default class="dim"><light diffuse=".2 .3 .4"/></default></default>
  <asset>
    <texture name="squares" type="2d" builtin="checker" rgb1=".1 .2 .3" rgb2=".4 .5 .6" width="64" height="64"/>
    <material name="ground" texture="squares" texrepeat="5 10" texuniform="true" reflectance=".25"/>
    <material name="table" texture="squares" texrepeat="4 4" rgba="1 0 0 .5" shininess=".75"/>
  </asset>
  <worldbody>
    <light class="dim" pos="1 2 3" dir="0 0 -1" directional="true" castshadow="false"/>
    <light active="false"/>
    <camera name="still" pos="1 0 0" mode="targetbody" target="late"/>
    <geom name="ground" type="plane" size="1 1 .1" material="ground"/>
    <frame pos="0 0 1">
      <geom name="table" type="box" size=".5 .25 .1" material="table"/>
    </frame>
    <body name="late" pos="0 0 2">
      <freejoint/>
      <geom name="hidden" size=".1" group="3"/>
      <camera pos="0 -1 0" xyaxes="1 0 0 0 0 1" sensorsize=".02 .01" focal=".01 .01" mode="trackcom"/>
    </body>
  </worldbody>
</mujoco>"#;

#[test]
fn what_pictures_need_is_taken_over() {
    let imported = load_mjcf_str(FILE, Path::new("")).expect("a model");
    assert!(imported.report.warnings.is_empty(), "{:?}", imported.report.warnings);
    let model = imported.model;
    let late = model.body_named("late").expect("a body");
    let [still, other] = &model.cameras[..] else { panic!("two cameras") };
    assert_eq!((still.name.as_str(), still.body, still.mode), ("still", BodyId::WORLD, CameraMode::Target(late)));
    assert!((still.field_of_view - 30.0_f64.to_radians()).abs() < 1e-15);
    assert_eq!((other.body, other.mode), (late, CameraMode::TrackCenterOfMass));
    // tan(fovy / 2) = half the sensor's height / focal length
    assert!((other.field_of_view - 2.0 * 0.5_f64.atan()).abs() < 1e-15);
    // It looks along y, with z up.
    assert!((other.placement.rotation * DVec3::NEG_Z - DVec3::Y).length() < 1e-12);
    let [light] = &model.lights[..] else { panic!("one light that is on") };
    assert_eq!((light.directional, light.shadows, light.color), (true, false, [0.2, 0.3, 0.4]));

    let geom = |name| &model.geoms[model.geom_named(name).expect("a geom").index()];
    let ground = geom("ground").look.checker.expect("squares");
    // Five pictures of two squares in a metre; for the table four in its whole length and width.
    assert_eq!(ground.square, [0.1, 0.05]);
    assert_eq!(ground.colors, [[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]]);
    assert_eq!(geom("table").look.checker.expect("squares").square, [0.125, 0.0625]);
    assert_eq!((geom("table").rgba, geom("table").look.shininess), ([1.0, 0.0, 0.0, 0.5], 0.75));
    assert_eq!((geom("ground").look.reflectance, geom("hidden").look.group), (0.25, 3));
}

#[test]
fn looks_are_no_part_of_the_mechanism() {
    let dressed = load_mjcf_str(FILE, Path::new("")).expect("a model").model;
    let mut plain = dressed.clone();
    plain.cameras.clear();
    plain.lights.clear();
    plain.geoms.iter_mut().for_each(|geom| geom.look = Default::default());
    assert_eq!(dressed.content_hash(), plain.content_hash());
}

#[test]
fn what_no_camera_can_be_is_refused_with_its_place() {
    for (camera, words) in
        [(r#"<camera fovy="190"/>"#, "between 0 and 180"), (r#"<camera mode="targetbody" target="lat"/>"#, "'lat'")]
    {
        let text = format!("<mujoco><worldbody>{camera}<body name='late'/></worldbody></mujoco>");
        let error = load_mjcf_str(&text, Path::new("")).expect_err(camera).to_string();
        assert!(error.contains(words) && error.contains("1:"), "{error}");
    }
}

#[test]
fn a_camera_without_target_keeps_its_direction_as_in_mujoco() {
    let text = "<mujoco><worldbody><camera mode='targetbody'/></worldbody></mujoco>";
    let imported = load_mjcf_str(text, Path::new("")).expect("a model");
    assert_eq!(imported.model.cameras[0].mode, CameraMode::Fixed);
    assert!(imported.report.warnings[0].to_string().contains("has no target"), "{:?}", imported.report.warnings);
}
