//! SDF: where frames, models and links are, against poses worked out by hand.

use std::f64::consts::FRAC_PI_2;

use signorini_formats::{Imported, LoadOptions, load_sdf_str};
use signorini_multibody::glam::DVec3;
use signorini_multibody::{JointKind, Model};

use crate::support::{self, Files};

#[track_caller]
fn import(inner: &str) -> Imported {
    support::import_sdf("1.11", inner)
}

#[track_caller]
fn assert_refused(inner: &str, parts: &[&str]) {
    support::assert_sdf_refused("1.11", inner, parts);
}

#[track_caller]
fn assert_stands_at(model: &Model, body: &str, place: [f64; 3]) {
    let found = model.reference_pose(model.body_named(body).unwrap_or_else(|| panic!("no {body}"))).position;
    assert!((found - DVec3::from_array(place)).length() < 1e-12, "{body}: {found}, not {place:?}");
}

/// A quarter turn about z takes x to y.
#[test]
fn models_stand_in_frames_of_the_world_and_of_each_other() {
    let text = format!(
        "<world name='w'>\
         <model name='last'><pose relative_to='first::arm'>0 0 1 0 0 0</pose><link name='l'/></model>\
         <model name='beside'><pose relative_to='first'>1 0 0 0 0 0</pose><link name='l'/></model>\
         <model name='framed'><pose relative_to='corner'>0 1 0 0 0 0</pose><link name='l'/></model>\
         <model name='plain'><pose relative_to='world'>7 0 0 0 0 0</pose><link name='l'/></model>\
         <model name='first'><pose>0 0 5 0 0 {FRAC_PI_2}</pose><link name='l'/>\
         <link name='arm'><pose>2 0 0 0 0 0</pose></link></model>\
         <frame name='corner' attached_to='first::arm'><pose relative_to='table'>3 0 0 0 0 0</pose></frame>\
         <frame name='table'><pose>0 0 1 0 0 {FRAC_PI_2}</pose></frame></world>"
    );
    let Imported { model, report, .. } = import(&text);
    assert_stands_at(&model, "last::l", [0.0, 2.0, 6.0]);
    assert_stands_at(&model, "beside::l", [0.0, 1.0, 5.0]);
    assert_stands_at(&model, "framed::l", [-1.0, 3.0, 1.0]);
    assert_stands_at(&model, "plain::l", [7.0, 0.0, 0.0]);
    assert!(report.warnings.is_empty(), "{report}");
    let bodies: Vec<&str> = model.bodies.iter().map(|b| b.name.as_str()).collect();
    assert_eq!(bodies[1..], ["last::l", "beside::l", "framed::l", "plain::l", "first::l", "first::arm"]);
    let missing = "<world name='w'><model name='a'>\n<pose relative_to='bb'/><link name='l'/></model><model name='b'><link name='l'/></model></world>";
    assert_refused(missing, &["text):2:", "<model>", "'bb'"]);
    let circle = "<world name='w'><model name='a'><pose relative_to='b'/></model><model name='b'><pose relative_to='a'/></model></world>";
    assert_refused(circle, &["relative to itself"]);
}

/// The tip is at (2, 0, 1) in its model, turned by a quarter about z.
#[test]
fn the_pose_of_a_model_is_that_of_its_placement_frame() {
    let tip = format!(
        "<link name='l'/><frame name='side'><pose>2 0 0 0 0 {FRAC_PI_2}</pose></frame><link name='tip'><pose relative_to='side'>0 0 1 0 0 0</pose></link>"
    );
    let placed = |pose: &str| format!("<model name='m' placement_frame='tip'>{pose}{tip}</model>");
    let model = import(&placed("<pose>5 5 5 0 0 0</pose>")).model;
    assert_stands_at(&model, "tip", [5.0, 5.0, 5.0]);
    // The tip's axes are those of the world: in them the model's origin is at -(0, -2, 1).
    assert_stands_at(&model, "l", [5.0, 7.0, 4.0]);
    let inside = format!(
        "<model name='outer' placement_frame='m::l'><pose>0 0 9 0 0 0</pose>{}</model>",
        placed("<pose>1 0 0 0 0 0</pose>")
    );
    let model = import(&inside).model;
    assert_stands_at(&model, "m::l", [0.0, 0.0, 9.0]);
    // The model m is turned back by a quarter about z in the outer one, which is turned by one.
    assert_stands_at(&model, "m::tip", [2.0, 0.0, 10.0]);
    assert_refused(
        "<model name='m' placement_frame='top'>\n<link name='tip'/></model>",
        &["text):2:", "<model>", "'top'", "'tip'"],
    );
}

