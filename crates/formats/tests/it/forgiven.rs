//! What other readers forgive is forgiven, with a warning that says where and what to do.

use signorini_formats::{
    Imported, LoadOptions, MissingMeshes, Warning, load_mjcf_str, load_mjcf_str_with, load_sdf_str, load_urdf_str,
};
use signorini_multibody::{BodyId, JointKind};

const LINK: &str = "<link name='a'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1'/></inertial>\
                    <collision><geometry><box size='1 1 1'/></geometry></collision></link>";

#[track_caller]
fn urdf(text: &str) -> Imported {
    load_urdf_str(text, "", &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

#[track_caller]
fn floating(text: &str) -> Imported {
    load_urdf_str(text, "", &LoadOptions::default().with_floating_base(true)).unwrap()
}

/// The only warning that says something.
#[track_caller]
fn warning<'i>(imported: &'i Imported, part: &str) -> &'i Warning {
    let found: Vec<&Warning> = imported.report.warnings.iter().filter(|w| w.to_string().contains(part)).collect();
    let [only] = found[..] else { panic!("'{part}' {} times in:\n{}", found.len(), imported.report) };
    only
}

#[test]
fn prefixes_that_are_not_declared() {
    let text = format!(
        "<robot name='r'>\n{LINK}\n<drake:joint_filter a='1'/>\n<gazebo reference='a'><xacro:thing drake:b='2'/></gazebo></robot>"
    );
    let imported = urdf(&text);
    assert_eq!(imported.model.bodies.len(), 2);
    let drake = warning(&imported, "prefix 'drake'");
    assert!(drake.line == 3 && !drake.changes_motion && drake.effect.contains("xmlns:drake="), "{drake}");
    assert_eq!(warning(&imported, "prefix 'xacro'").line, 4);
    let declared = urdf(&text.replace("name='r'", "name='r' xmlns:drake='d' xmlns:xacro='x'"));
    assert!(!declared.report.to_string().contains("prefix"), "{}", declared.report);
}

#[test]
fn declarations_after_comments_and_text_after_the_root() {
    let text = format!(
        "\n<!-- a comment -- with dashes -->\n<?xml version='1.0'?>\n<!DOCTYPE robot>\n<robot name='r'>{LINK}</robot>\n\n  etc. 1 < 2\n"
    );
    let imported = urdf(&text);
    let late = warning(&imported, "XML declaration");
    assert_eq!((late.line, late.changes_motion), (3, false));
    let trailing = warning(&imported, "text outside");
    assert!(trailing.line == 7 && trailing.what.contains("'etc.'"), "{trailing}");
    let second = urdf(&format!("<robot name='r'>{LINK}</robot>\n<robot><link name='b'/></robot>"));
    assert_eq!((warning(&second, "second root").line, second.model.bodies.len()), (2, 2));
}

/// MuJoCo 4.0 has `key_qpos` 1 2 3 1 0 0 0 and `key_qvel` 4 0 0 0 0 0 of this file.
#[test]
fn keyframes_that_end_early() {
    let text = "<mujoco><worldbody><body><freejoint/><geom size='1'/></body></worldbody>\n<keyframe><key qpos='1 2 3' qvel='4'/></keyframe></mujoco>";
    let imported = load_mjcf_str(text, "").unwrap();
    let key = &imported.model.keyframes[0];
    assert_eq!(
        (key.q.as_slice(), key.v.as_slice()),
        (&[1.0, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0][..], &[4.0, 0.0, 0.0, 0.0, 0.0, 0.0][..])
    );
    assert_eq!(warning(&imported, "'qpos' has 3 of 7").line, 2);
    assert!(warning(&imported, "'qvel' has 1 of 6").changes_motion);
}

#[test]
fn attributes_given_twice_and_unknown_entities() {
    let twice = "<mujoco><worldbody>\n<geom size='1' size='2' name='a&b&unknown;'/></worldbody></mujoco>";
    let imported = load_mjcf_str(twice, "").unwrap();
    assert_eq!(imported.model.geoms[0].geometry.bounding_radius(), 1.0);
    assert_eq!(imported.model.geoms[0].name, "a&b&unknown;");
    assert_eq!(warning(&imported, "'size' is given twice").line, 2);
}

