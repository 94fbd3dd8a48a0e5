//! Files that make no sense: what is said, and where.

use signorini_formats::{FormatError, LoadOptions, load_mjcf_str};

use crate::support::Files;

/// The message for a model whose text stands between `<mujoco>` (line 1) and `</mujoco>`.
#[track_caller]
pub fn message(inner: &str) -> String {
    let text = format!("<mujoco>\n{inner}\n</mujoco>");
    let error = load_mjcf_str(&text, "no such folder").expect_err("must be refused");
    error.to_string()
}

const BALL: &str = "<body name='b'><freejoint name='f'/><geom size='.1'/></body>";

#[track_caller]
fn assert_says(inner: &str, parts: &[&str]) {
    let message = message(inner);
    for part in parts {
        assert!(message.contains(part), "'{part}' is not in: {message}");
    }
}

#[test]
fn malformed_xml_is_placed() {
    assert_says("<worldbody>\n <body>\n</worldbody>", &["(MJCF text):4:1", "not well-formed"]);
}

#[test]
fn numbers_that_are_not_finite_are_placed() {
    let inertial =
        "<worldbody>\n<body><joint/>\n<inertial mass='1' pos='0 0 0' diaginertia='1 nan 1'/></body></worldbody>";
    assert_says(inertial, &["text):4:32", "diaginertia", "finite numbers", "'nan'"]);
    assert_says("<option gravity='0 0 1e999'/>", &["text):2:9", "finite numbers"]);
}

#[test]
fn negative_mass_is_placed() {
    assert_says("<worldbody><body>\n<geom size='.1' mass='-1'/></body></worldbody>", &["text):3:17", "not negative"]);
    let inertial = "<worldbody><body>\n<inertial pos='0 0 0' mass='-2' diaginertia='1 1 1'/></body></worldbody>";
    assert_says(inertial, &["text):3:23", "mass"]);
}

#[test]
fn unknown_names_are_placed_with_a_suggestion() {
    let scene = format!("<worldbody>{BALL}<body><joint name='knee'/><geom size='.1'/></body></worldbody>\n");
    let unknown = [
        ("<actuator><motor joint='kneee'/></actuator>", "joint 'kneee'", "did you mean 'knee'"),
        ("<contact><exclude body1='b' body2='c'/></contact>", "body 'c'", "(MJCF text):3"),
        ("<contact><pair geom1='geom0' geom2='nothing at all'/></contact>", "geom 'nothing at all'", ":3:30"),
    ];
    for (section, name, more) in unknown {
        assert_says(&format!("{scene}{section}"), &[name, more]);
    }
    assert_says("<worldbody>\n<geom size='1' class='soft'/></worldbody>", &["default class 'soft'", ":3:16"]);
    assert_says("<worldbody>\n<geom type='mesh' mesh='m'/></worldbody>", &["mesh 'm'", ":3:19"]);
}

#[test]
fn missing_files_are_placed() {
    let mesh = "<asset>\n<mesh name='m' file='m.stl'/></asset><worldbody><geom type='mesh' mesh='m'/></worldbody>";
    assert_says(mesh, &["text):3:16", "m.stl", "No such file"]);
    assert_says("\n<include file='other.xml'/>", &["text):3:1", "other.xml"]);
}

#[test]
fn second_use_of_a_name_is_placed() {
    let twice = "<worldbody><body name='a'/>\n<body name='a'/></worldbody>";
    assert_says(twice, &["text):3:1", "second body", "'a'", "text):2:12"]);
    assert_says("<worldbody>\n<body name='world'/></worldbody>", &["text):3:1", "world"]);
    let class = "<default><default class='c'/>\n<default class='c'/></default>";
    assert_says(class, &["second default class", "'c'"]);
}

#[test]
fn wrong_counts_of_numbers_are_placed() {
    assert_says("<worldbody>\n<body pos='1 2'/></worldbody>", &[":3:7", "3 numbers, found 2"]);
    assert_says("<worldbody>\n<geom size='1 2 3 4'/></worldbody>", &["1 to 3 numbers, found 4"]);
    let key = format!("<worldbody>{BALL}</worldbody>\n<keyframe><key qpos='1 2 3 4 5 6 7 8'/></keyframe>");
    assert_says(&key, &[":3:16", "7 numbers in q", "found 8"]);
}

