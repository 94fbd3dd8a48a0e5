//! Where the files are found that a model names, and the parts that are put in from them.

use std::f64::consts::PI;
use std::path::Path;

use signorini_formats::{LoadOptions, load, load_mjcf_str, load_mjcf_str_with, load_sdf_str};
use signorini_multibody::{Geometry, Model};

use crate::support::Files;

/// A tetrahedron with edges of this length along the axes.
fn tetrahedron(edge: f64) -> String {
    format!("v 0 0 0\nv {edge} 0 0\nv 0 {edge} 0\nv 0 0 {edge}\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n")
}

fn mjcf(path: &Path) -> Model {
    load(path, &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}")).model
}

fn mass(model: &Model) -> f64 {
    model.bodies.iter().map(|body| body.inertia.mass).sum()
}

/// A tetrahedron's volume is a sixth of the cube's, and the density 1000 kg/m³. MuJoCo 4.0 finds both files.
#[test]
fn assets_of_included_files_lie_beside_the_main_file_or_beside_theirs() {
    let assets = "<mujocoinclude><asset><mesh name='a' file='../meshes/a.obj'/></asset></mujocoinclude>";
    let main = "<mujoco><include file='assets/a.xml'/><worldbody><body><freejoint/><geom type='mesh' mesh='a'/></body></worldbody></mujoco>";
    let beside = tetrahedron(0.6);
    let files = Files::new(
        "assets",
        &[("robot/main.xml", main), ("robot/assets/a.xml", assets), ("robot/meshes/a.obj", &beside)],
    );
    let expected = |edge: f64| 1000.0 * edge.powi(3) / 6.0;
    assert!((mass(&mjcf(&files.path("robot/main.xml"))) - expected(0.6)).abs() < 1e-4);
    // `../meshes` of the main file is there, too, and comes first.
    std::fs::create_dir_all(files.path("meshes")).unwrap();
    std::fs::write(files.path("meshes/a.obj"), tetrahedron(0.3)).unwrap();
    assert!((mass(&mjcf(&files.path("robot/main.xml"))) - expected(0.3)).abs() < 1e-4);
}

/// The tip lies beside the finger, not beside the main file; MuJoCo 4.0 finds it, too. It takes one file in several
/// places only by several names (symbolic links, as hands of the Shadow Robot Company have them).
#[test]
fn a_file_may_be_included_in_several_places_and_lie_beside_its_includer() {
    let finger = "<mujocoinclude><geom size='.1'/><body><joint/><include file='tip.xml'/></body></mujocoinclude>";
    let tip = "<mujocoinclude><geom size='.2'/></mujocoinclude>";
    let body = "<body><freejoint/><include file='parts/finger.xml'/></body>";
    let main = &format!("<mujoco><worldbody>{body}{body}</worldbody></mujoco>");
    let files =
        Files::new("several-places", &[("main.xml", main), ("parts/finger.xml", finger), ("parts/tip.xml", tip)]);
    let model = mjcf(&files.path("main.xml"));
    let sphere = |radius: f64| 1000.0 * 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    assert_eq!(model.bodies.len(), 5);
    assert!((mass(&model) - 2.0 * (sphere(0.1) + sphere(0.2))).abs() < 1e-9, "{}", mass(&model));
}