#[test]
fn shapes_without_size_are_left_out() {
    let shape = |shape: &str| {
        let text = format!(
            "<robot name='r'>{LINK}<link name='b'><collision>\n<geometry>{shape}</geometry></collision></link>"
        );
        format!("{text}<joint name='j' type='fixed'><parent link='a'/><child link='b'/></joint></robot>")
    };
    for flat in ["<sphere radius='0'/>", "<box size='1 0 1'/>", "<cylinder radius='1' length='0.0'/>"] {
        let imported = urdf(&shape(flat));
        assert_eq!(imported.model.geoms.len(), 1);
        let warning = warning(&imported, "with a size of 0");
        assert!(warning.changes_motion && warning.effect.contains("left out"), "{warning}");
    }
    assert!(load_urdf_str(&shape("<sphere radius='-1'/>"), "", &LoadOptions::default()).is_err());
}

#[test]
fn negative_friction_of_gazebo() {
    let text = "<sdf version='1.6'><model name='m'><link name='l'><collision name='c'><geometry><sphere><radius>1</radius>\
                </sphere></geometry>\n<surface><friction><ode><mu>-1</mu></ode></friction></surface></collision></link></model></sdf>";
    let imported = load_sdf_str(text, "", &LoadOptions::default()).unwrap();
    assert_eq!(imported.model.geoms[0].friction, 1.0);
    let warning = warning(&imported, "<mu> is negative");
    assert!(warning.line == 2 && warning.changes_motion, "{warning}");
}

#[test]
fn scales_with_one_or_four_numbers() {
    let folder = format!("{}/testdata/mjcf/meshes", env!("CARGO_MANIFEST_DIR"));
    let mesh = |scale: &str| {
        let text = format!(
            "<robot name='r'><link name='a'><collision><geometry>\n<mesh filename='ell.stl' scale='{scale}'/></geometry>\
             </collision></link></robot>"
        );
        load_urdf_str(&text, &folder, &LoadOptions::default()).unwrap()
    };
    let radius = |imported: &Imported| imported.model.geoms[0].geometry.bounding_radius();
    let plain = radius(&mesh("2 2 2"));
    for (scale, says) in [("2 2 2 1", "the first three count"), ("2", "all three axes")] {
        let imported = mesh(scale);
        assert_eq!(radius(&imported), plain);
        assert_eq!(warning(&imported, says).line, 2);
    }
}

#[test]
fn commas_between_numbers() {
    let text = "<mujoco><default>\n<geom friction='0.5, 0.1,0.2'/></default><worldbody>\n<geom size='1' pos='1, 2,3'/>\
                <geom size='1'/></worldbody></mujoco>";
    let imported = load_mjcf_str(text, "").unwrap();
    assert_eq!(imported.model.geoms[0].placement.position.to_array(), [1.0, 2.0, 3.0]);
    assert_eq!((imported.model.geoms[1].friction, imported.model.geoms[1].rolling_friction), (0.5, 0.2));
    let commas = warning(&imported, "commas");
    assert_eq!((commas.line, commas.count, commas.changes_motion), (2, 2, false));
}

#[test]
fn materials_that_are_not_defined() {
    let mjcf = "<mujoco><asset><material name='wood'/></asset><worldbody>\n<geom size='1' material='wod'/></worldbody></mujoco>";
    let imported = load_mjcf_str(mjcf, "").unwrap();
    let material = warning(&imported, "material 'wod'");
    assert!(material.line == 2 && material.effect.contains("'wood'") && !material.changes_motion, "{material}");
    let robot = "<robot name='r'><link name='a'><visual>\n<material name='Blue'/></visual><collision><geometry>\
                 <sphere radius='1'/></geometry></collision></link></robot>";
    assert_eq!(warning(&urdf(robot), "'Blue' is not defined").line, 2);
}

