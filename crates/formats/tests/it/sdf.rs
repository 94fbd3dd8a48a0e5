//! SDF: against Drake's numbers (`testdata/make_sdf_reference.py`), conventions, and files that make no sense.

use serde_json::Value;
use signorini_formats::{Imported, LoadOptions, load, load_sdf_str, load_urdf_str};
use signorini_multibody::glam::{DMat3, DVec3};
use signorini_multibody::{Geometry, JointKind, Kinematics, Model, State, forward_kinematics_into, kinetic_energy};

use crate::support::{self, Files};

fn vector(value: &Value) -> DVec3 {
    DVec3::from_array([0, 1, 2].map(|k| value[k].as_f64().unwrap()))
}

/// A matrix stored row by row.
fn matrix(value: &Value) -> DMat3 {
    DMat3::from_cols(vector(&value[0]), vector(&value[1]), vector(&value[2])).transpose()
}

fn off(a: DMat3, b: DMat3) -> f64 {
    (a - b).to_cols_array().iter().fold(0.0, |m, x| m.max(x.abs()))
}

fn arm() -> Model {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/testdata/sdf/arm.sdf");
    let Imported { model, report, .. } = load(path, &LoadOptions::default()).unwrap();
    let [effort] = &report.warnings[..] else { panic!("{report}") };
    assert_eq!((effort.line, effort.element.as_str()), (21, "effort"));
    model
}

#[test]
fn poses_inertias_and_axes_are_drakes() {
    let reference: Value = serde_json::from_str(include_str!("../../testdata/reference/sdf.json")).unwrap();
    let (model, theirs) = (arm(), &reference["models"]["arm"]);
    let links = theirs["links"].as_object().unwrap();
    assert_eq!(model.bodies.len(), links.len() + 1);
    for (name, link) in links {
        let inertia = model.bodies[model.body_named(name).unwrap().index()].inertia;
        assert!((inertia.mass - link["mass"].as_f64().unwrap()).abs() < 1e-14, "{name}");
        assert!((inertia.center_of_mass - vector(&link["com"])).length() < 1e-14, "{name}");
        assert!(off(inertia.rotational, matrix(&link["inertia"])) < 1e-14, "{name}");
    }
    for entry in theirs["states"].as_array().unwrap() {
        let mut state = State::new(&model);
        for (name, list) in entry["positions"].as_object().unwrap() {
            for (k, q) in list.as_array().unwrap().iter().enumerate() {
                // Drake puts a joint into the model of its child; its own name is the same.
                let own = |name: &str| name.rsplit("::").next().unwrap_or_default().to_owned();
                let wanted = own(name) + if k == 0 { "" } else { "_2" };
                let joint = model.joints.iter().find(|j| own(&j.name) == wanted).unwrap();
                state.q[joint.q_index] = q.as_f64().unwrap();
                state.v[joint.v_index] = entry["rates"][name][k].as_f64().unwrap();
            }
        }
        let mut kinematics = Kinematics::new(&model);
        forward_kinematics_into(&model, &state.q, &state.v, &mut kinematics);
        for (name, pose) in entry["poses"].as_object().unwrap() {
            let ours = kinematics.pose[model.body_named(name).unwrap().index()];
            assert!((ours.position - vector(&pose["pos"])).length() < 1e-12, "{name}: {ours:?}");
            assert!(off(ours.rotation_matrix(), matrix(&pose["rotation"])) < 1e-12, "{name}");
        }
        let energy = entry["kinetic"].as_f64().unwrap();
        assert!((kinetic_energy(&model, &kinematics, &state.v) - energy).abs() < 1e-12 * energy);
    }
}

#[test]
fn joints_and_shapes_have_their_numbers() {
    let model = arm();
    let shoulder = &model.joints[model.joint_named("shoulder").unwrap().index()];
    assert_eq!((shoulder.limits, shoulder.damping), (Some([-1.0, 1.5]), 0.3));
    assert_eq!((shoulder.stiffness, shoulder.spring_reference), (2.0, 0.1));
    let names: Vec<&str> = model.joints.iter().map(|j| j.name.as_str()).collect();
    assert_eq!(names, ["shoulder", "wrist", "wrist_2", "hand::grip"]);
    let geom = |name: &str| &model.geoms[model.geom_named(name).unwrap().index()];
    assert_eq!(geom("foot").geometry, Geometry::Box { half_extents: DVec3::new(0.2, 0.15, 0.05) });
    assert_eq!(geom("foot").friction, 0.4);
    assert_eq!(geom("tube").rgba, [0.1, 0.2, 0.3, 1.0]);
    assert_eq!(geom("pad").geometry, Geometry::Capsule { radius: 0.01, half_length: 0.02 });
}