#[test]
fn includes_have_placement_frames() {
    let tool = format!(
        "<sdf version='1.9'><model name='tool'><link name='grip'/><link name='tip'><pose>0 0 1 0 {FRAC_PI_2} 0</pose></link></model></sdf>"
    );
    let files = Files::new("placement", &[("tool.sdf", &tool)]);
    let include = |merge: &str| {
        format!(
            "<model name='m'><link name='base'/><frame name='table'><pose>0 3 0 0 0 0</pose></frame><include{merge}><uri>tool.sdf</uri>\
            <pose relative_to='table'>1 0 0 0 0 0</pose><placement_frame>tip</placement_frame></include></model>"
        )
    };
    let load = |merge: &str| {
        load_sdf_str(&format!("<sdf version='1.9'>{}</sdf>", include(merge)), files.folder(), &LoadOptions::default())
    };
    for (prefix, imported) in [("tool::", load("")), ("", load(" merge='true'"))] {
        let Imported { model, report, .. } = imported.unwrap();
        assert_stands_at(&model, &format!("{prefix}tip"), [1.0, 3.0, 0.0]);
        // The grip is a metre from the tip along the tip's x.
        assert_stands_at(&model, &format!("{prefix}grip"), [2.0, 3.0, 0.0]);
        assert!(report.warnings.is_empty(), "{report}");
    }
}

/// The link to which `__model__` of `model` is fixed, as the parent of a body that is welded to it.
fn canonical(attribute: &str, inside: &str, model: &str) -> String {
    let text = format!(
        "<model name='m'{attribute}>{inside}<frame name='f' attached_to='{model}'/><link name='end'/>\
         <joint name='j' type='fixed'><parent>f</parent><child>end</child></joint></model>"
    );
    let model = import(&text).model;
    let end = &model.bodies[model.body_named("end").unwrap().index()];
    model.bodies[end.parent.index()].name.clone()
}

#[test]
fn the_first_link_of_a_model_stands_for_it_unless_it_names_one() {
    let part = |name: &str| format!("<model name='{name}'><link name='a'/><link name='b'/></model>");
    let parts = part("first") + &part("second");
    let nested = format!("<model name='n'>{parts}</model>");
    let choosing = format!("<model name='n' canonical_link='second::b'>{parts}</model>");
    assert_eq!(canonical("", &format!("{nested}<link name='own'/>"), "__model__"), "own");
    assert_eq!(canonical("", &nested, "n"), "n::first::a");
    assert_eq!(canonical("", &choosing, "n"), "n::second::b");
    assert_eq!(canonical(" canonical_link='n::second::a'", &nested, "__model__"), "n::second::a");
    // Both in the models inside.
    let text = format!(
        "<model name='m'>{parts}<frame name='f'/><frame name='g' attached_to='second'/>\
        <joint name='j' type='fixed'><parent>f</parent><child>g</child></joint></model>"
    );
    let model = import(&text).model;
    let parent =
        |name: &str| model.bodies[model.bodies[model.body_named(name).unwrap().index()].parent.index()].name.as_str();
    assert_eq!(parent("second::a"), "first::a");
    let empty = "<model name='m'><link name='l'/>\n<model name='empty'/><frame name='f' attached_to='empty'/>\
        <joint name='j' type='fixed'><parent>f</parent><child>l</child></joint></model>";
    assert_refused(empty, &["text):3:", "<model>", "has no link"]);
    let other = "<model name='m'>\n<model name='n' canonical_link='c'><link name='l'/></model><link name='k'/>\
        <joint name='j' type='fixed'><parent>n</parent><child>k</child></joint></model>";
    assert_refused(other, &["text):3:", "<model>", "'c'"]);
}