#[test]
fn the_world_without_a_declaration() {
    let text = format!(
        "<robot name='r'>{LINK}<joint name='j' type='revolute'>\n<parent link='world'/><child link='a'/><axis xyz='0 0 1'/>\
         <limit lower='-1' upper='1'/></joint></robot>"
    );
    let imported = urdf(&text);
    assert_eq!(warning(&imported, "link 'world', which is not declared").line, 2);
    let body = imported.model.body_named("a").unwrap();
    assert_eq!(imported.model.bodies[body.index()].parent, BodyId::WORLD);
    assert_eq!((imported.model.nv, imported.model.bodies.len()), (1, 2));
}

#[test]
fn a_link_called_world_that_is_not_the_root() {
    let text = format!(
        "<robot name='r'>{LINK}\n<link name='world'/><joint name='j' type='fixed'><parent link='a'/><child link='world'/>\
         </joint></robot>"
    );
    let imported = urdf(&text);
    let body = imported.model.body_named("world_link").unwrap();
    assert_eq!(imported.model.bodies[body.index()].parent, imported.model.body_named("a").unwrap());
    assert_eq!(warning(&imported, "is called 'world'").line, 2);
}

#[test]
fn robots_without_mass_do_not_float() {
    let massless = "<robot name='r'>\n<link name='a'/></robot>";
    let imported = floating(massless);
    assert_eq!(imported.model.nv, 0);
    let fixed = warning(&imported, "no link of the robot has mass");
    assert!(fixed.line == 2 && fixed.changes_motion && fixed.effect.contains("<inertial>"), "{fixed}");
    let heavy = floating(&format!("<robot name='r'>{LINK}</robot>"));
    assert_eq!(heavy.model.joints[0].kind, JointKind::Free);
    assert!(heavy.report.warnings.is_empty(), "{}", heavy.report);
}

#[test]
fn expressions_of_xacro() {
    let text = |mass: &str| {
        format!(
            "<robot name='$(arg name)'><material name='m'>\n<color rgba='${{r}} 0 0 1'/></material><link name='a'><visual><geometry>\
             <mesh filename='$(find p)/m.dae' scale='${{s}}'/></geometry><material name='m'/></visual>\n<inertial>\
             <mass value='{mass}'/><inertia ixx='1' iyy='1' izz='1'/></inertial></link></robot>"
        )
    };
    assert_eq!(warning(&urdf(&text("1")), "'rgba' is not a colour").line, 2);
    let error = load_urdf_str(&text("${m}"), "", &LoadOptions::default()).unwrap_err().to_string();
    assert!(error.contains(":3:17") && error.contains("run xacro"), "{error}");
}

#[test]
fn misspelt_attributes_are_named() {
    let text =
        "<mujoco><worldbody><body>\n<joint dampnig='1'/><geom size='1' frictoin='1'/></body></worldbody></mujoco>";
    let imported = load_mjcf_str(text, "").unwrap();
    assert!(warning(&imported, "'dampnig'").effect.contains("'damping'"), "{}", imported.report);
    assert!(warning(&imported, "'frictoin'").effect.contains("'friction'"), "{}", imported.report);
}

/// Two links and a joint with these attributes and children.
fn pair_of_links(joint: &str) -> String {
    let second = LINK.replace("'a'", "'b'");
    format!(
        "<robot name='r'>{LINK}{second}\n<joint name='j' {joint}<parent link='a'/><child link='b'/></joint></robot>"
    )
}

#[test]
fn joints_without_usable_limits() {
    let crossed = urdf(&pair_of_links("type='revolute'>\n<limit lower='1' upper='-1'/>"));
    assert_eq!((crossed.model.nv, crossed.model.joints[0].limits), (1, None));
    assert_eq!(warning(&crossed, "upper end below its lower one").line, 3);
    let none = urdf(&pair_of_links("type='prismatic'>"));
    assert_eq!((none.model.nv, none.model.joints[0].limits), (1, None));
    assert!(warning(&none, "has no <limit>").changes_motion);
}

#[test]
fn joint_types_of_other_programs() {
    let kinds = |text: &str| urdf(text).model.joints.iter().map(|j| j.kind).collect::<Vec<_>>();
    for word in ["ball", "spherical"] {
        assert_eq!(kinds(&pair_of_links(&format!("type='{word}'>"))), [JointKind::Ball]);
    }
    assert_eq!(urdf(&pair_of_links("type='universal'>")).model.nv, 2);
    let screw = urdf(&pair_of_links("type='screw'>"));
    assert_eq!((screw.model.nv, warning(&screw, "'screw' is not supported").line), (0, 2));
}