#[track_caller]
fn import(inner: &str) -> Imported {
    support::import_sdf("1.8", inner)
}

#[track_caller]
fn assert_refused(inner: &str, parts: &[&str]) {
    support::assert_sdf_refused("1.8", inner, parts);
}

const LINKS: &str = "<link name='a'/><link name='b'><pose>0 0 1 0 0 0</pose></link><link name='c'/>";

fn joint(name: &str, kind: &str, parent: &str, child: &str) -> String {
    let ends = format!("<parent>{parent}</parent><child>{child}</child>");
    format!("<joint name='{name}' type='{kind}'>{ends}<axis><xyz>0 1 0</xyz></axis></joint>")
}

/// The joint from b to a is the first one met; c is b's child. The coordinate keeps its meaning.
#[test]
fn a_joint_can_lead_towards_the_root() {
    let text = format!(
        "<model name='m'>{LINKS}{}{}{}</model>",
        joint("w", "fixed", "world", "a"),
        joint("j", "revolute", "b", "a"),
        joint("k", "ball", "b", "c")
    );
    let model = import(&text).model;
    let bodies: Vec<&str> = model.bodies.iter().map(|b| b.name.as_str()).collect();
    assert_eq!(bodies, ["world", "a", "b", "c"]);
    // The joint's frame is that of its child a; b turns the other way round.
    assert_eq!(model.joints[0].kind, JointKind::Hinge { axis: DVec3::NEG_Y });
    assert_eq!(model.joints[0].anchor, DVec3::NEG_Z);
    assert_eq!(model.joints[1].kind, JointKind::Ball);
}

#[test]
fn a_joint_without_an_axis_turns_about_its_own_z() {
    let text = format!(
        "<model name='m'>{LINKS}{}\n<joint name='j' type='revolute'><pose>0 0 0 1.5707963267948966 0 0</pose><parent>a</parent><child>b</child></joint></model>",
        joint("w", "fixed", "world", "a")
    );
    let Imported { model, report, .. } = import(&text);
    let JointKind::Hinge { axis } = model.joints[0].kind else { panic!("{:?}", model.joints[0].kind) };
    assert!((axis - DVec3::NEG_Y).length() < 1e-15, "{axis}");
    let said: Vec<_> = report.motion_warnings().map(|w| (w.line, w.what.as_str())).collect();
    assert_eq!(said, [(3, "has no <axis>")], "{report}");
    let both = import(&text.replace("'revolute'", "'universal'"));
    let said: Vec<_> = both.report.motion_warnings().map(|w| (w.line, w.what.as_str())).collect();
    assert_eq!((both.model.joints.len(), said.len()), (model.joints.len(), 2), "one of its two: {}", both.report);
}

#[test]
fn the_frame_of_a_model_inside_has_a_name() {
    let inside = "<model name='inner'><pose>0 0 3 0 0 0</pose><link name='l'/></model>";
    let text = format!(
        "<model name='m'>{LINKS}{inside}<frame name='f'><pose relative_to='inner::__model__'>1 0 0 0 0 0</pose></frame>\n{}{}</model>",
        joint("j", "revolute", "inner::__model__", "a"),
        "<joint name='k' type='revolute'><pose relative_to='f'/><parent>a</parent><child>b</child><axis><xyz>0 1 0</xyz></axis></joint>"
    );
    let model = import(&text).model;
    let parent = |name: &str| &model.bodies[model.bodies[model.body_named(name).unwrap().index()].parent.index()].name;
    assert_eq!(parent("a"), "inner::l");
    // Of the link b at (0, 0, 1), where the frame is at (1, 0, 3).
    assert_eq!(model.joints.last().unwrap().anchor, DVec3::new(1.0, 0.0, 2.0));
}