#[test]
fn a_merged_model_keeps_its_canonical_link() {
    let named = |name: &str, attribute: &str, inside: &str| {
        format!(
            "<sdf version='1.9'><model name='{name}'{attribute}>{inside}\
            <link name='{name}_end'/><joint name='{name}_j' type='fixed'><parent>__model__</parent><child>{name}_end</child></joint></model></sdf>"
        )
    };
    let x = named("x", " canonical_link='x2'", "<link name='x1'/><link name='x2'/>");
    let files = Files::new("canonical", &[("x.sdf", &x), ("y.sdf", &named("y", "", "<link name='y1'/>"))]);
    let text = "<sdf version='1.9'><model name='m'><link name='base'/><include merge='true'><uri>x.sdf</uri></include>\
        <include merge='true'><uri>y.sdf</uri></include></model></sdf>";
    let model = load_sdf_str(text, files.folder(), &LoadOptions::default()).unwrap().model;
    let parent =
        |name: &str| model.bodies[model.bodies[model.body_named(name).unwrap().index()].parent.index()].name.as_str();
    assert_eq!((parent("x_end"), parent("y_end")), ("x2", "y1"));
}

/// As SDFormat 10 writes a model M1 that is inside P: its parts are P's, and a frame stands for it.
#[test]
fn a_flattened_model_has_a_frame_of_its_name() {
    let text = format!(
        "<model name='P'><frame name='M1::__model__' attached_to='M1::L1'><pose relative_to='__model__'>10 0 0 0 0 {FRAC_PI_2}</pose></frame>\
         <link name='M1::L1'><pose relative_to='M1::__model__'>2 0 1 0 0 0</pose></link><link name='L2'/>\
         <joint name='j' type='fixed'><parent>M1::__model__</parent><child>L2</child></joint></model>"
    );
    let model = import(&text).model;
    assert_stands_at(&model, "M1::L1", [10.0, 2.0, 1.0]);
    assert_eq!(model.bodies[model.body_named("L2").unwrap().index()].parent, model.body_named("M1::L1").unwrap());
}

const WORLD: &str = "<frame name='hook'><pose>0 0 3 0 0 0</pose></frame>\
    <model name='ground'><static>1</static><pose>1 0 0 0 0 0</pose><link name='post'><pose>0 0 1 0 0 0</pose></link><link name='slab'/>\
    <joint name='screwed' type='fixed'><parent>post</parent><child>slab</child></joint></model>\
    <model name='gate'><pose>1 0 2 0 0 0</pose><link name='leaf'/></model>\
    <model name='lamp'><pose>0 2 0 0 0 0</pose><link name='cord'/><link name='bulb'><pose>0 0 -1 0 0 0</pose></link>\
    <joint name='socket' type='fixed'><parent>cord</parent><child>bulb</child></joint></model>";

fn of_world(name: &str, kind: &str, ends: [&str; 2], pose: &str) -> String {
    let [parent, child] = ends;
    format!(
        "<joint name='{name}' type='{kind}'>{pose}<parent>{parent}</parent><child>{child}</child><axis><xyz>0 1 0</xyz></axis></joint>"
    )
}

#[test]
fn joints_of_the_world_connect_models() {
    let hinge = of_world("hinge", "revolute", ["ground::post", "gate"], "<pose>0 0 0.5 0 0 0</pose>");
    let hang = of_world("hang", "revolute", ["gate::leaf", "lamp::bulb"], "<pose relative_to='hook'/>");
    let Imported { model, report, .. } = import(&format!("<world name='w'>{hang}{hinge}{WORLD}</world>"));
    assert!(report.warnings.is_empty(), "{report}");
    let body = |name: &str| &model.bodies[model.body_named(name).unwrap().index()];
    let parent = |name: &str| model.bodies[body(name).parent.index()].name.as_str();
    assert_eq!(
        ["ground::slab", "gate::leaf", "lamp::bulb", "lamp::cord"].map(parent),
        ["world", "ground::post", "gate::leaf", "lamp::bulb"]
    );
    for (name, place) in [
        ("ground::post", [1.0, 0.0, 1.0]),
        ("gate::leaf", [1.0, 0.0, 2.0]),
        ("lamp::bulb", [0.0, 2.0, -1.0]),
        ("lamp::cord", [0.0, 2.0, 0.0]),
    ] {
        assert_stands_at(&model, name, place);
    }
    // Half a metre above the leaf; and the hook at (0, 0, 3) in the bulb at (0, 2, -1).
    let joints: Vec<_> = model
        .joints
        .iter()
        .map(|j| (j.name.as_str(), model.bodies[j.body.index()].name.as_str(), j.anchor.to_array()))
        .collect();
    assert_eq!(joints, [("hinge", "gate::leaf", [0.0, 0.0, 0.5]), ("hang", "lamp::bulb", [0.0, -2.0, 4.0])]);
}