#[test]
fn incomplete_inertia_and_collisions() {
    let link = |inside: &str| urdf(&format!("<robot name='r'><link name='a'>\n{inside}</link></robot>"));
    let point = link("<inertial><mass value='2'/></inertial>");
    assert_eq!((point.model.bodies[1].inertia.mass, warning(&point, "has no <inertia>").line), (2.0, 2));
    let massless = link("<inertial><inertia ixx='0' iyy='0' izz='0'/></inertial>");
    assert_eq!((massless.model.bodies[1].inertia.mass, warning(&massless, "has no <mass>").line), (0.0, 2));
    for shape in
        ["<collision/>", "<collision><geometry/></collision>", "<collision><geometry><cdf/></geometry></collision>"]
    {
        let imported = link(shape);
        assert!(imported.model.geoms.is_empty());
        assert!(warning(&imported, "nothing touches it").changes_motion);
    }
}

#[test]
fn origins_with_more_numbers_and_defaults_of_the_environment() {
    let joint = |origin: &str| {
        let imported = urdf(&pair_of_links(&format!("type='fixed'>\n<origin {origin}/>")));
        (imported.model.bodies[2].placement.position.to_array(), imported)
    };
    let (place, imported) = joint("xyz='1 2 3 4'");
    assert_eq!((place, warning(&imported, "more than three numbers").line), ([1.0, 2.0, 3.0], 3));
    let (place, imported) = joint("xyz='$(optenv SIGNORINI_NOT_SET 0.5 0 -1)'");
    assert_eq!((place, warning(&imported, "environment").line), ([0.5, 0.0, -1.0], 3));
}

#[test]
fn values_without_quotes() {
    let text = "<robot name='r'><link name='a'><collision><geometry>\n<sphere radius=2 />\n</geometry></collision></link></robot>";
    let imported = urdf(text);
    assert_eq!(imported.model.geoms[0].geometry.bounding_radius(), 2.0);
    assert_eq!(warning(&imported, "not in quotes").line, 2);
}

#[test]
fn missing_meshes_are_left_out_where_asked() {
    let skip = LoadOptions::default().with_missing_meshes(MissingMeshes::Skip);
    let robot = "<robot name='r'><link name='a'><inertial><mass value='3'/><inertia ixx='1' iyy='1' izz='1'/></inertial>\
                 <collision><geometry>\n<mesh filename='no/such.stl'/></geometry></collision></link></robot>";
    let scene = "<mujoco><asset><mesh name='m' file='no/such.stl'/></asset><worldbody><body><freejoint/>\n<geom type='mesh' mesh='m'/>\
                 <geom size='1' mass='3'/></body></worldbody></mujoco>";
    let world = "<sdf version='1.9'><model name='m'><link name='l'><inertial><mass>3</mass></inertial><collision name='c'><geometry>\n\
                 <mesh><uri>no/such.stl</uri></mesh></geometry></collision></link></model></sdf>";
    type Load<'a> = &'a dyn Fn(&LoadOptions) -> Result<Imported, signorini_formats::FormatError>;
    let (urdf, mjcf, sdf): (Load, Load, Load) =
        (&|options| load_urdf_str(robot, "", options), &|options| load_mjcf_str_with(scene, "", options), &|options| {
            load_sdf_str(world, "", options)
        });
    for (load, geoms) in [(urdf, 0), (mjcf, 1), (sdf, 0)] {
        let refused = load(&LoadOptions::default()).unwrap_err().to_string();
        assert!(refused.contains("such.stl") && refused.contains("No such file"), "{refused}");
        let imported = load(&skip).unwrap();
        assert_eq!((imported.model.geoms.len(), imported.model.bodies[1].inertia.mass), (geoms, 3.0));
        let left_out = warning(&imported, "such.stl");
        assert!(left_out.line == 2 && left_out.changes_motion, "{left_out}");
    }
}