#[test]
fn loops_are_closed_and_what_is_not_read_is_reported() {
    let text = format!(
        "<model name='m'>\n{LINKS}\n{}{}\n{}\n<plugin name='p'/></model>",
        joint("1", "revolute", "a", "b"),
        joint("2", "revolute", "b", "c"),
        joint("3", "revolute", "c", "a")
    );
    let Imported { model, report, .. } = import(&format!("{text}<include/>"));
    let found: Vec<(u32, &str)> = report.warnings.iter().map(|w| (w.line, w.element.as_str())).collect();
    assert_eq!(found, [(6, "plugin"), (6, "include")], "{report}");
    assert_eq!((model.joints.len(), model.joints[0].kind, model.equalities.len()), (3, JointKind::Free, 2));
}

#[test]
fn models_of_a_world_have_their_names_and_places() {
    let text = "<world name='w'><gravity>0 0 -1</gravity><physics type='ode'><max_step_size>.004</max_step_size></physics>\
        <model name='ground'><static>true</static><link name='l'><collision name='c'><geometry><plane>\
        <normal>1 0 0</normal></plane></geometry></collision></link></model>\
        <model name='box'><pose>0 0 2 0 0 0</pose><link name='l'/></model></world>";
    let model = import(text).model;
    assert_eq!((model.gravity, model.timestep), (DVec3::NEG_Z, 0.004));
    assert!(model.body_named("ground::l").is_some() && model.body_named("box::l").is_some());
    assert_eq!(model.reference_configuration()[..3], [0.0, 0.0, 2.0]);
    assert!((model.geoms[0].placement.rotation * DVec3::Z - DVec3::X).length() < 1e-12);
}

#[test]
fn nonsense_is_refused_with_its_place() {
    assert_refused("<model name='m'><link/></model>", &["text):2:17", "attribute 'name'"]);
    let twice = "<model name='m'><link name='a'/>\n<link name='a'/></model>";
    assert_refused(twice, &["text):3:1", "'a'", "2:17"]);
    let unknown = format!("<model name='m'>{LINKS}\n{}</model>", joint("j", "revolute", "a", "bb"));
    assert_refused(&unknown, &["text):3:", "'bb'", "did you mean"]);
    // Its own name is no remedy.
    let own = format!("<model name='m'>{LINKS}\n{}</model>", joint("own", "revolute", "a", "own"));
    assert_refused(&own, &["text):3:", "'own', which is not defined"]);
    let circle = "<model name='m'><frame name='f' attached_to='g'/>\n<frame name='g' attached_to='f'/></model>";
    assert_refused(circle, &["relative to itself"]);
    let number = "<model name='m'><link name='l'>\n<pose>0 0 zero 0 0 0</pose></link></model>";
    assert_refused(number, &["text):3:1", "6 finite numbers"]);
    let kind = format!("<model name='m'>{LINKS}\n{}</model>", joint("j", "hinge", "a", "b"));
    assert_refused(&kind, &["text):3:1", "'hinge'"]);
    let mesh = "<model name='m'><link name='l'><collision name='c'><geometry><mesh>\n<uri>model://p/m.stl</uri></mesh>\
                </geometry></collision></link></model>";
    assert_refused(mesh, &["text):3:1", "m.stl", "No such file"]);
}