/// MuJoCo 4.0 keeps the names as they are, and gives `hand` geoms of 0.2 and 0.3 m.
#[test]
fn parts_are_attached_without_a_prefix() {
    let defaults = |top: &str, small: &str| {
        format!("<default><geom size='{top}'/><default class='small'><geom size='{small}'/></default></default>")
    };
    let bodies = "<worldbody><body name='hand'><geom/><geom class='small' pos='1 0 0'/></body></worldbody>";
    let part = &format!("<mujoco>{}{bodies}</mujoco>", defaults(".2", ".3"));
    let main = &format!(
        "<mujoco>{}<asset><model name='part' file='part.xml'/></asset>\
                <worldbody><body name='arm'><geom/><geom class='small'/><attach model='part' prefix=''/></body></worldbody></mujoco>",
        defaults(".4", ".5")
    );
    let files = Files::new("prefix", &[("main.xml", main), ("part.xml", part)]);
    let model = mjcf(&files.path("main.xml"));
    let names: Vec<&str> = model.bodies.iter().map(|body| body.name.as_str()).collect();
    assert_eq!(names, ["world", "arm", "hand"]);
    let radii: Vec<f64> = model
        .geoms
        .iter()
        .filter_map(|geom| match geom.geometry {
            Geometry::Sphere { radius } => Some(radius),
            _ => None,
        })
        .collect();
    assert_eq!(radii, [0.4, 0.5, 0.2, 0.3]);
    let nothing = main.replace(" prefix=''", "");
    let error = load_mjcf_str(&nothing, files.folder()).unwrap_err().to_string();
    assert!(error.contains("'prefix'") && error.contains(":1:"), "{error}");
}

/// `outer` has no defaults, and those of what it attaches are not its own. MuJoCo 4.0 gives `hand` a mass of 1000 · 4/3 π 0.1³ kg.
#[test]
fn defaults_of_what_an_attached_model_attaches_stay_there() {
    let inner = "<mujoco><default><geom mass='5'/></default><worldbody><body name='tip'><geom size='.1'/></body></worldbody></mujoco>";
    let outer = "<mujoco><asset><model name='inner' file='inner.xml'/></asset><worldbody><body name='hand'><geom size='.1'/></body>\
                 <attach model='inner' prefix='i_'/></worldbody></mujoco>";
    let main = "<mujoco><asset><model name='outer' file='outer.xml'/></asset><worldbody><attach model='outer' prefix='o_'/>\
                </worldbody></mujoco>";
    let files = Files::new("nested-attach", &[("main.xml", main), ("outer.xml", outer), ("inner.xml", inner)]);
    let model = mjcf(&files.path("main.xml"));
    let mass = |name: &str| model.bodies[model.body_named(name).unwrap().index()].inertia.mass;
    assert!(
        (mass("o_hand") - 4.0 / 3.0 * PI).abs() < 1e-12 && mass("o_i_tip") == 5.0,
        "{} {}",
        mass("o_hand"),
        mass("o_i_tip")
    );
}

/// A class takes over what the classes around it say where it begins: in MuJoCo 4.0, too, the body weighs 10 · (4/3 π 0.2³ + 0.2³) kg.
#[test]
fn defaults_of_a_later_file_do_not_change_earlier_classes() {
    let robot = "<mujocoinclude><default><geom density='10'/><default class='x'><geom size='.2'/></default></default></mujocoinclude>";
    let main = "<mujoco><include file='robot.xml'/><default><geom type='box' size='.1 .1 .1'/></default>\
                <worldbody><body><geom class='x'/><geom/></body></worldbody></mujoco>";
    let files = Files::new("later-defaults", &[("main.xml", main), ("robot.xml", robot)]);
    let found = mass(&mjcf(&files.path("main.xml")));
    assert!((found - 10.0 * (4.0 / 3.0 * PI + 1.0) * 0.2_f64.powi(3)).abs() < 1e-12, "{found}");
    let classes =
        main.replace("<include file='robot.xml'/>", "").replace("</mujoco>", "<include file='robot.xml'/></mujoco>");
    std::fs::write(files.path("main.xml"), classes).unwrap();
    // The other way round they do: the first geom is a box of 0.2, 0.1 and 0.1 m.
    let found = mass(&mjcf(&files.path("main.xml")));
    assert!((found - 10.0 * (0.4 * 0.2 * 0.2 + 0.2_f64.powi(3))).abs() < 1e-12, "{found}");
}

