//! SDF: joints that close loops and axes that follow others, as constraints, against numbers worked out by hand.

use signorini_formats::{Imported, LoadOptions, load_sdf_str};
use signorini_multibody::glam::DVec3;
use signorini_multibody::{EqualityKind, JointId, Kinematics, Model, equality_violations, forward_kinematics_into};

use crate::support::{self, Files, assert_sdf_refused};

#[track_caller]
fn import(inner: &str) -> Imported {
    support::import_sdf("1.11", inner)
}

/// Two arms of a metre on pins at (0, 0, 0) and (2, 0, 0), and a bar on top of both that a last joint ties to the second arm.
fn four_bar(last: &str) -> String {
    let link = |name: &str, x: f64, z: f64| format!("<link name='{name}'><pose>{x} 0 {z} 0 0 0</pose></link>");
    let links = [link("left", 0.0, 0.0), link("right", 2.0, 0.0), link("bar", 0.0, 1.0)].concat();
    let pin = |name: &str, parent: &str, child: &str| {
        format!(
            "<joint name='{name}' type='revolute'><parent>{parent}</parent><child>{child}</child><axis><xyz>0 1 0</xyz></axis></joint>"
        )
    };
    let pins = [pin("p", "world", "left"), pin("q", "world", "right"), pin("r", "left", "bar")].concat();
    format!("<model name='m'>{links}{pins}\n{last}</model>")
}

fn last(sort: &str, inner: &str) -> String {
    format!(
        "<joint name='s' type='{sort}'><pose relative_to='bar'>2 0 0 0 0 0</pose><parent>bar</parent><child>right</child>{inner}</joint>"
    )
}

fn points(model: &Model) -> Vec<[[f64; 3]; 2]> {
    let points = |kind: &EqualityKind| match *kind {
        EqualityKind::Connect { body_a, point_a, body_b, point_b } => {
            assert_eq!([body_a, body_b].map(|body| &model.bodies[body.index()].name), ["bar", "right"]);
            [point_a, point_b].map(|p: DVec3| p.to_array())
        }
        ref other => panic!("{other:?}"),
    };
    model.equalities.iter().map(|equality| points(&equality.kind)).collect()
}

#[test]
fn a_hinge_that_closes_a_loop_holds_two_points_of_its_axis() {
    let Imported { model, report, .. } = import(&four_bar(&last("revolute", "<axis><xyz>0 2 0</xyz></axis>")));
    assert!(report.warnings.is_empty(), "{report}");
    assert_eq!((model.nv, model.joints.len()), (3, 3));
    let names: Vec<&str> = model.equalities.iter().map(|equality| equality.name.as_str()).collect();
    assert_eq!(names, ["s", "s_axis"]);
    let at = |y: f64| [[2.0, y, 0.0], [0.0, y, 1.0]];
    assert_eq!(points(&model), [at(-0.1), at(0.1)]);
    let (q, mut kinematics) = (model.reference_configuration(), Kinematics::new(&model));
    forward_kinematics_into(&model, &q, &[0.0; 3], &mut kinematics);
    assert!(equality_violations(&model, &kinematics, &q).iter().all(|violation| *violation < 1e-15));
}