/// A folder of models, as Gazebo has them: a board with a peg in it, each a file of its own.
#[test]
fn included_models_take_their_place() {
    let config = "<model><name>Peg</name><sdf version='1.4'>old.sdf</sdf><sdf version='1.7'>peg.sdf</sdf></model>";
    let old = "<sdf version='1.4'><model name='wrong'><link name='wrong'/></model></sdf>";
    let mesh = "<mesh><uri>parts/peg.obj</uri></mesh>";
    let shape = |name: &str, shape: &str| {
        format!(
            "<link name='{name}'><pose>0 0 1 0 0 0</pose><collision name='c'><geometry>{shape}</geometry></collision></link>"
        )
    };
    let peg = format!(
        "<sdf version='1.7'><model name='some peg'><pose>9 9 9 0 0 0</pose>{}</model></sdf>",
        shape("link", mesh)
    );
    let part = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    let board = format!(
        "<sdf version='1.9'><model name='board'><static>1</static>{}<include><uri>rim</uri></include></model></sdf>",
        shape("base", "<box><size>1 1 1</size></box>")
    );
    let world = "<sdf version='1.9'><model name='both'><include><uri>model://board</uri><pose>1 0 0 0 0 0</pose></include>\
        <include><name>peg</name><uri>model://peg</uri><pose>0 2 0 0 0 0</pose></include>\
        <joint name='slot' type='fixed'><parent>board::base</parent><child>peg::link</child></joint>\
        <include><uri>model://nowhere</uri></include></model></sdf>";
    let rim = "<sdf version='1.9'><model name='rim'><static>1</static><link name='edge'/></model></sdf>";
    let files = [
        ("peg/model.config", config),
        ("peg/old.sdf", old),
        ("peg/peg.sdf", &peg),
        ("peg/parts/peg.obj", part),
        ("board/model.sdf", &board),
        // The board's own part stands beside it, as seen from the first file.
        ("both/rim/model.sdf", rim),
        ("both/model.sdf", world),
    ];
    let files = Files::new("include", &files);
    let imported = load(files.path("both/model.sdf"), &LoadOptions::default());
    let from_elsewhere = LoadOptions::default().with_package_dirs(vec![files.folder().to_owned()]);
    let from_text = load_sdf_str(world, "", &from_elsewhere);
    for (Imported { model, report, .. }, of_board) in [(imported.unwrap(), 2), (from_text.unwrap(), 1)] {
        let [board, peg] = ["board::base", "peg::link"].map(|name| model.body_named(name).unwrap());
        assert_eq!(model.bodies[peg.index()].parent, board, "the joint between them holds");
        // The pose of the include takes the place of the model's own.
        assert_eq!(model.bodies[peg.index()].placement.position, DVec3::new(-1.0, 2.0, 0.0));
        let board = |body: &&signorini_multibody::Body| body.name.starts_with("board::");
        assert_eq!(model.bodies.iter().filter(board).count(), of_board, "what stands beside the first file is found");
        assert!(matches!(model.geoms[1].geometry, Geometry::ConvexMesh(_)), "a path begins in the folder of its file");
        let left_out: Vec<&str> = report.motion_warnings().map(|w| w.element.as_str()).collect();
        assert_eq!(left_out, ["include"], "{report}");
    }
}

/// An arm of three bodies, two joints with limits, and a tool without mass.
fn arm_urdf() -> String {
    let link = |name: &str, more: &str| {
        format!(
            "<link name='{name}'><inertial><origin xyz='0.1 0.2 0.3' rpy='0.3 0.2 0.1'/><mass value='2'/>\
             <inertia ixx='0.4' iyy='0.5' izz='0.6' ixy='0.01' ixz='0.02' iyz='0.03'/></inertial>\
             <collision><origin xyz='0 0 0.5' rpy='0 1 0'/><geometry>{more}</geometry></collision></link>"
        )
    };
    format!(
        "<robot name='arm'>{}{}{}<link name='tool'/>\
         <joint name='a' type='revolute'><origin xyz='1 2 3' rpy='0.1 0.2 0.3'/><parent link='base'/><child link='upper'/>\
         <axis xyz='0 0.6 0.8'/><limit lower='-1' upper='2' effort='3' velocity='4'/><dynamics damping='0.5' friction='0.25'/></joint>\
         <joint name='b' type='prismatic'><origin rpy='0 0.5 0'/><parent link='upper'/><child link='lower'/><axis xyz='0 0 1'/>\
         <limit lower='0' upper='1' effort='3' velocity='4'/></joint>\
         <joint name='c' type='continuous'><parent link='lower'/><child link='tool'/></joint></robot>",
        link("base", "<box size='1 2 3'/>"),
        link("upper", "<cylinder radius='0.5' length='2'/>"),
        link("lower", "<sphere radius='0.25'/>"),
    )
}