#[test]
fn mjcf_says_too_much() {
    let text = "<mujoco><default><joint limited='true'/></default><worldbody><body><joint type='free'/>\n\
                <geom type='capsule' size='.1' pos='5 5 5' fromto='0 0 0 0 0 1'/></body></worldbody></mujoco>";
    let imported = load_mjcf_str(text, "").unwrap();
    assert_eq!(imported.model.geoms[0].placement.position.to_array(), [0.0, 0.0, 0.5]);
    assert_eq!((warning(&imported, "'fromto' counts").line, imported.model.joints[0].limits), (2, None));
}

#[test]
fn meshes_of_plugins_are_left_out_with_their_geoms() {
    let text = "<mujoco><asset><mesh name='m'><plugin plugin='mujoco.sdf.torus'/></mesh></asset><worldbody>\n\
                <geom type='sdf' mesh='m'/><geom size='1'/></worldbody></mujoco>";
    let imported = load_mjcf_str(text, "").unwrap();
    assert_eq!((imported.model.geoms.len(), warning(&imported, "made by a plugin").line), (1, 2));
}

#[test]
fn inertia_from_geoms_keeps_what_bodies_are_given_whose_geoms_weigh_nothing() {
    let body = |geom: &str| {
        format!("<body><freejoint/><inertial pos='0 0 0' mass='2' diaginertia='1 1 1'/><frame>{geom}</frame></body>")
    };
    let geoms = ["", "<geom size='1' mass='5'/>", "<geom size='1' mass='0'/>", "<geom size='1' group='3'/>"].map(body);
    let compiler = "<compiler inertiafromgeom='true' inertiagrouprange='0 2'/>";
    let text = format!("<mujoco>{compiler}<worldbody>{}</worldbody></mujoco>", geoms.concat());
    let masses: Vec<f64> = load_mjcf_str(&text, "").unwrap().model.bodies.iter().map(|b| b.inertia.mass).collect();
    // MuJoCo 4.0.0: body_mass.
    assert_eq!(masses, [0.0, 2.0, 5.0, 2.0, 2.0]);
}

#[test]
fn sdf_names_by_kind_defaults_and_the_world() {
    let text = "<sdf version='1.6'><model name='m'><link name='a'><collision name='c'><geometry><box/></geometry></collision></link>\n\
                <link name='world'/><joint name='a' type='revolute'><parent>world</parent><child>a</child><axis><xyz>0 0 1</xyz>\
                </axis></joint></model></sdf>";
    let model = load_sdf_str(text, "", &LoadOptions::default()).unwrap().model;
    assert_eq!((model.bodies.len(), model.nv), (2, 1));
    assert_eq!(model.geoms[0].geometry, signorini_multibody::Geometry::Box { half_extents: [0.5; 3].into() });
    let twice = "<sdf version='1.6'><model name='m'><link name='a'/><link name='a'/></model></sdf>";
    assert!(load_sdf_str(twice, "", &LoadOptions::default()).is_err());
    let empty = load_sdf_str("<sdf version='1.6'>\n<world name='w'/></sdf>", "", &LoadOptions::default()).unwrap();
    assert_eq!((empty.model.bodies.len(), warning(&empty, "has no <model>").line), (1, 2));
}

#[test]
fn sdf_collisions_relative_to_other_frames() {
    let text = "<sdf version='1.9'><model name='m'><frame name='f'><pose>0 0 2 0 0 0</pose></frame><link name='a'><pose>0 0 5 0 0 0</pose>\
                <collision name='c'><pose relative_to='f'>1 0 0 0 0 0</pose><geometry><sphere><radius>1</radius></sphere></geometry>\
                </collision></link></model></sdf>";
    let model = load_sdf_str(text, "", &LoadOptions::default()).unwrap().model;
    assert_eq!(model.geoms[0].placement.position.to_array(), [1.0, 0.0, -3.0]);
}