/// MuJoCo 4.0 has tendons, actuators and sensors in this order, which is that of controls and readings.
#[test]
fn what_comes_along_is_in_the_order_of_the_bodies() {
    let referring = |part: &str, joint: &str| {
        format!(
            "<tendon><fixed name='t{part}'><joint joint='{joint}' coef='1'/></fixed></tendon><actuator><motor name='u{part}' joint='{joint}'/>\
             </actuator><sensor><jointpos name='q{part}' joint='{joint}'/></sensor>"
        )
    };
    let body = |joint: &str, inside: &str| {
        format!("<body name='b{joint}'><joint name='{joint}'/><geom size='.1'/>{inside}</body>")
    };
    let part = body("p", &format!("<replicate count='2' sep='_'>{}</replicate>", body("r", "")));
    let part = format!("<mujoco><worldbody>{part}</worldbody>{}{}</mujoco>", referring("r", "r"), referring("p", "p"));
    let attach = |prefix: &str| format!("<attach model='part' prefix='{prefix}_'/>");
    let inner = format!("<replicate count='2' sep='+'>{}</replicate>", body("l", ""));
    let copied = format!("<replicate count='2' sep='-'>{}</replicate>", body("k", &(attach("a") + &inner)));
    let main = format!(
        "<mujoco><asset><model name='part' file='part.xml'/></asset><worldbody>{}<attach body='bj' prefix='y_'/></worldbody>{}{}{}</mujoco>",
        body("j", &(copied + &attach("z"))),
        referring("k", "k"),
        referring("l", "l"),
        referring("j", "j"),
    );
    let files = Files::new("order", &[("main.xml", &main), ("part.xml", &part)]);
    let model = mjcf(&files.path("main.xml"));
    let own =
        "~j ~k-0 a_~p-0 a_~r_0-0 a_~r_1-0 ~l+0-0 ~l+1-0 ~k-1 a_~p-1 a_~r_0-1 a_~r_1-1 ~l+0-1 ~l+1-1 z_~p z_~r_0 z_~r_1";
    let order = |sort: &str| -> Vec<String> {
        let all = ["", "y_"].iter().flat_map(|prefix| own.split(' ').map(move |name| format!("{prefix}{name}")));
        all.map(|name| name.replace('~', sort)).collect()
    };
    assert_eq!(model.tendons.iter().map(|t| t.name.clone()).collect::<Vec<_>>(), order("t"));
    assert_eq!(model.actuators.iter().map(|a| a.name.clone()).collect::<Vec<_>>(), order("u"));
    assert_eq!(model.sensors.iter().map(|s| s.name.clone()).collect::<Vec<_>>(), order("q"));
}

/// As in MuJoCo 4.0.
#[test]
fn constraints_with_what_is_not_attached_do_not_come_along() {
    let body =
        |name: &str| format!("<body name='{name}'><joint name='j{name}'/><geom name='g{name}' size='.1'/></body>");
    let text = format!(
        "<mujoco><worldbody>{}{}<attach body='a' prefix='x_'/></worldbody><contact><exclude body1='a' body2='b'/></contact>\
         <tendon><fixed name='t'><joint joint='ja' coef='1'/><joint joint='jb' coef='1'/></fixed></tendon>\
         <equality><weld name='own' body1='a'/><weld name='between' body1='a' body2='b'/><joint joint1='ja' joint2='jb'/></equality>\
         <actuator><motor name='u' tendon='t'/></actuator></mujoco>",
        body("a"),
        body("b")
    );
    let model = load_mjcf_str(&text, "").unwrap().model;
    let names: Vec<&str> =
        model.equalities.iter().map(|e| e.name.as_str()).filter(|name| name.starts_with("x_")).collect();
    assert_eq!((names, model.equalities.len()), (vec!["x_own"], 4));
    assert_eq!((model.contact_filter.excluded_bodies().count(), model.tendons.len(), model.actuators.len()), (2, 2, 2));
}

