//! Models written as MJCF and read again: the same mass matrix, bias and contacts, on the bundled scenes and on robots that others published
//! (`benchmarks/robots/fetch.py`).

use std::path::{Path, PathBuf};

use signorini::collision::{Collider, Reach};
use signorini::formats::{LoadOptions, load, load_mjcf_str, write_mjcf};
use signorini::multibody::{
    ContactPoint, Kinematics, MassMatrix, Model, NewtonEuler, bias_force_into, forward_kinematics_into, integrate_into,
    mass_matrix_into,
};

/// Differences that rounding makes.
const ROUNDING: f64 = 1e-12;

fn near(name: &str, what: &str, a: &[f64], b: &[f64]) {
    assert_eq!(a.len(), b.len(), "{name}: {what}");
    let size = a.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
    let off = a.iter().zip(b).fold(0.0_f64, |m, (x, y)| m.max((x - y).abs()));
    assert!(off <= ROUNDING * size, "{name}: {what} is off by {off:e} of {size:e}");
}

/// Mass matrix, bias and the contacts of the geoms within 5 cm, at a configuration with a velocity.
fn facts(model: &Model, q: &[f64], v: &[f64]) -> (Vec<f64>, Vec<f64>, Vec<ContactPoint>) {
    let mut kinematics = Kinematics::new(model);
    forward_kinematics_into(model, q, v, &mut kinematics);
    let mut mass = MassMatrix::new(model);
    mass_matrix_into(model, &kinematics, &mut mass);
    let mut bias = vec![0.0; model.nv];
    bias_force_into(model, &kinematics, &mut NewtonEuler::new(model), &mut bias);
    let mut points = Vec::new();
    // Two meshes that can meet are refused; that is no matter of files.
    if let Ok(mut collider) = Collider::new(model) {
        let reach = vec![Reach { linear: 0.025, angular: 0.0 }; model.bodies.len()];
        collider.find(model, &kinematics.pose, &reach, &mut points);
    }
    (mass.matrix.to_dense(), bias, points)
}

fn compare(name: &str, model: &Model, again: &Model, can_say_all: bool) {
    let names = |model: &Model| -> Vec<String> {
        let bodies = model.bodies.iter().map(|part| &part.name);
        let joints = model.joints.iter().map(|part| &part.name).chain(model.sites.iter().map(|part| &part.name));
        let actuators =
            model.actuators.iter().map(|part| &part.name).chain(model.sensors.iter().map(|part| &part.name));
        bodies.chain(joints).chain(actuators).cloned().collect()
    };
    assert_eq!(names(model), names(again), "{name}");
    assert_eq!((model.nq, model.nv, model.na), (again.nq, again.nv, again.na), "{name}");
    let mut q = model.reference_configuration();
    near(name, "reference", &q, &again.reference_configuration());
    let mut v: Vec<f64> = (0..model.nv).map(|k| (1.3 * k as f64 + 0.4).sin()).collect();
    for _ in 0..2 {
        let ((mass, bias, points), (other_mass, other_bias, other_points)) =
            (facts(model, &q, &v), facts(again, &q, &v));
        near(name, "mass matrix", &mass, &other_mass);
        near(name, "bias", &bias, &other_bias);
        if can_say_all {
            compare_contacts(name, [model, again], &points, &other_points);
        }
        v.iter_mut().for_each(|v| *v *= 0.7);
        let from = q.clone();
        integrate_into(model, &from, &v, 0.3, &mut q);
    }
    for (a, b) in model.actuators.iter().zip(&again.actuators) {
        assert_eq!(
            (a.kind, a.control_range, a.force_range),
            (b.kind, b.control_range, b.force_range),
            "{name}: '{}'",
            a.name
        );
    }
    for (a, b) in model.joints.iter().zip(&again.joints) {
        let law = |j: &signorini::multibody::Joint| (j.damping, j.stiffness, j.armature, j.friction_loss);
        assert_eq!(law(a), law(b), "{name}: '{}'", a.name);
        let held = a.limits.is_some_and(|[lower, upper]| lower == upper);
        assert!(a.limits == b.limits || held, "{name}: '{}'", a.name);
    }
}

/// The same contacts of the same geoms of the same bodies, by name: geoms that are only looked at come after all others of a URDF file, and
/// in MJCF with their bodies.
fn compare_contacts(name: &str, [model, again]: [&Model; 2], points: &[ContactPoint], others: &[ContactPoint]) {
    assert_eq!(points.len(), others.len(), "{name}: contacts");
    for (a, b) in points.iter().zip(others) {
        let pair = || format!("'{}' and '{}'", model.geoms[a.geom_a.index()].name, model.geoms[a.geom_b.index()].name);
        let parts = |model: &Model, of: &ContactPoint| {
            [of.geom_a, of.geom_b].map(|geom| (model.geoms[geom.index()].body, model.geoms[geom.index()].name.clone()))
        };
        assert_eq!(parts(model, a), parts(again, b), "{name}");
        assert_eq!((a.feature, a.friction), (b.feature, b.friction), "{name}: {}", pair());
        let off = (a.position - b.position).length().max((a.normal - b.normal).length()).max((a.gap - b.gap).abs());
        assert!(off <= ROUNDING * (1.0 + a.position.length()), "{name}: {} are {off:e} off", pair());
    }
}

