//! URDF: conventions, and files that make no sense.

use signorini_formats::{Imported, LoadOptions, load_urdf_str};
use signorini_multibody::glam::DVec3;
use signorini_multibody::{
    ActuatorKind, BodyId, GeomId, Geometry, JointId, JointKind, Kinematics, MassMatrix, Model, NewtonEuler,
    Transmission, bias_force_into, forward_kinematics_into, mass_matrix_into,
};

const INERTIAL: &str = "<inertial><origin xyz='0 0 .1'/><mass value='2'/><inertia ixx='1' iyy='1' izz='1'/></inertial>";

fn link(name: &str) -> String {
    format!("<link name='{name}'>{INERTIAL}<collision><geometry><sphere radius='.1'/></geometry></collision></link>")
}

fn joint(name: &str, kind: &str, parent: &str, child: &str) -> String {
    format!(
        "<joint name='{name}' type='{kind}'><origin xyz='0 0 1' rpy='0 0 1.5707963267948966'/><parent link='{parent}'/>\
         <child link='{child}'/><axis xyz='0 2 0'/><limit lower='-1' upper='.5' effort='0' velocity='0'/></joint>"
    )
}

#[track_caller]
fn import(inner: &str, options: &LoadOptions) -> Imported {
    load_urdf_str(&format!("<robot name='r'>\n{inner}\n</robot>"), "", options).unwrap()
}

#[track_caller]
fn assert_refused(inner: &str, parts: &[&str]) {
    let text = format!("<robot name='r'>\n{inner}\n</robot>");
    let message =
        load_urdf_str(&text, "no such folder", &LoadOptions::default()).expect_err("must be refused").to_string();
    for part in parts {
        assert!(message.contains(part), "'{part}' is not in: {message}");
    }
}

#[test]
fn a_tree_in_document_order_depth_first() {
    let links = ["leaf", "base", "a", "b", "tip"].map(link).concat();
    let joints = [
        joint("z", "revolute", "base", "b"),
        joint("weld", "fixed", "b", "tip"),
        joint("m", "prismatic", "base", "a"),
        joint("y", "continuous", "tip", "leaf"),
    ]
    .concat();
    let Imported { model, report, .. } = import(&format!("{links}{joints}"), &LoadOptions::default());
    assert!(report.warnings.is_empty(), "{report}");
    let bodies: Vec<&str> = model.bodies.iter().map(|b| b.name.as_str()).collect();
    assert_eq!(bodies, ["world", "base", "b", "tip", "leaf", "a"]);
    let joints: Vec<&str> = model.joints.iter().map(|j| j.name.as_str()).collect();
    assert_eq!(joints, ["z", "y", "m"]);
    assert_eq!(model.joints[0].kind, JointKind::Hinge { axis: DVec3::Y });
    assert_eq!(model.joints[0].limits, Some([-1.0, 0.5]));
    assert_eq!(model.joints[1].limits, None);
    assert_eq!(model.joints[2].kind, JointKind::Slide { axis: DVec3::Y });
    let tip = model.body_named("tip").unwrap();
    assert_eq!((model.bodies[tip.index()].joint_count, model.body_weld[tip.index()]), (0, BodyId(2)));
    assert!((model.bodies[tip.index()].placement.rotation * DVec3::X - DVec3::Y).length() < 1e-15);
}

#[test]
fn neighbours_do_not_touch_even_on_a_fixed_base() {
    let links = ["base", "bracket", "arm", "hand", "finger"].map(link).concat();
    let joints = [
        joint("1", "fixed", "base", "bracket"),
        joint("2", "revolute", "bracket", "arm"),
        joint("3", "fixed", "arm", "hand"),
        joint("4", "revolute", "hand", "finger"),
    ]
    .concat();
    for floating_base in [false, true] {
        let options = LoadOptions::default().with_floating_base(floating_base);
        let model = import(&format!("{links}{joints}"), &options).model;
        let touching = |a: &str, b: &str| {
            let [a, b] = [a, b].map(|name| model.geom_named(name).unwrap());
            model.contact_filter.allows((a, b), (&model.geoms[a.index()], &model.geoms[b.index()]))
        };
        for (a, b) in [("base", "bracket"), ("base", "arm"), ("bracket", "hand"), ("arm", "hand"), ("arm", "finger")] {
            assert!(!touching(a, b), "{a} and {b} touch (floating base: {floating_base})");
        }
        assert!(touching("base", "finger") && touching("bracket", "finger"));
    }
}