#[test]
fn a_ball_holds_its_point_and_a_fixed_joint_all() {
    let model = import(&four_bar(&last("ball", ""))).model;
    assert_eq!(points(&model), [[[2.0, 0.0, 0.0], [0.0, 0.0, 1.0]]]);
    let model = import(&four_bar(&last("fixed", ""))).model;
    let [EqualityKind::Weld { frame_a, frame_b, .. }] =
        model.equalities.iter().map(|e| &e.kind).collect::<Vec<_>>()[..]
    else {
        panic!("{:?}", model.equalities)
    };
    assert_eq!([frame_a, frame_b].map(|frame| frame.position.to_array()), [[2.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
}

#[test]
fn what_a_constraint_does_not_hold_is_said() {
    let said = |last: &str| {
        let report = import(&four_bar(last)).report;
        report.warnings.iter().map(|w| (w.line, w.element.clone(), w.what.clone())).collect::<Vec<_>>()
    };
    let limited = "<axis><xyz>0 1 0</xyz><limit><lower>-1</lower><upper>1</upper></limit><dynamics><damping>1</damping></dynamics></axis>";
    let left_out = "belongs to a joint that closes a loop".to_owned();
    let parts = ["limit", "dynamics"].map(|part| (3, part.to_owned(), left_out.clone()));
    assert_eq!(said(&last("revolute", limited)), parts);
    let [universal, slide] = [("universal", ""), ("prismatic", ", which is not supported")]
        .map(|(sort, rest)| (3, "joint".to_owned(), format!("of type '{sort}' closes a loop{rest}")));
    assert_eq!(said(&last("universal", "")), [universal]);
    assert_eq!(said(&last("prismatic", "")), [slide]);
}

/// A loop of fixed joints holds what holds anyway.
#[test]
fn a_joint_within_a_rigid_body_is_none() {
    let link = |name: &str| format!("<link name='{name}'/>");
    let tie = |name: &str, parent: &str, child: &str, sort: &str| {
        format!("<joint name='{name}' type='{sort}'><parent>{parent}</parent><child>{child}</child></joint>")
    };
    let rigid = ["a", "b", "c"].map(link).concat() + &tie("1", "a", "b", "fixed") + &tie("2", "b", "c", "fixed");
    for sort in ["fixed", "ball", "prismatic"] {
        let Imported { model, report, .. } =
            import(&format!("<model name='m'>{rigid}{}</model>", tie("3", "c", "a", sort)));
        assert!(report.warnings.is_empty() && model.equalities.is_empty(), "{report}");
    }
}

#[test]
fn an_axis_follows_another_one() {
    let text = |leader: &str| {
        let mimic = format!(
            "\n<mimic joint='{leader}'><multiplier>-2</multiplier><offset>0.5</offset><reference>0.1</reference></mimic>"
        );
        let right = "<joint name='q' type='revolute'><parent>world</parent><child>right</child><axis><xyz>0 1 0</xyz>";
        four_bar("").replace(right, &format!("{right}{mimic}"))
    };
    let Imported { model, report, .. } = import(&text("p"));
    assert!(report.warnings.is_empty(), "{report}");
    let id = |name: &str| model.joint_named(name).unwrap();
    let expected: (JointId, JointId) = (id("q"), id("p"));
    let [EqualityKind::Joint { joint, driver: Some(driver), polynomial }] =
        model.equalities.iter().map(|e| &e.kind).collect::<Vec<_>>()[..]
    else {
        panic!("{:?}", model.equalities)
    };
    // −2 (q′ − 0.1) + 0.5
    assert_eq!(((*joint, *driver), *polynomial), (expected, [0.7, -2.0, 0.0, 0.0, 0.0]));
    let said: Vec<_> = import(&text("pp")).report.warnings.iter().map(|w| (w.line, w.what.clone())).collect();
    assert_eq!(said, [(3, "follows the joint 'pp', which is not defined".to_owned())]);
    assert_sdf_refused("1.11", &text("q"), &["text):3:", "another joint than its own"]);
}

/// What a URDF says of its joints beside their axes comes along with it.
#[test]
fn joints_of_an_included_urdf_follow_others_and_have_its_limits() {
    let link = |name: &str| {
        format!("<link name='{name}'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1'/></inertial></link>")
    };
    let joint = |name: &str, [parent, child]: [&str; 2], more: &str| {
        format!("<joint name='{name}' type='revolute'><parent link='{parent}'/><child link='{child}'/>{more}</joint>")
    };
    let robot = format!(
        "<robot name='r'>{}{}{}</robot>",
        ["a", "b", "c", "d"].map(link).concat(),
        joint("lead", ["a", "b"], "<limit lower='-1' upper='2' effort='3' velocity='0'/>"),
        joint(
            "follow",
            ["b", "c"],
            "<mimic joint='lead' multiplier='-2' offset='0.5'/><limit upper='1' effort='0' velocity='0'/>"
        ) + &joint("open", ["c", "d"], "<limit lower='1' upper='-1' effort='0' velocity='0'/>"),
    );
    let files = Files::new("urdf-mimic", &[("r.urdf", &robot)]);
    let text = "<sdf version='1.11'><world name='w'><include><uri>r.urdf</uri></include></world></sdf>";
    let Imported { model, report, .. } = load_sdf_str(text, files.folder(), &LoadOptions::default()).unwrap();
    let joint = |name: &str| model.joint_named(name).unwrap();
    let kind = EqualityKind::Joint {
        joint: joint("follow"),
        driver: Some(joint("lead")),
        polynomial: [0.5, -2.0, 0.0, 0.0, 0.0],
    };
    assert_eq!(model.equalities.iter().map(|e| e.kind).collect::<Vec<_>>(), [kind]);
    let limits = ["lead", "follow", "open"].map(|name| model.joints[joint(name).index()].limits);
    assert_eq!(limits, [Some([-1.0, 2.0]), Some([0.0, 1.0]), None]);
    let told: Vec<&str> = report.warnings.iter().map(|w| w.element.as_str()).collect();
    assert_eq!(told, ["effort", "limit"], "{report}");
}