/// Reads, writes and reads again; how many parts MJCF could not say.
fn round_trip(path: &Path) -> Option<usize> {
    let name = path.display().to_string();
    let model = load(path, &LoadOptions::default()).ok()?.model;
    let written = write_mjcf(&model);
    let again = load_mjcf_str(&written.text, ".").unwrap_or_else(|error| panic!("{name}: {error}"));
    compare(&name, &model, &again.model, written.left_out.is_empty());
    let unknown: Vec<String> = again.report.motion_warnings().map(|warning| warning.to_string()).collect();
    assert!(unknown.is_empty(), "{name}: {unknown:?}");
    Some(written.left_out.len())
}

#[test]
fn the_bundled_scenes_survive() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).expect("the scenes") {
        let path = entry.expect("a file").path();
        if path.extension().is_some_and(|extension| extension == "xml") {
            assert_eq!(round_trip(&path), Some(0), "{}", path.display());
            count += 1;
        }
    }
    assert!(count >= 9, "{count}");
}

fn model_files(folder: &Path, out: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for path in entries.flatten().map(|entry| entry.path()) {
        match path.extension().and_then(|extension| extension.to_str()) {
            _ if path.is_dir() => model_files(&path, out),
            Some("xml" | "urdf" | "sdf") => out.push(path),
            _ => {}
        }
    }
}

#[test]
fn published_robots_survive() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../build/robots");
    let mut files = Vec::new();
    model_files(&folder, &mut files);
    if files.is_empty() {
        println!("skipped: no robots in {}; fetch them with benchmarks/robots/fetch.py", folder.display());
        return;
    }
    files.sort();
    let kept: Vec<usize> = files.iter().filter_map(|path| round_trip(path)).collect();
    let whole = kept.iter().filter(|left_out| **left_out == 0).count();
    println!("{} models of {} files, {whole} of them without anything left out", kept.len(), files.len());
    assert!(kept.len() > 20 && whole * 10 >= kept.len() * 8);
}

/// What only this engine has is written as well.
#[test]
fn what_mjcf_has_no_element_for_survives() {
    let text = r#"<mujoco><custom><numeric name="signorini:restitution:ball" data=".7"/><numeric name="signorini:grain:ball" data=".1 1"/>
        <numeric name="signorini:speed:wheel" data="1"/></custom>
      <worldbody><geom name="belt" type="box" size="1 1 .1" surfacevel=".5 0 0 0 0 0"/><body name="moved &quot;&lt;" mocap="true" pos="0 0 3"/>
        <body name="ball" pos="0 0 1" gravcomp=".5"><joint name="wheel" damping=".1" range="-90 45" springref="10" ref="5"/>
          <geom name="ball" size=".1" condim="6" friction=".3 .01 .002" priority="3" margin=".01" rgba=".1 .2 .3 .4"/><site name="s" type="box" size=".1 .2 .3"/>
        </body><geom name="hills" type="hfield" hfield="h" pos="3 0 0"/></worldbody>
      <asset><hfield name="h" nrow="2" ncol="3" size="1 1 .3 .1" elevation="0 1 2 3 4 7"/></asset>
      <actuator><velocity name="wheel" joint="wheel" kv="2" forcerange="-3 3"/><motor name="m" site="s" gear="1 2 3 4 5 6" ctrlrange="-1 1"/>
        <general name="g" joint="wheel" dyntype="filterexact" dynprm=".1" gainprm="3" biastype="affine" biasprm=".5 -2 -.1" actlimited="true" actrange="-1 2"/></actuator>
      <tendon><fixed name="t" range="-1 1" stiffness="4" springlength=".1 .2"><joint joint="wheel" coef="2"/></fixed></tendon>
      <equality><joint joint1="wheel" polycoef=".1 0 0 0 0"/><connect body1="ball" anchor="0 0 .3"/><weld body1="ball" body2="moved &quot;&lt;"/></equality>
      <sensor><framepos objtype="site" objname="s" reftype="xbody" refname="ball" cutoff="2"/><touch site="s"/></sensor>
      <keyframe><key name="home" qpos=".3" act=".2" mpos="1 2 3"/></keyframe></mujoco>"#;
    let model = load_mjcf_str(text, ".").expect("a model").model;
    let written = write_mjcf(&model);
    assert!(written.left_out.is_empty(), "{:?}", written.left_out);
    let again = load_mjcf_str(&written.text, ".").expect("what was written can be read").model;
    compare("custom", &model, &again, true);
    for (a, b) in model.geoms.iter().zip(&again.geoms) {
        let law = |geom: &signorini::multibody::Geom| {
            let masks = (geom.contact_type, geom.contact_affinity, geom.priority, geom.rgba, geom.surface_velocity);
            (
                geom.friction,
                geom.spin_resistance,
                geom.rolling_friction,
                geom.grain,
                geom.restitution,
                geom.margin,
                masks,
            )
        };
        assert_eq!(law(a), law(b), "{}", a.name);
    }
    let parts = |model: &Model| (model.tendons.clone(), model.equalities.clone(), model.keyframes.clone());
    assert_eq!(parts(&model), parts(&again));
    let (old, new) = (&model.actuators, &again.actuators);
    assert!(
        old.iter()
            .zip(new)
            .all(|(a, b)| (a.transmission, a.activation, a.gear) == (b.transmission, b.activation, b.gear))
    );
    assert!(model.sensors.iter().zip(&again.sensors).all(|(a, b)| (a.kind, a.cutoff) == (b.kind, b.cutoff)));
}