/// Frames that move and weigh nothing: the joint that carries them has an armature, and one that carries mass further down has none.
#[test]
fn joints_of_a_robot_that_move_no_mass() {
    let joint = |name: &str, kind: &str, parent: &str, child: &str| {
        format!(
            "<joint name='{name}' type='{kind}'><parent link='{parent}'/><child link='{child}'/><axis xyz='0 0 1'/>\
             <limit lower='-1' upper='1' effort='1' velocity='1'/></joint>\n"
        )
    };
    let text = [
        format!("<robot name='r'>{LINK}<link name='fork'/><link name='eye'/><link name='knuckle'/>"),
        format!("{}\n", LINK.replace("'a'", "'tip'")),
        joint("swivel", "revolute", "a", "fork"),
        joint("zoom", "prismatic", "a", "eye"),
        joint("bend", "revolute", "a", "knuckle"),
        joint("end", "fixed", "knuckle", "tip"),
        "</robot>".to_owned(),
    ]
    .concat();
    let imported = urdf(&text);
    let armature = |name| imported.model.joints[imported.model.joint_named(name).unwrap().index()].armature;
    assert!(armature("swivel") > 0.0 && armature("zoom") > 0.0 && armature("bend") == 0.0);
    let swivel = warning(&imported, "'swivel', 'zoom' move no mass");
    assert!(swivel.line == 2 && swivel.changes_motion && swivel.effect.contains("<inertial>"), "{swivel}");
    assert!(!imported.report.to_string().contains("'bend'"), "{}", imported.report);
}

#[test]
fn what_refers_to_parts_that_are_left_out_is_left_out_too() {
    let text = "<mujoco><worldbody><body name='a'><joint name='j'/><geom size='1'/></body>
        <flexcomp name='flag' type='grid'/></worldbody>
        <equality>
        <connect body1='a' body2='flag_0' anchor='0 0 0'/></equality>
        <contact>
        <exclude body1='a' body2='flag_1'/></contact>
        <tendon><fixed name='t'>
        <joint joint='flag_j' coef='1'/></fixed></tendon>
        <actuator>
        <motor joint='flag_j'/>
        <motor tendon='t'/><motor joint='j'/></actuator>
        <sensor>
        <framepos objtype='body' objname='flag_2'/></sensor></mujoco>";
    let Imported { model, report, .. } = load_mjcf_str(text, "").unwrap();
    let mut told: Vec<(u32, &str)> = report.warnings.iter().map(|w| (w.line, w.element.as_str())).collect();
    told.sort_unstable();
    let expected =
        [(2, "flexcomp"), (4, "connect"), (6, "exclude"), (7, "fixed"), (10, "motor"), (11, "motor"), (13, "framepos")];
    assert_eq!(told, expected, "{report}");
    assert_eq!((model.equalities.len(), model.tendons.len(), model.actuators.len(), model.sensors.len()), (0, 0, 1, 0));
    // Without anything that would make parts the same is a mistake.
    let error = load_mjcf_str(&text.replace("<flexcomp name='flag' type='grid'/>", ""), "").unwrap_err();
    assert!(error.to_string().contains("'flag_1', which is not defined"), "{error}");
}

#[test]
fn bodies_whose_only_shapes_a_plugin_makes_stay() {
    let text = "<mujoco><asset><mesh name='m'><plugin plugin='mujoco.sdf.torus'/></mesh></asset><worldbody>
        <body name='a'><freejoint name='f'/><geom type='sdf' mesh='m'/></body>
        <body name='b'><freejoint/><geom type='sdf' mesh='m'/><geom size='1'/></body></worldbody>
        <actuator><motor joint='f'/></actuator></mujoco>";
    let imported = load_mjcf_str(text, "").unwrap();
    let stays = warning(&imported, "all its shapes are left out");
    assert!(stays.line == 2 && stays.changes_motion, "{stays}");
    assert_eq!((imported.model.nv, imported.model.actuators.len()), (6, 0));
}

#[test]
fn a_limited_ball_joint_without_a_range() {
    let text = "<mujoco><default><joint limited='true'/></default><worldbody><body><joint type='ball'/><geom size='1'/></body></worldbody></mujoco>";
    let imported = load_mjcf_str(text, "").unwrap();
    assert!(warning(&imported, "limited ball joint").changes_motion);
    assert_eq!(imported.model.joints[0].limits, None);
}