#[test]
fn impossible_models_are_placed() {
    let massless = "<worldbody>\n<body name='a'>\n<joint/></body></worldbody>";
    assert_says(massless, &["text):3:1", "body 'a'", "no rotational inertia"]);
    let inertia = "<worldbody>\n<body><joint/><inertial pos='0 0 0' mass='1' diaginertia='1 1 5'/></body></worldbody>";
    assert_says(inertia, &["text):3:1", "rigid body"]);
    let free = format!("<worldbody><body>\n<body>\n{}</body></body></worldbody>", "<freejoint/><geom size='1'/>");
    assert_says(&free, &["text):4:1", "child of the world"]);
    let plane = "<worldbody><body><freejoint/><geom size='1'/>\n<geom type='plane' size='1 1 1'/></body></worldbody>";
    assert_says(plane, &["text):3:1", "plane"]);
    assert_says("<worldbody>\n<geom type='box' size='1 1'/></worldbody>", &["text):3:1", "box geom", "positive"]);
}

#[test]
fn contradictions_are_placed() {
    assert_says("<worldbody>\n<body quat='1 0 0 0' euler='1 2 3'/></worldbody>", &["several orientations"]);
    assert_says("<worldbody>\n<geom size='1' quat='0 0 0 0'/></worldbody>", &["not zero"]);
    let limits = "<compiler autolimits='false'/><worldbody><body>\n<joint range='0 1'/></body></worldbody>";
    assert_says(limits, &[":3:8", "limited"]);
    let crossed = "<worldbody><body>\n<joint limited='true' range='1 0'/></body></worldbody>";
    assert_says(crossed, &[":3:23", "lower number first"]);
    assert_says("<compiler coordinate='global'/>", &["local"]);
    assert_says("<compiler eulerseq='xyw'/>", &["three letters"]);
}

#[test]
fn another_root_is_refused() {
    let error = load_mjcf_str("<sdf/>", ".").unwrap_err();
    assert!(matches!(error, FormatError::UnknownFormat { ref found, .. } if found == "sdf"), "{error}");
}

#[test]
fn a_file_that_includes_itself_is_refused() {
    let a = "<mujoco>\n<include file='b.xml'/></mujoco>";
    let b = "<mujocoinclude>\n\n<include file='a.xml'/></mujocoinclude>";
    let files = Files::new("includes-itself", &[("a.xml", a), ("b.xml", b)]);
    let message = signorini_formats::load(files.path("a.xml"), &LoadOptions::default()).unwrap_err().to_string();
    assert!(message.contains("b.xml:3:1") && message.contains("includes itself"), "{message}");
}

#[test]
fn a_misspelt_attribute_comes_before_what_follows_from_it() {
    let misspelt = [
        (
            "<worldbody>\n<geom typ='plane'/></worldbody>",
            ":3:7",
            "<geom> has no attribute 'typ'",
            "did you mean 'type'?",
        ),
        ("<worldbody><body><freejoint/>\n<geom sze='.1'/></body></worldbody>", ":3:7", "'sze'", "did you mean 'size'?"),
        // What cannot be built is elsewhere: the body without mass.
        (
            "<worldbody><body><freejoint/>\n<inertial pos='0 0 0' mas='1' mass='0' diaginertia='0 0 0'/></body></worldbody>",
            ":3:23",
            "'mas'",
            "did you mean 'mass'?",
        ),
    ];
    for (inner, place, name, remedy) in misspelt {
        let said = message(inner);
        let first = said.split("without it").next().unwrap_or_default();
        for part in [place, name, remedy] {
            assert!(first.contains(part), "'{part}' is not in the beginning of: {said}");
        }
    }
}

#[test]
fn attachments_that_cannot_be_made_are_placed() {
    let world = |inner: &str| format!("<worldbody>\n<body name='a'>{inner}</body></worldbody>");
    assert_says(&world("<attach body='b' prefix='p'/>"), &["text):3:16", "there is no body 'b'"]);
    assert_says(&world("<attach body='a' prefix='p'/>"), &["text):3:16", "holds this or another <attach>"]);
    assert_says(&world("<attach prefix='p'/>"), &["text):3:16", "'model', 'body' or 'frame'"]);
    assert_says(&world("<attach body='a'/>"), &["text):3:16", "<attach>"]);
    assert_says(&world("<attach model='m' prefix='p'/>"), &["model 'm'", "3:24"]);
    let missing = format!("<asset><model name='m' file='m.xml'/></asset>{}", world("<attach model='m' prefix='p'/>"));
    assert_says(&missing, &["text):2:8", "m.xml"]);
    // A model that attaches itself.
    let text = "<mujoco><asset><model name='m' file='snake.xml'/></asset><worldbody><attach model='m' prefix='p'/></worldbody></mujoco>";
    let files = Files::new("attach", &[("snake.xml", text)]);
    let error = signorini_formats::load(files.path("snake.xml"), &LoadOptions::default()).unwrap_err();
    assert!(error.to_string().contains("does one attach itself?"), "{error}");
}
