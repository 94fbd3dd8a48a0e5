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
        <veloctiy/></joint></model></world>";
    let report = import(text).report;
    let found: Vec<(&str, u32, bool)> =
        report.warnings.iter().map(|w| (w.element.as_str(), w.line, w.changes_motion)).collect();
    let expected = [
        ("geometry", 6, true),
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
    ];
    assert_eq!(found.iter().map(|f| f.0).collect::<Vec<_>>(), expected.map(|e| e.0), "{report}");
    assert_eq!(found.iter().map(|f| f.2).collect::<Vec<_>>(), expected.map(|e| e.2), "{report}");
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