#[test]
fn joints_of_the_world_fix_models_to_it() {
    let fixed = of_world("f", "fixed", ["world", "gate"], "") + &of_world("g", "fixed", ["hook", "lamp::cord"], "");
    let Imported { model, report, .. } = import(&format!("<world name='w'>{WORLD}{fixed}</world>"));
    assert!(report.warnings.is_empty(), "{report}");
    assert_eq!((model.nv, model.bodies.len()), (0, 6));
    let again =
        format!("<world name='w'>{WORLD}{fixed}\n{}</world>", of_world("h", "fixed", ["ground::slab", "gate"], ""));
    // It holds what stands already.
    let Imported { model, report, .. } = import(&again);
    assert!(report.warnings.is_empty() && model.equalities.is_empty(), "{report}");
    let unknown = format!("<world name='w'>{WORLD}\n{}</world>", of_world("h", "fixed", ["world", "gat"], ""));
    assert_refused(&unknown, &["text):3:", "'gat'", "did you mean 'gate'"]);
}

/// Where the world has one model, joints of the world keep their names, as those of the model do.
#[test]
fn a_lone_model_can_hang_on_the_world() {
    let text = format!(
        "<world name='w'><model name='m'><pose>0 0 4 0 0 0</pose><link name='l'/></model>{}</world>",
        of_world("pin", "revolute", ["world", "m"], "")
    );
    let model = import(&text).model;
    assert_eq!(model.joints[model.joint_named("pin").unwrap().index()].anchor, DVec3::ZERO);
    assert_stands_at(&model, "l", [0.0, 0.0, 4.0]);
}

/// Parts of a merged model mean its frame by `__model__` and where they say nothing, and what it merges itself stands in it.
#[test]
fn parts_of_a_merged_model_stay_where_they_are_in_it() {
    let inner = "<sdf version='1.11'><model name='inner'><pose>0 0 5 0 0 0</pose><link name='r'/></model></sdf>";
    let part = "<sdf version='1.11'><model name='part'><link name='p'><pose>1 0 0 0 0 0</pose></link>\
        <link name='q'><pose>2 0 0 0 0 0</pose></link><frame name='f'><pose>0 2 0 0 0 0</pose></frame>\
        <frame name='g' attached_to='q'><pose relative_to='__model__'>0 3 0 0 0 0</pose></frame>\
        <joint name='j' type='revolute'><pose relative_to='__model__'>4 0 0 0 0 0</pose><parent>f</parent><child>q</child>\
        <axis><xyz expressed_in='__model__'>1 0 0</xyz></axis></joint><include merge='true'><uri>inner.sdf</uri></include></model></sdf>";
    let files = Files::new("merged-frames", &[("part.sdf", part), ("inner.sdf", inner)]);
    let load = |placement: &str| {
        let text = format!(
            "<sdf version='1.11'><model name='m'><link name='own'/><include merge='true'><uri>part.sdf</uri>\
             <pose degrees='true'>10 0 0 0 0 90</pose>{placement}</include><link name='probe'><pose relative_to='g'/></link>\
             <joint name='k' type='fixed'><parent>own</parent><child>f</child></joint></model></sdf>"
        );
        load_sdf_str(&text, files.folder(), &LoadOptions::default()).unwrap().model
    };
    let model = load("");
    for (name, place) in
        [("p", [10.0, 1.0, 0.0]), ("q", [10.0, 2.0, 0.0]), ("r", [10.0, 0.0, 5.0]), ("probe", [7.0, 0.0, 0.0])]
    {
        assert_stands_at(&model, name, place);
    }
    let body = |name: &str| &model.bodies[model.body_named(name).unwrap().index()];
    let parents = ["p", "q"].map(|name| model.bodies[body(name).parent.index()].name.as_str());
    assert_eq!(parents, ["own", "p"]);
    let joint = &model.joints[model.joint_named("j").unwrap().index()];
    let JointKind::Hinge { axis } = joint.kind else { panic!("{:?}", joint.kind) };
    assert!((joint.anchor - 2.0 * DVec3::X).length() < 1e-12 && (axis - DVec3::X).length() < 1e-12, "{joint:?}");
    let placed = load("<placement_frame>r</placement_frame>");
    assert_stands_at(&placed, "r", [10.0, 0.0, 0.0]);
    assert_stands_at(&placed, "p", [10.0, 1.0, -5.0]);
}
