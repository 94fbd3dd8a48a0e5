//! SDF: what acts on links, what they weigh and which of them touch, against numbers worked out by hand.

use std::f64::consts::{FRAC_PI_2, PI};

use signorini_formats::{Imported, LoadOptions, load_sdf_str};
use signorini_multibody::glam::{DMat3, DVec3};
use signorini_multibody::{
    FreeMotion, Inertia, Input, Kinematics, Model, State, forward_kinematics_into, free_motion_into,
};

use crate::support::{self, Files};

#[track_caller]
fn import(inner: &str) -> Imported {
    support::import_sdf("1.11", inner)
}

/// The velocities after a tenth of a second from rest.
fn free_velocity(model: &Model) -> Vec<f64> {
    let (state, mut kinematics, mut motion) = (State::new(model), Kinematics::new(model), FreeMotion::new(model));
    forward_kinematics_into(model, &state.q, &state.v, &mut kinematics);
    free_motion_into(model, &kinematics, &state, &Input::default(), 0.1, &mut motion).unwrap();
    motion.free_velocity
}

/// SDFormat's own number, of worlds that say none and of models without a world.
#[test]
fn gravity_is_the_default_of_the_format() {
    let model = "<model name='ball'><link name='l'/></model>";
    for text in [model.to_owned(), format!("<world name='w'>{model}</world>")] {
        assert_eq!(import(&text).model.gravity, DVec3::new(0.0, 0.0, -9.8));
    }
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

/// Of the links a, b and c of a model and the link d of a model inside it, a and b have a joint.
#[test]
fn links_of_a_model_meet_where_one_of_them_says_so() {
    let link = |name: &str, word: &str| {
        let shape = "<geometry><sphere><radius>1</radius></sphere></geometry>";
        format!("<link name='{name}'>{word}<collision name='{name}'>{shape}</collision></link>")
    };
    let (yes, no) = ("<self_collide>true</self_collide>", "<self_collide>0</self_collide>");
    let joint = "<joint name='j' type='ball'><parent>a</parent><child>b</child></joint>";
    for (outer, inner, a, c, meeting) in [
        ("", "", "", "", ""),
        (yes, "", "", "", "ac ad bc bd cd"),
        (no, "", "", yes, "ac bc cd"),
        (yes, "", no, "", "ac ad bc bd cd"),
        (yes, "", no, no, "ad bc bd cd"),
        (yes, no, no, no, "bc bd"),
        ("", yes, "", "", "ad bd cd"),
        ("", "", yes, "", "ac ad"),
    ] {
        let nested = format!("<model name='in'>{inner}{}</model>", link("d", ""));
        let links = link("a", a) + &link("b", "") + &link("c", c);
        let model = import(&format!("<model name='m'>{outer}{links}{nested}{joint}</model>")).model;
        let meets = |pair: &&str| {
            let [a, b] = [&pair[..1], &pair[1..]].map(|name| model.geom_named(name).unwrap());
            model.contact_filter.allows((a, b), (&model.geoms[a.index()], &model.geoms[b.index()]))
        };
        let found: Vec<&str> = ["ab", "ac", "ad", "bc", "bd", "cd"].iter().filter(|p| meets(p)).copied().collect();
        assert_eq!(found.join(" "), meeting, "{outer} {inner} {a} {c}");
    }
}

#[test]
fn what_is_left_out_is_said_without_a_guess_at_misspelling() {
    let text = "<world name='w'><physics><gravity>0 0 -1</gravity>\n<dart/></physics><actor name='a'/>\n\
        <model name='m'><link name='l'><velocity_decay/><enable_wind>false</enable_wind></link>\n\
        <link name='k'><enable_wind>1</enable_wind><velocity_decay><linear>.1</linear></velocity_decay><inertial>\n\
        <fluid_added_mass><xx>1</xx></fluid_added_mass></inertial><collision name='c'><geometry>\n\
        <heightmap/></geometry><surface><friction><ode><mu>1</mu><slip1>.1</slip1><slip2>0</slip2></ode>\n\
        <torsional/><bullet/></friction></surface></collision></link>\n\
        <joint name='j' type='fixed'><parent>l</parent><child>k</child><physics/><thread_pitch>1</thread_pitch>\n\
        <veloctiy/><axis><limit><acceleration>1</acceleration></limit></axis></joint></model></world>";
    let report = import(text).report;
    let found: Vec<(&str, u32, bool)> =
        report.warnings.iter().map(|w| (w.element.as_str(), w.line, w.changes_motion)).collect();
    let expected = [
        ("geometry", 7, true),
        ("gravity", 2, true),
        ("dart", 3, false),
        ("actor", 3, true),
        ("enable_wind", 5, true),
        ("velocity_decay", 5, true),
        ("fluid_added_mass", 6, true),
        ("slip1", 7, true),
        ("torsional", 8, true),
        ("bullet", 8, true),
        ("physics", 9, false),
        ("veloctiy", 10, true),
        ("acceleration", 10, true),
    ];
    assert_eq!(found, expected, "{report}");
    for warning in &report.warnings {
        let guess = warning.effect.contains("misspelt");
        assert_eq!(guess, warning.element == "veloctiy", "{warning}");
        assert!(guess || warning.effect.contains("left out"), "{warning}");
    }
}

#[test]
fn an_include_that_is_not_found_is_told_once_and_first() {
    let include = "<include><uri>model://iris</uri></include>";
    let alone = import(&format!("<world name='w'>\n{include}</world>")).report;
    let told: Vec<(&str, u32)> = alone.warnings.iter().map(|w| (w.element.as_str(), w.line)).collect();
    assert_eq!(told, [("include", 3)], "{alone}");
    let refused = |include: &str, parent: &str| {
        let joint = format!("<joint name='j' type='fixed'>\n<parent>{parent}</parent><child>l</child></joint>");
        let text = format!("<sdf version='1.9'><model name='m'>\n{include}<link name='l'/>\n{joint}</model></sdf>");
        load_sdf_str(&text, "", &LoadOptions::default()).unwrap_err().to_string()
    };
    let says = |message: &str| {
        message.contains("text):2:1") && message.contains("'model://iris") && message.contains("--package-dir")
    };
    for (include, parent) in [
        (include.to_owned(), "iris::base_link"),
        (include.replace("iris<", "iris/iris.sdf<"), "iris::base_link"),
        (include.replace("<uri>", "<name>drone</name><uri>"), "drone::base_link"),
        (include.replace("<include>", "<include merge='true'>"), "base_link"),
    ] {
        let message = refused(&include, parent);
        assert!(
            says(&message) && message.contains(&format!("text):4:1: <parent> refers to frame '{parent}'")),
            "{message}"
        );
    }
    let other = refused(include, "plane::base_link");
    assert!(!other.contains("iris") && other.contains("'plane::base_link', which is not defined"), "{other}");
}

#[test]
fn a_collision_without_a_shape_is_told_and_touches_nothing() {
    let text = "<model name='m'><link name='l'>\n<collision name='a'><pose>0 1 0 0 0 0</pose></collision>\n\
        <collision name='b'><geometry/></collision><collision name='c'><geometry><empty/></geometry></collision>\
        <collision name='d'><geometry><sphere><radius>1</radius></sphere></geometry></collision></link></model>";
    let Imported { model, report, .. } = import(text);
    assert_eq!(model.geoms.iter().map(|g| g.name.as_str()).collect::<Vec<_>>(), ["d"]);
    let told: Vec<_> = report.warnings.iter().map(|w| (w.element.as_str(), w.line, w.count, w.what.as_str())).collect();
    assert_eq!(told, [("collision", 3, 2, "has no shape")], "{report}");
}

#[track_caller]
fn assert_inertia(found: Inertia, mass: f64, center: [f64; 3], moments: [f64; 3]) {
    assert!((found.mass - mass).abs() < 1e-9 * mass, "{found:?}");
    assert!((found.center_of_mass - DVec3::from_array(center)).length() < 1e-12, "{found:?}");
    let off = found.rotational - DMat3::from_diagonal(DVec3::from_array(moments));
    let bound = 1e-9 * moments[0].max(moments[1]).max(moments[2]);
    assert!(off.to_cols_array().iter().all(|x| x.abs() < bound), "{found:?}, not {moments:?}");
}

fn weighed(inertial: &str, collisions: &str) -> (Inertia, Vec<String>) {
    let Imported { model, report, .. } =
        import(&format!("<model name='m'><static>1</static><link name='l'>{inertial}{collisions}</link></model>"));
    (model.bodies[1].inertia, report.warnings.iter().map(ToString::to_string).collect())
}

fn collision(name: &str, more: &str, shape: &str) -> String {
    format!("<collision name='{name}'>{more}<geometry>{shape}</geometry></collision>")
}

/// The masses of homogeneous bodies from their volumes, m/12 (b² + c²) of a box, 2/5 m r² of a ball, 3/10 m r² of a cone about its axis.
#[test]
fn links_can_weigh_what_their_shapes_weigh() {
    let cube = |more: &str| collision("cube", more, "<box><size>1 2 3</size></box>");
    let auto = "<inertial auto='true'/>";
    let box_of = |mass: f64| [13.0, 10.0, 5.0].map(|x| mass / 12.0 * x);
    let (own, told) = weighed(auto, &cube("<density>500</density><pose>0 0 7 0 0 0</pose>"));
    assert_inertia(own, 3000.0, [0.0, 0.0, 7.0], box_of(3000.0));
    assert!(told.is_empty(), "{told:?}");
    assert_inertia(weighed(auto, &cube("")).0, 6000.0, [0.0; 3], box_of(6000.0));
    let of_link = "<inertial auto='true'><density>2</density></inertial>";
    assert_inertia(weighed(of_link, &cube("")).0, 12.0, [0.0; 3], box_of(12.0));
    assert_inertia(weighed(of_link, &cube("<density>3</density>")).0, 18.0, [0.0; 3], box_of(18.0));
    assert_inertia(weighed("<inertial auto='1'><mass>4</mass></inertial>", &cube("")).0, 4.0, [0.0; 3], box_of(4.0));
    // Turned by a quarter about z, a box has x and y the other way round.
    let turned = cube(&format!("<pose>0 0 0 0 0 {FRAC_PI_2}</pose>"));
    assert_inertia(weighed(of_link, &turned).0, 12.0, [0.0; 3], [10.0, 13.0, 5.0]);
    let cone = collision("cone", "", "<cone><radius>2</radius><length>4</length></cone>");
    let (mass, side) = (1000.0 * PI * 16.0 / 3.0, 0.15 * 4.0 + 0.0375 * 16.0);
    // The centre of mass of a cone is a quarter of its height above its base.
    assert_inertia(weighed(auto, &cone).0, mass, [0.0, 0.0, -1.0], [mass * side, mass * side, mass * 0.3 * 4.0]);
    let balls = [3.0, -1.0].map(|x| {
        collision(&format!("at{x}"), &format!("<pose>{x} 0 0 0 0 0</pose>"), "<sphere><radius>1</radius></sphere>")
    });
    let mass = 1000.0 * PI * 4.0 / 3.0;
    let side = 2.0 * mass * (0.4 + 4.0);
    assert_inertia(weighed(auto, &balls.concat()).0, 2.0 * mass, [1.0, 0.0, 0.0], [0.8 * mass, side, side]);
}

#[test]
fn meshes_weigh_what_their_faces_enclose() {
    // The corner of a cube: volume 1/6, each coordinate of the centre of mass 1/4.
    let faces = ["f 1 3 2", "f 1 2 4", "f 1 4 3", "f 2 3 4"];
    let corner = |faces: &[&str]| format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n{}\n", faces.join("\n"));
    let [closed, open] = [&faces[..], &faces[..3]].map(corner);
    let files = Files::new("auto-inertia", &[("closed.obj", &closed), ("open.obj", &open)]);
    let load = |name: &str| {
        let collision = collision("c", "<density>6</density>", &format!("<mesh><uri>{name}.obj</uri></mesh>"));
        let text = format!(
            "<sdf version='1.11'><model name='m'><link name='l'><inertial auto='true'/>{collision}</link></model></sdf>"
        );
        load_sdf_str(&text, files.folder(), &LoadOptions::default()).unwrap()
    };
    for (Imported { model, report, .. }, told) in [(load("closed"), 0), (load("open"), 1)] {
        let inertia = model.bodies[1].inertia;
        assert!((inertia.mass - 1.0).abs() < 1e-12 && (inertia.center_of_mass - DVec3::splat(0.25)).length() < 1e-12);
        // ∫ x² over the corner is V/10, and (V/4)² of it belongs to the centre of mass: m (1/10 - 1/16) for x² and for y².
        assert!((inertia.rotational.x_axis.x - 2.0 * (0.1 - 0.0625)).abs() < 1e-12, "{inertia:?}");
        assert_eq!(report.warnings.len(), told, "{report}");
    }
}

#[test]
fn what_cannot_be_weighed_is_told() {
    let auto = "<inertial auto='true'/>";
    let plane = collision("p", "", "<plane/>");
    let ball = collision("b", "", "<sphere><radius>1</radius></sphere>");
    let (own, told) = weighed(auto, &(plane.clone() + &ball));
    assert_inertia(own, 1000.0 * PI * 4.0 / 3.0, [0.0; 3], [1600.0 * PI / 3.0; 3]);
    assert!(
        told.len() == 1 && told[0].contains("text):2: <collision> plane without a volume: it weighs nothing"),
        "{told:?}"
    );
    let (own, told) = weighed(auto, "");
    assert_inertia(own, 1.0, [0.0; 3], [1.0; 3]);
    assert!(told.len() == 1 && told[0].contains("auto=\"true\" without a shape"), "{told:?}");
    let both = "<inertial auto='true'><pose>1 0 0 0 0 0</pose></inertial>";
    let (own, told) = weighed(both, &ball);
    assert_eq!(own.center_of_mass, DVec3::ZERO);
    assert!(told.len() == 1 && told[0].contains("<pose> stands in an <inertial auto"), "{told:?}");
    // Without 'auto' a density says nothing.
    assert_inertia(
        weighed("", &ball.replace("<geometry>", "<density>7</density><geometry>")).0,
        1.0,
        [0.0; 3],
        [1.0; 3],
    );
}

/// A second coefficient of friction and the direction of the first one are missed only where the two differ; each is 1 where it is not given.
#[test]
fn friction_of_two_directions_is_reported_where_they_differ() {
    let said = |inner: &str| {
        let friction = format!("<surface><friction><ode>{inner}<fdir1>1 0 0</fdir1></ode></friction></surface>");
        let shape = "<geometry><sphere><radius>1</radius></sphere></geometry>";
        let link = format!("<link name='l'><collision name='c'>{shape}{friction}</collision></link>");
        let report = import(&format!("<model name='m'>{link}</model>")).report;
        report.warnings.iter().map(|warning| warning.element.clone()).collect::<Vec<_>>()
    };
    for alike in ["", "<mu>1.0</mu>", "<mu2>1</mu2>", "<mu>0.4</mu><mu2>0.40</mu2>"] {
        assert_eq!(said(alike), [""; 0], "{alike}");
    }
    assert_eq!(said("<mu>0.4</mu>"), ["fdir1"]);
    assert_eq!(said("<mu>0.4</mu><mu2>1</mu2>"), ["mu2", "fdir1"]);
}

/// Gazebo's rule: two shapes touch where their bits have one in common, and one that says none has 16 of them.
#[test]
fn bit_masks_say_what_touches() {
    let ball = |name: &str, contact: &str| {
        let surface = format!("<surface><contact>{contact}<ode><soft_cfm>0.1</soft_cfm></ode></contact></surface>");
        let collision = format!("<collision name='{name}'><geometry><sphere/></geometry>{surface}</collision>");
        format!("<model name='m{name}'><link name='l'>{collision}</link></model>")
    };
    let mask = |bits: &str| format!("<collide_bitmask>{bits}</collide_bitmask>");
    let ghost = "<collide_without_contact>true</collide_without_contact>";
    let balls = [
        ball("one", &mask("1")),
        ball("two", &mask("0x02")),
        ball("three", &mask("3")),
        ball("all", ""),
        ball("ghost", ghost),
    ];
    let text = format!("<sdf version='1.11'><world name='w'>{}</world></sdf>", balls.concat());
    let Imported { model, report, .. } = load_sdf_str(&text, "", &LoadOptions::default().with_floor(true)).unwrap();
    assert!(report.warnings.is_empty(), "{report}");
    let touching = |a: &str, b: &str| {
        let [a, b] = [a, b].map(|name| model.geom_named(name).unwrap());
        model.contact_filter.allows((a, b), (&model.geoms[a.index()], &model.geoms[b.index()]))
    };
    let names = ["one", "two", "three", "all", "ghost", "floor"];
    for (i, a) in names.iter().enumerate() {
        for b in &names[..i] {
            let apart = [*a, *b].contains(&"ghost") || [*a, *b] == ["two", "one"];
            assert_eq!(touching(a, b), !apart, "{a} {b}");
        }
    }
    support::assert_sdf_refused("1.11", &ball("x", &mask("-1")), &["collide_bitmask", "bit mask"]);
}

/// What a static model is in may move; what is in it does not.
#[test]
fn models_inside_others_can_be_static() {
    let model = |name: &str, inside: &str| format!("<model name='{name}'><link name='l'/>{inside}</model>");
    let text = model("outer", &model("inner", &format!("<static>true</static>{}", model("innermost", ""))));
    let Imported { model, report, .. } = import(&text);
    let joints: Vec<&str> = model.joints.iter().map(|joint| joint.name.as_str()).collect();
    assert_eq!((joints, report.warnings.len()), (vec!["l_free"], 0), "{report}");
}

#[test]
fn what_else_a_world_of_gazebo_says_is_told() {
    let model = "<model name='m'><link name='l'/></model>";
    let text =
        format!("<world name='w'>{model}<state world_name='w'/>\n<population name='p'>{model}</population></world>");
    let report = import(&text).report;
    let told: Vec<&str> = report.warnings.iter().map(|w| w.element.as_str()).collect();
    assert_eq!(told, ["state", "population"], "{report}");
    let worlds = ["w", "v"].map(|name| format!("<world name='{name}'>{model}</world>\n")).concat();
    let report = import(&format!("{worlds}{model}")).report;
    let told: Vec<(u32, &str)> = report.warnings.iter().map(|w| (w.line, w.element.as_str())).collect();
    assert_eq!(told, [(3, "world"), (4, "model")], "{report}");
}

#[test]
fn limits_can_be_open_in_all_ways_of_writing() {
    let joint = |lower: &str, upper: &str| {
        let limit = format!("<limit><lower>{lower}</lower><upper>{upper}</upper></limit>");
        let joint = format!("<parent>world</parent><child>l</child><axis><xyz>0 0 1</xyz>{limit}</axis>");
        import(&format!("<model name='m'><link name='l'/><joint name='j' type='revolute'>{joint}</joint></model>"))
            .model
            .joints[0]
            .limits
    };
    assert_eq!([joint("-inf", "inf"), joint("-INF", "+Inf"), joint("-Infinity", "1e16")], [None; 3]);
    assert_eq!(joint("-1", "INFINITY").map(|limits| limits[0]), Some(-1.0));
}

#[test]
fn ball_joints_have_dampers_and_friction_and_no_limits() {
    let axis = "<axis><dynamics><damping>0.5</damping><friction>2</friction></dynamics>\n<limit><lower>-1</lower><upper>1</upper></limit></axis>";
    let joint = format!("<joint name='j' type='ball'><parent>world</parent><child>l</child>{axis}</joint>");
    let Imported { model, report, .. } = import(&format!("<model name='m'><link name='l'/>{joint}</model>"));
    assert_eq!((model.joints[0].damping, model.joints[0].friction_loss, model.joints[0].limits), (0.5, 2.0, None));
    let [warning] = &report.warnings[..] else { panic!("{report}") };
    assert_eq!((warning.line, warning.element.as_str()), (3, "limit"));
}