/// The groups are those of the body's file: in MuJoCo 4.0 `arm` weighs 2 kg, and `p_hand` 3 kg.
#[test]
fn the_file_of_a_body_says_which_geoms_weigh() {
    let part = "<mujoco><worldbody><frame name='f'><geom size='.1' mass='2'/><geom size='.1' mass='1' group='3'/></frame>\
                <body name='hand'><geom size='.1' mass='3' group='3'/></body></worldbody></mujoco>";
    let main = "<mujoco><compiler inertiagrouprange='0 2'/><asset><model name='part' file='part.xml'/></asset>\
                <worldbody><body name='arm'><attach model='part' frame='f' prefix='f_'/></body>\
                <attach model='part' body='hand' prefix='p_'/></worldbody></mujoco>";
    let files = Files::new("weighing-groups", &[("main.xml", main), ("part.xml", part)]);
    let model = mjcf(&files.path("main.xml"));
    let masses: Vec<f64> = model.bodies.iter().map(|body| body.inertia.mass).collect();
    assert_eq!(masses, [0.0, 2.0, 3.0]);
}

#[test]
fn packages_that_are_files() {
    let mesh = tetrahedron(0.5);
    let urdf = "<robot name='r'><link name='a'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1'/></inertial>\
                <collision><geometry><mesh filename='package://wheel.obj'/></geometry></collision></link></robot>";
    let files = Files::new("package", &[("wheel.urdf", urdf), ("wheel.obj", &mesh)]);
    let model = load(files.path("wheel.urdf"), &LoadOptions::default()).unwrap_or_else(|e| panic!("{e}")).model;
    assert!(model.geoms.iter().any(|geom| matches!(&geom.geometry, Geometry::ConvexMesh { .. })), "{:?}", model.geoms);
}

/// As MuJoCo 4.0 reads it.
#[test]
fn keyframes_with_quaternions_of_zeros() {
    let bodies = "<body><joint/><geom size='1'/><body><joint type='ball'/><geom size='1'/></body></body><body><freejoint/><geom size='1'/></body>";
    let key = "qpos='7 0 0 0 0 1 2 3 0 0 0 0'";
    let text = format!("<mujoco><worldbody>{bodies}</worldbody><keyframe><key {key}/></keyframe></mujoco>");
    let q = &load_mjcf_str(&text, "").unwrap().model.keyframes[0].q;
    assert_eq!(*q, [7.0, 1.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 1.0, 0.0, 0.0, 0.0]);
}

/// Each option that a format has no use for is reported once, by name of what was asked for, and none of those that it uses.
#[test]
fn what_a_format_has_no_use_for_is_reported() {
    let ball = "<body><freejoint/><geom size='1'/></body>";
    let mjcf = format!("<mujoco><worldbody>{ball}</worldbody></mujoco>");
    let sdf = "<sdf version='1.7'><model name='m'><link name='l'/></model></sdf>";
    let default = LoadOptions::default;
    let options = [
        (default(), "", [false, false]),
        (default().with_floor(true), "floor", [true, false]),
        (default().with_package_dirs(vec!["nowhere".into()]), "packages", [true, false]),
        (default().with_floating_base(true), "floating base", [true, true]),
        (default().with_merge_fixed_joints(true), "merged", [true, true]),
        (default().with_self_collision(false), "meet each other", [true, true]),
        (default().with_srdf(std::path::PathBuf::from("a.srdf")), "SRDF", [true, true]),
        (default().with_friction(0.3), "friction", [true, true]),
        (default().with_decompose(0.1).with_visuals(false), "", [false, false]),
    ];
    for (options, what, unused) in options {
        let imported = [load_mjcf_str_with(&mjcf, "", &options).unwrap(), load_sdf_str(sdf, "", &options).unwrap()];
        for (imported, is_unused) in imported.iter().zip(unused) {
            let warnings = imported.report.warnings.iter().filter(|w| ["mujoco", "sdf"].contains(&&*w.element));
            let told: Vec<&str> = warnings.map(|warning| &*warning.what).collect();
            assert_eq!(told.len(), usize::from(is_unused), "{options:?}: {told:?}");
            assert!(told.iter().all(|told| told.contains(what)), "{options:?}: {told:?}");
        }
    }
}
