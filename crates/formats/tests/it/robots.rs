//! Robots that others published, against Pinocchio's numbers (`testdata/make_robot_reference.py`). The models are not
//! part of the repository: `benchmarks/robots/fetch.py` fetches them.

use std::path::PathBuf;

use serde_json::Value;
use signorini_formats::{LoadOptions, load};
use signorini_multibody::glam::{DMat3, DVec3};
use signorini_multibody::{JointKind, Model, Pose};

const ROBOTS: &str =
    concat!(env!("CARGO_MANIFEST_DIR"), "/../../build/robots/cmeel.prefix/share/example-robot-data/robots");

fn vector(value: &Value) -> DVec3 {
    DVec3::from_array([0, 1, 2].map(|k| value[k].as_f64().unwrap()))
}

/// A matrix stored row by row.
fn matrix(value: &Value) -> DMat3 {
    DMat3::from_cols(vector(&value[0]), vector(&value[1]), vector(&value[2])).transpose()
}

/// Poses of all bodies in world at the reference configuration.
fn poses(model: &Model) -> Vec<Pose> {
    let mut poses: Vec<Pose> = Vec::new();
    for body in &model.bodies {
        let parent = poses.get(body.parent.index()).copied().unwrap_or(Pose::IDENTITY);
        poses.push(parent * body.placement);
    }
    poses
}

#[test]
fn published_robots_are_as_in_pinocchio() {
    if !PathBuf::from(ROBOTS).is_dir() {
        println!("skipped: no robots in {ROBOTS}; fetch them with benchmarks/robots/fetch.py");
        return;
    }
    let text = include_str!("../../testdata/reference/robots.json");
    let reference: Value = serde_json::from_str(text).unwrap();
    for (name, robot) in reference["robots"].as_object().unwrap() {
        let path = PathBuf::from(ROBOTS).join(robot["path"].as_str().unwrap());
        let imported = load(&path, &LoadOptions::default()).unwrap_or_else(|e| panic!("{name}: {e}"));
        compare(name, &imported.model, robot);
        assert!(imported.report.warnings.iter().all(|w| w.line > 0 && !w.effect.is_empty()));
        let floating = load(&path, &LoadOptions::default().with_floating_base(true)).unwrap().model;
        assert_eq!((floating.nq, floating.nv), (imported.model.nq + 7, imported.model.nv + 6), "{name} floating");
    }
}

fn compare(name: &str, model: &Model, robot: &Value) {
    assert_eq!(model.nv as u64, robot["nv"].as_u64().unwrap(), "{name}: nv");
    let poses = poses(model);
    let joints = robot["joints"].as_object().unwrap();
    assert_eq!(model.joints.len(), joints.len(), "{name}: joints");
    for joint in &model.joints {
        let other = &joints[&joint.name];
        let (rotates, axis) = match joint.kind {
            JointKind::Hinge { axis } => (true, axis),
            JointKind::Slide { axis } => (false, axis),
            other => panic!("{name}: joint '{}' is {other:?}", joint.name),
        };
        assert_eq!(rotates, other["rotates"], "{name}: {}", joint.name);
        let axis = poses[joint.body.index()].rotation * axis;
        assert!((axis - vector(&other["axis"])).length() < 1e-9, "{name}: axis of {}", joint.name);
        for (ours, theirs) in joint.limits.unwrap().iter().zip(other["range"].as_array().unwrap()) {
            assert!((ours - theirs.as_f64().unwrap()).abs() < 1e-12, "{name}: limits of {}", joint.name);
        }
    }
    for (link, other) in robot["links"].as_object().unwrap() {
        let body = model.body_named(link).unwrap_or_else(|| panic!("{name}: no body '{link}'"));
        let pose = poses[body.index()];
        let off = (pose.position - vector(&other["pos"])).length();
        let turn = (pose.rotation_matrix() - matrix(&other["rotation"])).to_cols_array().map(f64::abs);
        assert!(off < 1e-9 && turn.iter().all(|x| *x < 1e-9), "{name}: place of '{link}' is {off} m off");
    }
    compare_mass(name, model, &poses, robot);
}

/// Mass, centre of mass, and inertia about the world's origin of the whole robot.
fn compare_mass(name: &str, model: &Model, poses: &[Pose], robot: &Value) {
    let (mut mass, mut moment, mut inertia) = (0.0, DVec3::ZERO, DMat3::ZERO);
    for (body, pose) in model.bodies.iter().zip(poses) {
        let p = pose.transform_point(body.inertia.center_of_mass);
        let r = pose.rotation_matrix();
        let outer = DMat3::from_cols(p * p.x, p * p.y, p * p.z);
        mass += body.inertia.mass;
        moment += p * body.inertia.mass;
        inertia += r * body.inertia.rotational * r.transpose();
        inertia += (DMat3::from_diagonal(DVec3::splat(p.length_squared())) - outer) * body.inertia.mass;
    }
    let expected = robot["mass"].as_f64().unwrap();
    assert!((mass - expected).abs() < 1e-9 * expected, "{name}: {mass} kg instead of {expected}");
    assert!((moment / mass - vector(&robot["com"])).length() < 1e-9, "{name}: centre of mass");
    let off = (inertia - matrix(&robot["inertia"])).to_cols_array().iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    // ANYmal's base link has the impossible inertia diag(0, 0, 3e-6) kg·m², which is replaced by a possible one.
    let allowed = if name == "anymal" { 2e-6 } else { 1e-9 };
    assert!(off < allowed, "{name}: inertia about the origin is {off} kg·m² off");
}