#[test]
fn shapes_are_halved_and_coloured() {
    let collision = |shape: &str| format!("<collision name='c'><geometry>{shape}</geometry></collision>");
    let text = format!(
        "<material name='blue'><color rgba='0 0 1 1'/></material><link name='l'>{}{}{}{}\
         <visual><geometry><box size='1 1 1'/></geometry><material name='blue'/></visual></link>",
        collision("<box size='.2 .4 .6'/>"),
        collision("<cylinder radius='.1' length='.8'/>"),
        collision("<ellipsoid radii='.1 .2 .3'/>"),
        collision("<drake:ellipsoid a='.1' b='.2' c='.3'/>")
    );
    let model = import(&text, &LoadOptions::default()).model;
    assert_eq!(model.geoms[0].geometry, Geometry::Box { half_extents: DVec3::new(0.1, 0.2, 0.3) });
    assert_eq!(model.geoms[1].geometry, Geometry::Cylinder { radius: 0.1, half_length: 0.4 });
    for geom in &model.geoms[2..4] {
        assert_eq!(geom.geometry, Geometry::Ellipsoid { semi_axes: DVec3::new(0.1, 0.2, 0.3) });
    }
    assert_eq!(model.geoms[0].rgba, [0.0, 0.0, 1.0, 1.0]);
    assert_eq!((model.geom_named("c"), model.geom_named("c_2")), (Some(GeomId(0)), Some(GeomId(1))));
}

#[test]
fn a_root_called_world_is_the_world_and_carries_floating_links() {
    let text = format!("<link name='world'/>{}{}", link("box"), joint("f", "floating", "world", "box"));
    let model = import(&text, &LoadOptions::default()).model;
    assert_eq!((model.bodies.len(), model.joints[0].kind), (2, JointKind::Free));
    let reference = model.reference_configuration();
    assert_eq!(reference[..3], [0.0, 0.0, 1.0]);
}

/// At the reference it stands where its joint is, and like all that a joint connects it does not touch its parent.
#[test]
fn links_that_float_below_moving_ones_move_in_the_world() {
    let links = ["a", "b", "c"].map(link).concat();
    let text = format!("{links}{}{}", joint("h", "revolute", "a", "b"), joint("f", "floating", "b", "c"));
    let Imported { model, report, .. } = import(&text, &LoadOptions::default());
    let [b, c] = ["b", "c"].map(|name| model.body_named(name).unwrap());
    assert_eq!((model.bodies[c.index()].parent, model.joints[1].kind), (BodyId::WORLD, JointKind::Free));
    // Each joint turns by a quarter about z at a height of 1 m.
    let pose = model.reference_pose(c);
    assert!(
        (pose.position - 2.0 * DVec3::Z).length() < 1e-12 && (pose.rotation * DVec3::X + DVec3::X).length() < 1e-12
    );
    assert_eq!(model.contact_filter.excluded_bodies().filter(|pair| **pair == (b, c)).count(), 1);
    let [warning] = &report.warnings[..] else { panic!("{report}") };
    assert!(warning.what.contains("hangs on a link that moves") && !warning.changes_motion, "{warning}");
}

#[test]
fn impossible_inertia_is_replaced_and_reported() {
    let text = "<link name='l'>\n<inertial><mass value='1'/><inertia ixx='0' iyy='0' izz='3'/></inertial></link>";
    let Imported { model, report, .. } = import(text, &LoadOptions::default());
    let moments = model.bodies[1].inertia.rotational;
    assert_eq!([moments.x_axis.x, moments.y_axis.y, moments.z_axis.z], [1.5, 1.5, 3.0]);
    let [warning] = &report.warnings[..] else { panic!("{report}") };
    assert!(warning.line == 3 && warning.changes_motion && warning.what.contains("not that of a rigid body"));
}

#[test]
fn what_is_not_supported_is_reported() {
    let hinge = joint("m", "revolute", "a", "b").replace("velocity='0'", "velocity='9'");
    let mesh = "<link name='c'><collision><geometry><mesh filename='c.fbx'/></geometry></collision></link>";
    let weld = joint("w", "fixed", "a", "c");
    let text = format!("{}{}{mesh}\n{hinge}\n{weld}<gazebo/><tranmission/>", link("a"), link("b"));
    let report = import(&text, &LoadOptions::default()).report;
    let found: Vec<(u32, &str)> = report.warnings.iter().map(|w| (w.line, w.element.as_str())).collect();
    assert_eq!(found, [(2, "mesh"), (3, "limit"), (4, "gazebo"), (4, "tranmission")], "{report}");
}

