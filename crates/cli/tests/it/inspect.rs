//! `inspect`.

use crate::support::{Folder, number};

const ARM: &str = r#"<mujoco model="arm">
  <compiler angle="radian"/>
  <worldbody>
    <geom name="floor" type="plane"/>
    <body name="upper" pos="0 0 1">
      <joint name="shoulder" type="ball"/>
      <geom name="upper skin" type="capsule" size="0.05" fromto="0 0 0 0 0 -0.4" mass="2"/>
      <body name="lower" pos="0 0 -0.4">
        <joint name="elbow" type="hinge" axis="0 1 0" range="-2 0"/>
        <geom name="lower skin" type="box" size="0.04 0.04 0.2" pos="0 0 -0.2" mass="1.5" friction="0.3"/>
      </body>
    </body>
    <body name="puck" pos="1 0 0.1"><freejoint name="puck"/><geom type="cylinder" size="0.1 0.02" mass="0.25"/></body>
  </worldbody>
  <actuator><motor name="biceps" joint="elbow"/></actuator>
  <worldbody>
    <composite prefix="string" type="cable"/>
  </worldbody>
  <keyframe><key name="bent" qpos="1 0 0 0  -1  1 0 0.1 1 0 0 0"/></keyframe>
</mujoco>"#;

#[test]
fn json_lists_the_parts() {
    let folder = Folder::new("inspect_json");
    folder.write("arm.xml", ARM);
    let arm = folder.run(&["inspect", "arm.xml", "--json"]).exits(0).json();
    assert_eq!(arm["nq"], 4 + 1 + 7);
    assert_eq!(arm["nv"], 3 + 1 + 6);
    assert_eq!(number(&arm, "/mass"), 3.75);
    assert_eq!(arm["keyframes"][0], "bent");
    assert_eq!(arm["actuators"][0]["target"], "joint elbow");
    let lower = arm["bodies"].as_array().expect("bodies").iter().find(|b| b["name"] == "lower").expect("lower");
    assert_eq!(lower["parent"], "upper");
    assert_eq!(lower["depth"], 2);
    assert_eq!(lower["joints"][0]["kind"], "hinge");
    assert_eq!(lower["joints"][0]["limits"][0], -2.0);
    assert_eq!(lower["geoms"][0]["shape"], "box");
    assert_eq!(number(lower, "/geoms/0/friction"), 0.3);
    let warning = &arm["warnings"][0];
    assert_eq!((warning["file"].as_str(), warning["line"].as_u64()), (Some("arm.xml"), Some(17)));
    assert_eq!(warning["changes_motion"], true);
}

#[test]
fn text_shows_the_tree_and_the_import_report() {
    let folder = Folder::new("inspect_text");
    folder.write("arm.xml", ARM);
    let text = folder.run(&["inspect", "arm.xml"]).exits(0).stdout;
    let line =
        |part: &str| text.lines().find(|line| line.contains(part)).unwrap_or_else(|| panic!("no {part}: {text}"));
    let indent = |part: &str| line(part).len() - line(part).trim_start().len();
    assert!(indent("lower  1.5 kg") > indent("upper  2 kg"));
    assert!(line("joint shoulder").contains("ball"));
    assert!(line("arm.xml:17").trim_start().starts_with('!'));
    assert!(text.contains("nq 12, nv 10"));
}