/// A URDF that an SDF includes moves as the URDF does: poses of links, axes, limits, masses.
#[test]
fn an_included_urdf_is_what_it_is_alone() {
    let urdf = arm_urdf();
    let files = Files::new("include-urdf", &[("arm.urdf", &urdf)]);
    let sdf = |merge: &str| {
        format!(
            "<sdf version='1.9'><model name='cell'><include{merge}><uri>arm.urdf</uri><pose>0 0 1 0 0 0</pose></include>\
             <joint name='mount' type='fixed'><parent>world</parent><child>{}base</child></joint></model></sdf>",
            if merge.is_empty() { "arm::" } else { "" }
        )
    };
    let alone = load_urdf_str(&urdf, "", &LoadOptions::default()).unwrap().model;
    let included =
        ["", " merge='true'"].map(|merge| load_sdf_str(&sdf(merge), files.folder(), &LoadOptions::default()));
    for (prefix, imported) in ["arm::", ""].iter().zip(included) {
        let Imported { model, report, .. } = imported.unwrap();
        assert!(report.to_string().contains("moves no mass"), "{report}");
        for name in ["base", "upper", "lower"] {
            let place = |model: &Model, name: &str| {
                let body = model.body_named(name).unwrap();
                (model.reference_pose(body), model.bodies[body.index()].inertia)
            };
            let ((own, inertia), (other, expected)) = (place(&model, &format!("{prefix}{name}")), place(&alone, name));
            assert!((own.position - other.position - DVec3::Z).length() < 1e-12, "{name}: {own:?}, {other:?}");
            assert!(own.rotation.dot(other.rotation).abs() > 1.0 - 1e-12, "{name}");
            assert!(
                (inertia.rotational - expected.rotational).to_cols_array().iter().all(|x| x.abs() < 1e-12),
                "{name}"
            );
            assert_eq!((inertia.mass, inertia.center_of_mass), (expected.mass, expected.center_of_mass));
        }
        for name in ["a", "b"] {
            let [own, other] = [(&model, format!("{prefix}{name}")), (&alone, name.to_owned())]
                .map(|(model, name)| model.joints[model.joint_named(&name).unwrap().index()].clone());
            assert_eq!(
                (own.limits, own.damping, own.friction_loss),
                (other.limits, other.damping, other.friction_loss)
            );
            let axes = [own.kind, other.kind].map(|kind| match kind {
                JointKind::Hinge { axis } | JointKind::Slide { axis } => axis,
                _ => panic!("{kind:?}"),
            });
            assert!((axes[0] - axes[1]).length() < 1e-12 && own.kind.nv() == 1, "{axes:?}");
        }
        assert_eq!(model.geoms.len(), 3);
    }
}

/// SDFormat 1.9: the parts of a merged model are those of the model around it, and stand where the include's pose puts them.
#[test]
fn merged_models_are_placed() {
    let gauge = "<sdf version='1.9'><model name='gauge'><pose>7 7 7 0 0 0</pose>\
        <link name='dial'><pose>1 0 0 0 0 0</pose></link>\
        <link name='needle'><pose relative_to='dial'>0 0 1 0 0 0</pose></link>\
        <link name='foot'/>\
        <joint name='turn' type='revolute'><parent>dial</parent><child>needle</child><axis><xyz>0 0 1</xyz></axis></joint>\
        <joint name='hold' type='fixed'><parent>dial</parent><child>foot</child></joint></model></sdf>";
    let files = Files::new("merge", &[("gauge/model.sdf", gauge)]);
    let robot = |pose: &str| {
        format!(
            "<sdf version='1.9'><model name='robot'><link name='base'/><include merge='true'><uri>model://gauge</uri>{pose}</include>\
             <joint name='mount' type='fixed'><parent>base</parent><child>dial</child></joint></model></sdf>"
        )
    };
    let options = LoadOptions::default().with_package_dirs(vec![files.folder().to_owned()]);
    let load = |pose: &str| load_sdf_str(&robot(pose), "", &options).unwrap().model;
    // The include turns the gauge by a quarter about z and lifts it by 2 m; without a pose the gauge has its own.
    let (turned, own) = (load("<pose>0 0 2 0 0 1.5707963267948966</pose>"), load(""));
    let place = |model: &Model, body: &str| {
        let body = model.body_named(body).unwrap_or_else(|| panic!("no {body}"));
        let mut kinematics = Kinematics::new(model);
        forward_kinematics_into(model, &model.reference_configuration(), &vec![0.0; model.nv], &mut kinematics);
        kinematics.pose[body.index()].position
    };
    for (body, expected) in [("dial", [0.0, 1.0, 2.0]), ("needle", [0.0, 1.0, 3.0]), ("foot", [0.0, 0.0, 2.0])] {
        assert!((place(&turned, body) - DVec3::from_array(expected)).length() < 1e-12, "{body}");
    }
    assert!((place(&own, "needle") - DVec3::new(8.0, 7.0, 8.0)).length() < 1e-12);
}

#[test]
fn a_file_that_includes_itself_is_refused() {
    let circle =
        "<sdf version='1.9'><model name='m'><link name='l'/><include><uri>circle.sdf</uri></include></model></sdf>";
    let files = Files::new("circle", &[("circle.sdf", circle)]);
    let refused = load(files.path("circle.sdf"), &LoadOptions::default());
    let error = refused.unwrap_err().to_string();
    assert!(error.contains("include itself"), "{error}");
}