#[test]
fn planar_joints_slide_and_turn() {
    let text = format!("{}{}{}", link("a"), link("b"), joint("j", "planar", "a", "b"));
    let model = import(&text, &LoadOptions::default()).model;
    let names: Vec<&str> = model.joints.iter().map(|j| j.name.as_str()).collect();
    assert_eq!(names, ["j_x", "j_y", "j_turn"]);
    let [JointKind::Slide { axis: x }, JointKind::Slide { axis: y }, JointKind::Hinge { axis: normal }] =
        [0, 1, 2].map(|k| model.joints[k].kind)
    else {
        panic!("{:?}", model.joints)
    };
    assert_eq!(normal, DVec3::Y);
    assert!(x.dot(y).abs() < 1e-15 && x.dot(normal).abs() < 1e-15 && y.dot(normal).abs() < 1e-15);
}

/// The same robot with its fixed joints merged moves the same: mass matrix and bias force agree.
#[test]
fn merged_links_weigh_and_touch_the_same() {
    let links = ["base", "arm", "hand", "tool"].map(link).concat();
    let edges = [
        joint("1", "revolute", "base", "arm"),
        joint("2", "fixed", "arm", "hand"),
        joint("3", "prismatic", "hand", "tool"),
    ];
    let text = format!("{links}{}", edges.concat());
    let plain = import(&text, &LoadOptions::default()).model;
    let merged = import(&text, &LoadOptions::default().with_merge_fixed_joints(true)).model;
    assert_eq!((plain.bodies.len(), merged.bodies.len()), (5, 4));
    assert_eq!(merged.sites[merged.site_named("hand").unwrap().index()].body, merged.body_named("arm").unwrap());
    let measure = |model: &Model| {
        let mut kinematics = Kinematics::new(model);
        forward_kinematics_into(model, &[0.3, -0.2], &[0.5, 0.7], &mut kinematics);
        let mut mass = MassMatrix::new(model);
        mass_matrix_into(model, &kinematics, &mut mass);
        let mut numbers = mass.matrix.to_dense();
        let mut bias = vec![0.0; model.nv];
        bias_force_into(model, &kinematics, &mut NewtonEuler::new(model), &mut bias);
        numbers.extend(bias);
        for geom in &model.geoms {
            numbers.extend((kinematics.pose[geom.body.index()] * geom.placement).position.to_array());
        }
        numbers
    };
    for (a, b) in measure(&plain).iter().zip(measure(&merged)) {
        assert!((a - b).abs() < 1e-12, "{a} {b}");
    }
}

#[test]
fn transmissions_become_motors_bounded_by_the_effort() {
    let edge = joint("j", "revolute", "a", "b").replace("effort='0'", "effort='9'");
    let drive = "<transmission name='t'><type>x</type><joint name='j'/><actuator name='m'/></transmission>";
    let Imported { model, report, .. } =
        import(&format!("{}{}{edge}{drive}", link("a"), link("b")), &LoadOptions::default());
    assert!(report.warnings.is_empty(), "{report}");
    let [motor] = &model.actuators[..] else { panic!("{:?}", model.actuators) };
    assert_eq!((motor.name.as_str(), motor.force_range), ("j", Some([-9.0, 9.0])));
    assert_eq!((motor.transmission, motor.kind), (Transmission::Joint(JointId(0)), ActuatorKind::Motor));
}

/// Without a transmission, too; motors of transmissions come first. What mimics another joint has no motor of its own.
#[test]
fn efforts_become_motors() {
    let with_effort = |name: &str, parent: &str, child: &str, effort: &str| {
        joint(name, "revolute", parent, child).replace("effort='0'", &format!("effort='{effort}'"))
    };
    let links = ["a", "b", "c", "d", "e"].map(link).concat();
    let follower = with_effort("follower", "d", "e", "4").replace("</joint>", "<mimic joint='first'/></joint>");
    let edges = [
        with_effort("first", "a", "b", "3"),
        with_effort("second", "b", "c", "5"),
        with_effort("passive", "c", "d", "0"),
        follower,
    ];
    let drive = "<transmission name='t'><type>x</type><joint name='second'/><actuator name='m'/></transmission>";
    let Imported { model, report, .. } =
        import(&format!("{links}{drive}\n{}", edges.concat()), &LoadOptions::default());
    let motors: Vec<_> = model.actuators.iter().map(|motor| (motor.name.as_str(), motor.force_range)).collect();
    assert_eq!(motors, [("second", Some([-5.0, 5.0])), ("first", Some([-3.0, 3.0]))]);
    let [warning] = &report.warnings[..] else { panic!("{report}") };
    assert!(warning.what.contains("effort") && warning.effect.contains("mimics"), "{report}");
}

#[test]
fn links_are_kept_apart_by_option_and_by_srdf() {
    let links = ["a", "b", "c", "d"].map(link).concat();
    let edges =
        [("1", "a", "b"), ("2", "b", "c"), ("3", "c", "d")].map(|(n, p, c)| joint(n, "revolute", p, c)).concat();
    let touching = |options: &LoadOptions| {
        let model = import(&format!("{links}{edges}"), options).model;
        [("a", "c"), ("a", "d"), ("b", "d")].map(|(a, b)| {
            let [a, b] = [a, b].map(|name| model.geom_named(name).unwrap());
            model.contact_filter.allows((a, b), (&model.geoms[a.index()], &model.geoms[b.index()]))
        })
    };
    assert_eq!(touching(&LoadOptions::default()), [true; 3]);
    assert_eq!(touching(&LoadOptions::default().with_self_collision(false)), [false; 3]);
    let path = std::env::temp_dir().join(format!("signorini-{}.srdf", std::process::id()));
    let pair = |a: &str, b: &str| format!("<disable_collisions link1='{a}' link2='{b}' reason='Never'/>");
    std::fs::write(&path, format!("<robot name='r'>{}{}</robot>", pair("a", "d"), pair("a", "gripper"))).unwrap();
    let listed = touching(&LoadOptions::default().with_srdf(path.clone()));
    std::fs::remove_file(path).unwrap();
    assert_eq!(listed, [true, false, true]);
}

#[test]
fn friction_and_floor_are_asked_for() {
    let options = LoadOptions::default().with_friction(0.7).with_floor(true).with_floating_base(true);
    let model = import(&link("floor"), &options).model;
    let [floor, body] = &model.geoms[..] else { panic!("{:?}", model.geoms) };
    assert_eq!((body.name.as_str(), body.friction), ("floor_2", 0.7));
    assert_eq!((floor.name.as_str(), floor.body, floor.friction), ("floor", BodyId::WORLD, 0.0));
    assert!(matches!(floor.geometry, Geometry::Plane) && floor.frictional);
    assert!(model.contact_filter.allows((GeomId(0), GeomId(1)), (floor, body)));
    let alone = import(&link("a"), &LoadOptions::default()).model;
    assert_eq!((alone.geoms.len(), alone.geoms[0].friction), (1, 1.0));
    for friction in [-0.1, f64::NAN, f64::INFINITY] {
        let options = LoadOptions::default().with_friction(friction);
        let error = load_urdf_str("<robot name='r'/>", "", &options).unwrap_err().to_string();
        assert!(error.contains("friction") && error.contains("at least 0"), "{error}");
    }
}

#[test]
fn broken_trees_are_refused() {
    let (a, b, c) = (link("a"), link("b"), link("c"));
    let edge = |name, parent, child| joint(name, "revolute", parent, child);
    assert_refused("", &["at least one <link>"]);
    assert_refused(&format!("{a}\n{b}"), &["(URDF text):3:1", "second root", "2:1"]);
    assert_refused(&format!("{a}{b}\n{}\n{}", edge("j", "a", "b"), edge("k", "b", "a")), &["circle", "text):3:1"]);
    let loose = format!("{a}{b}{c}\n{}\n{}", edge("j", "b", "c"), edge("k", "c", "b"));
    assert_refused(&loose, &["circle of joints", "text):3:1"]);
    let two = format!("{a}{b}{c}\n{}\n{}", edge("j", "a", "c"), edge("k", "b", "c"));
    assert_refused(&two, &["text):4:1", "has a parent already", "text):3:1"]);
    assert_refused(&format!("{a}{b}\n{}", edge("j", "a", "bb")), &["link 'bb'", "did you mean 'b'", "text):3:"]);
    assert_refused(&format!("{a}\n{a}"), &["second link", "'a'", "text):3:1"]);
    assert_refused(
        &format!("{a}{b}{c}{}\n{}", edge("j", "a", "b"), edge("j", "a", "c")),
        &["second joint", "text):3:1"],
    );
}

#[test]
fn bad_values_are_refused() {
    let negative = "<link name='l'>\n<inertial><mass value='-1'/><inertia ixx='1' iyy='1' izz='1'/></inertial></link>";
    assert_refused(negative, &["text):3:17", "not negative"]);
    let nan = "<link name='l'>\n<inertial><mass value='1'/><inertia ixx='nan' iyy='1' izz='1'/></inertial></link>";
    assert_refused(nan, &["text):3:", "ixx", "finite"]);
    let mesh =
        "<link name='l'><collision><geometry>\n<mesh filename='package://p/m.stl'/></geometry></collision></link>";
    assert_refused(mesh, &["text):3:7", "p/m.stl", "No such file"]);
    let half = "<link name='l'><collision><geometry>\n<ellipsoid a='1' b='1'/></geometry></collision></link>";
    assert_refused(half, &["text):3:1", "'radii'", "'a', 'b' and 'c'"]);
    let misspelt = "<joint name='j' type='revolut'><parent link='a'/><child link='b'/></joint>";
    assert_refused(&format!("{}{}\n{misspelt}", link("a"), link("b")), &["text):3:17", "revolut", "'revolute'"]);
}

#[test]
fn infinite_limits_and_efforts_are_none() {
    let joint = |limit: &str| {
        let text = format!(
            "<robot name='r'><link name='a'/><link name='b'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1'/></inertial></link>
            <joint name='j' type='revolute'><parent link='a'/><child link='b'/><limit {limit}/></joint></robot>"
        );
        load_urdf_str(&text, "", &LoadOptions::default()).unwrap().model
    };
    for word in ["inf", "INF", "+Infinity"] {
        let model = joint(&format!("lower='-inf' upper='{word}' effort='{word}'"));
        assert_eq!((model.joints[0].limits, model.actuators.len()), (None, 1));
        assert_eq!(model.actuators[0].force_range, None);
    }
    let [lower, upper] = joint("lower='-1.5' upper='inf'").joints[0].limits.expect("one end is finite");
    assert!(lower == -1.5 && upper > 1e12, "{lower} {upper}");
}

/// As Gazebo reads it: −1 for no bound.
#[test]
fn negative_efforts_bound_nothing() {
    let turning = joint("j", "revolute", "a", "b").replace("effort='0'", "effort='-1'");
    let inner = format!("{}{}\n{turning}", link("a"), link("b"));
    let imported = import(&inner, &LoadOptions::default());
    let text = imported.report.to_string();
    assert!(text.contains(":3: <limit> has a negative effort"), "{text}");
    assert!(imported.model.actuators.is_empty());
    let driven = import(&format!("{inner}<transmission><joint name='j'/></transmission>"), &LoadOptions::default());
    assert_eq!(driven.model.actuators[0].force_range, None);
}

/// Three parallel hinges of one link in a plane: two of them and nothing else move its centre anywhere that the third one does.
#[test]
fn hinges_that_move_nothing_of_their_own_get_an_armature() {
    let hinge = |name: &str, parent: &str, child: &str| {
        format!(
            "<joint name='{name}' type='continuous'><parent link='{parent}'/><child link='{child}'/><origin xyz='.05 0 0'/><axis xyz='0 0 1'/></joint>\n"
        )
    };
    let small =
        "<inertial><origin xyz='.007 0 0'/><mass value='.02'/><inertia ixx='1e-5' iyy='2e-5' izz='2e-5'/></inertial>";
    let inner = format!(
        "<link name='base'/><link name='a'/><link name='b'/><link name='c'>{small}</link>\n{}{}{}",
        hinge("j", "base", "a"),
        hinge("k", "a", "b"),
        hinge("l", "b", "c")
    );
    let Imported { model, report, .. } = import(&inner, &LoadOptions::default());
    assert!(report.to_string().contains("moves nothing that other joints do not move"), "{report}");
    let mut kinematics = Kinematics::new(&model);
    forward_kinematics_into(&model, &model.reference_configuration(), &[0.0; 3], &mut kinematics);
    let mut mass = MassMatrix::new(&model);
    mass_matrix_into(&model, &kinematics, &mut mass);
    assert!(mass.matrix.factor().is_ok());
}

#[test]
fn letters_in_another_order_are_taken_for_a_slip() {
    let swapped = link("a").replace("izz='1'", "izz='1' iyx='0'");
    let text = import(&swapped, &LoadOptions::default()).report.to_string();
    assert!(text.contains("did you mean 'ixy'?"), "{text}");
}

/// A base without mass turns as the hinge on it does: the hinge gets the armature, and the base stays free of one.
#[test]
fn a_floating_base_without_mass_keeps_its_inertia() {
    let inner = format!(
        "<link name='base'/>{}\n<joint name='j' type='continuous'><parent link='base'/><child link='a'/><axis xyz='0 0 1'/></joint>",
        link("a")
    );
    let Imported { model, report, .. } = import(&inner, &LoadOptions::default().with_floating_base(true));
    let armature = |name| model.joints[model.joint_named(name).unwrap().index()].armature;
    assert!(armature("j") > 0.0 && armature("floating_base") == 0.0, "{report}");
    assert!(report.to_string().contains("'j' moves nothing that other joints do not move"), "{report}");
}
