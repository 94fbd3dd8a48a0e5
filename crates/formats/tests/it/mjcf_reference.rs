//! The reader against MuJoCo's own compiler, whose numbers `testdata/make_reference.py` stored.

use std::path::PathBuf;

use serde_json::Value;
use signorini_formats::{Imported, LoadOptions, load};
use signorini_multibody::glam::{DMat3, DVec3};
use signorini_multibody::{ActuatorKind, GeomId, Geometry, JointKind, Model, Transmission};

const TOLERANCE: f64 = 1e-9;
/// MuJoCo keeps vertices, height fields and colours in single precision.
const SINGLE: f64 = 1e-6;

fn testdata(path: &str) -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/testdata")).join(path)
}

fn pair(name: &str) -> (Model, Value) {
    let text = std::fs::read_to_string(testdata(&format!("reference/{name}.json"))).unwrap();
    let Imported { model, .. } = load(testdata(&format!("mjcf/{name}.xml")), &LoadOptions::default()).unwrap();
    (model, serde_json::from_str(&text).unwrap())
}

fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(list) => list.iter().flat_map(numbers).collect(),
        other => vec![other.as_f64().unwrap()],
    }
}

fn vector(value: &Value) -> DVec3 {
    DVec3::from_slice(&numbers(value))
}

/// A matrix stored row by row.
fn matrix(value: &Value) -> DMat3 {
    DMat3::from_cols_slice(&numbers(value)).transpose()
}

#[track_caller]
fn assert_close(ours: &[f64], theirs: &[f64], tolerance: f64, what: &str) {
    assert_eq!(ours.len(), theirs.len(), "{what}: {ours:?} instead of {theirs:?}");
    for (a, b) in ours.iter().zip(theirs) {
        assert!((a - b).abs() <= tolerance * (1.0 + b.abs()), "{what}: {ours:?} instead of {theirs:?}");
    }
}

fn difference(a: DMat3, b: DMat3) -> f64 {
    (a - b).to_cols_array().iter().fold(0.0, |m, x| m.max(x.abs()))
}

#[track_caller]
fn compare(name: &str) {
    compare_within(name, TOLERANCE);
}

#[track_caller]
fn compare_within(name: &str, mass_tolerance: f64) {
    let (model, theirs) = pair(name);
    assert_eq!(
        (model.nq, model.nv),
        (theirs["nq"].as_u64().unwrap() as usize, theirs["nv"].as_u64().unwrap() as usize)
    );
    assert_close(&[model.timestep], &numbers(&theirs["timestep"]), TOLERANCE, "time step");
    assert_close(&model.gravity.to_array(), &numbers(&theirs["gravity"]), TOLERANCE, "gravity");
    assert_close(&model.reference_configuration(), &numbers(&theirs["qpos0"]), TOLERANCE, "reference configuration");
    compare_bodies(&model, &theirs, mass_tolerance);
    compare_joints(&model, &theirs);
    compare_geoms(&model, &theirs);
    compare_actuators(&model, &theirs);
    compare_sites(&model, &theirs);
    compare_tendons(&model, &theirs);
    compare_keyframes(&model, &theirs);
    compare_pairs(&model, &theirs);
}

fn compare_bodies(model: &Model, theirs: &Value, tolerance: f64) {
    let list = theirs["bodies"].as_array().unwrap();
    assert_eq!(model.bodies.len(), list.len());
    for (body, other) in model.bodies.iter().zip(list).skip(1) {
        let what = format!("body '{}'", body.name);
        if other["name"] != "" {
            assert_eq!(body.name, other["name"].as_str().unwrap());
        }
        assert_eq!(u64::from(body.parent.0), other["parent"].as_u64().unwrap(), "{what}");
        assert_close(&body.placement.position.to_array(), &numbers(&other["pos"]), TOLERANCE, &what);
        let quat = numbers(&other["quat"]);
        let r = body.placement.rotation;
        let dot = r.w * quat[0] + r.x * quat[1] + r.y * quat[2] + r.z * quat[3];
        assert!((dot.abs() - 1.0).abs() < 1e-12, "{what}: {r:?} instead of {quat:?}");
        assert_close(&[body.inertia.mass], &numbers(&other["mass"]), tolerance, &what);
        if body.inertia.mass > 0.0 {
            assert_close(&body.inertia.center_of_mass.to_array(), &numbers(&other["com"]), tolerance, &what);
        }
        let inertia = matrix(&other["inertia"]);
        let size = inertia.x_axis.x + inertia.y_axis.y + inertia.z_axis.z;
        let off = difference(body.inertia.rotational, inertia);
        assert!(off <= tolerance * size, "{what}: {:?} instead of {inertia:?}", body.inertia.rotational);
    }
}

fn compare_joints(model: &Model, theirs: &Value) {
    let list = theirs["joints"].as_array().unwrap();
    assert_eq!(model.joints.len(), list.len());
    for (joint, other) in model.joints.iter().zip(list) {
        let what = format!("joint '{}'", joint.name);
        assert_eq!(u64::from(joint.body.0), other["body"].as_u64().unwrap(), "{what}");
        let (kind, axis) = match joint.kind {
            JointKind::Free => ("free", None),
            JointKind::Ball => ("ball", None),
            JointKind::Slide { axis } => ("slide", Some(axis)),
            JointKind::Hinge { axis } => ("hinge", Some(axis)),
        };
        assert_eq!(kind, other["type"], "{what}");
        if let Some(axis) = axis {
            assert_close(&axis.to_array(), &numbers(&other["axis"]), TOLERANCE, &what);
            let limits = joint.limits.map(|l| l.to_vec()).unwrap_or_default();
            let range = if other["range"].is_null() { Vec::new() } else { numbers(&other["range"]) };
            assert_close(&limits, &range, TOLERANCE, &what);
        }
        if kind != "free" {
            assert_close(&joint.anchor.to_array(), &numbers(&other["pos"]), TOLERANCE, &what);
        }
        for (field, ours) in [
            ("ref", joint.reference),
            ("springref", joint.spring_reference),
            ("stiffness", joint.stiffness),
            ("damping", joint.damping),
            ("armature", joint.armature),
            ("frictionloss", joint.friction_loss),
        ] {
            assert_close(&[ours], &numbers(&other[field]), TOLERANCE, &format!("{what} {field}"));
        }
    }
}

fn compare_geoms(model: &Model, theirs: &Value) {
    let list = theirs["geoms"].as_array().unwrap();
    assert_eq!(model.geoms.len(), list.len());
    for (geom, other) in model.geoms.iter().zip(list) {
        let what = format!("geom '{}'", geom.name);
        assert_eq!(u64::from(geom.body.0), other["body"].as_u64().unwrap(), "{what}");
        assert_close(&[geom.friction], &numbers(&other["friction"]), TOLERANCE, &what);
        assert_eq!(geom.frictional, other["condim"].as_u64().unwrap() >= 3, "{what}");
        assert_eq!(u64::from(geom.contact_type), other["contype"].as_u64().unwrap(), "{what}");
        assert_eq!(u64::from(geom.contact_affinity), other["conaffinity"].as_u64().unwrap(), "{what}");
        assert_close(&geom.rgba.map(f64::from), &numbers(&other["rgba"]), SINGLE, &what);
        let size = vector(&other["size"]);
        let (kind, ours) = match &geom.geometry {
            Geometry::Plane => ("plane", size),
            Geometry::Sphere { radius } => ("sphere", DVec3::new(*radius, size.y, size.z)),
            Geometry::Box { half_extents } => ("box", *half_extents),
            Geometry::Capsule { radius, half_length } => ("capsule", DVec3::new(*radius, *half_length, size.z)),
            Geometry::Cylinder { radius, half_length } => ("cylinder", DVec3::new(*radius, *half_length, size.z)),
            Geometry::Ellipsoid { semi_axes } => ("ellipsoid", *semi_axes),
            Geometry::ConvexMesh(mesh) => {
                let placed: Vec<DVec3> = mesh.vertices.iter().map(|p| geom.placement.transform_point(*p)).collect();
                compare_clouds(&placed, &other["vertices"], &what);
                ("mesh", size)
            }
            Geometry::HeightField(field) => {
                let stored = &theirs["height_fields"][0];
                assert_close(&field.heights, &numbers(&stored["heights"]), SINGLE, &what);
                assert_eq!(field.size[1] as u64, stored["rows"].as_u64().unwrap());
                ("hfield", size)
            }
            unexpected => panic!("{what} is a {}", unexpected.kind_name()),
        };
        assert_eq!(kind, other["type"], "{what}");
        assert_close(&ours.to_array(), &size.to_array(), TOLERANCE, &what);
        if kind != "mesh" {
            assert_close(&geom.placement.position.to_array(), &numbers(&other["pos"]), TOLERANCE, &what);
            let off = difference(geom.placement.rotation_matrix(), matrix(&other["rotation"]));
            assert!(off < TOLERANCE, "{what}: rotation differs by {off}");
        }
    }
}

/// The same points in any order.
fn compare_clouds(ours: &[DVec3], theirs: &Value, what: &str) {
    let theirs: Vec<DVec3> = theirs.as_array().unwrap().iter().map(vector).collect();
    assert_eq!(ours.len(), theirs.len(), "{what}");
    for p in ours {
        let nearest = theirs.iter().map(|q| (*p - *q).length()).fold(f64::INFINITY, f64::min);
        assert!(nearest < SINGLE, "{what}: vertex {p} is {nearest} m off");
    }
}

fn compare_actuators(model: &Model, theirs: &Value) {
    let list = theirs["actuators"].as_array().unwrap();
    assert_eq!(model.actuators.len(), list.len());
    for (actuator, other) in model.actuators.iter().zip(list) {
        let what = format!("actuator '{}'", actuator.name);
        let target = match actuator.transmission {
            Transmission::Joint(joint) | Transmission::JointAxes { joint, .. } => joint.0,
            Transmission::Tendon(tendon) => tendon.0,
            Transmission::Site { site, .. } => site.0,
            Transmission::Body { body, .. } => body.0,
        };
        assert_eq!(u64::from(target), other["joint"].as_u64().unwrap(), "{what}");
        let gear = match actuator.transmission {
            Transmission::JointAxes { axes, .. } | Transmission::Site { wrench: axes, .. } => axes.to_vec(),
            _ => vec![actuator.gear],
        };
        assert_close(&gear, &numbers(&other["gear"])[..gear.len()], TOLERANCE, &what);
        let (gear, gain, bias) = (actuator.gear, numbers(&other["gain"]), numbers(&other["bias"]));
        // Force on the joint for control c, length gear·q, velocity gear·q̇, as both engines define it.
        for (c, q, v) in [(0.3, 0.0, 0.0), (0.0, 0.4, 0.0), (0.0, 0.0, 0.5), (0.3, 0.4, 0.5)] {
            let affine = |p: &[f64]| p[0] + p[1] * gear * q + p[2] * gear * v;
            let expected = gear * (affine(&gain) * c + affine(&bias));
            let g = actuator.gear;
            let ours = match actuator.kind {
                ActuatorKind::Motor => g * c,
                ActuatorKind::Position { kp, kv } => g * (kp * (c - g * q) - kv * g * v),
                ActuatorKind::Velocity { kv } => g * kv * (c - g * v),
                ActuatorKind::Affine { gain, bias } => {
                    let by = |p: [f64; 3]| p[0] + p[1] * g * q + p[2] * g * v;
                    g * (by(gain) * c + by(bias))
                }
                ActuatorKind::Speed | ActuatorKind::Muscle(_) => unreachable!("no element of these files is one"),
            };
            assert_close(&[ours], &[expected], TOLERANCE, &what);
        }
        let range = |r: Option<[f64; 2]>| r.map(|r| r.to_vec()).unwrap_or_default();
        let stored = |field: &str| if other[field].is_null() { Vec::new() } else { numbers(&other[field]) };
        assert_close(&range(actuator.control_range), &stored("ctrlrange"), TOLERANCE, &what);
        assert_close(&range(actuator.force_range), &stored("forcerange"), TOLERANCE, &what);
    }
}

fn compare_sites(model: &Model, theirs: &Value) {
    let list = theirs["sites"].as_array().unwrap();
    assert_eq!(model.sites.len(), list.len());
    for (site, other) in model.sites.iter().zip(list) {
        let what = format!("site '{}'", site.name);
        assert_eq!(u64::from(site.body.0), other["body"].as_u64().unwrap(), "{what}");
        assert_close(&site.placement.position.to_array(), &numbers(&other["pos"]), TOLERANCE, &what);
        assert!(difference(site.placement.rotation_matrix(), matrix(&other["rotation"])) < 1e-12, "{what}");
        let size = vector(&other["size"]);
        let (kind, ours) = match site.zone {
            Geometry::Sphere { radius } => ("sphere", DVec3::new(radius, size.y, size.z)),
            Geometry::Box { half_extents } => ("box", half_extents),
            Geometry::Capsule { radius, half_length } => ("capsule", DVec3::new(radius, half_length, size.z)),
            Geometry::Cylinder { radius, half_length } => ("cylinder", DVec3::new(radius, half_length, size.z)),
            Geometry::Ellipsoid { semi_axes } => ("ellipsoid", semi_axes),
            _ => panic!("{what} has no such zone"),
        };
        assert_eq!(kind, other["type"], "{what}");
        assert_close(&ours.to_array(), &size.to_array(), TOLERANCE, &what);
    }
}

fn compare_tendons(model: &Model, theirs: &Value) {
    let list = theirs["tendons"].as_array().unwrap();
    assert_eq!(model.tendons.len(), list.len());
    for (tendon, other) in model.tendons.iter().zip(list) {
        let what = format!("tendon '{}'", tendon.name);
        let terms: Vec<f64> = tendon.terms.iter().flat_map(|(joint, c)| [f64::from(joint.0), *c]).collect();
        assert_close(&terms, &numbers(&other["terms"]), TOLERANCE, &what);
        assert_close(&[tendon.stiffness, tendon.damping], &numbers(&other["spring"]), TOLERANCE, &what);
        assert_close(&tendon.rest, &numbers(&other["rest"]), TOLERANCE, &what);
        let range = if other["range"].is_null() { Vec::new() } else { numbers(&other["range"]) };
        assert_close(&tendon.limits.map(|l| l.to_vec()).unwrap_or_default(), &range, TOLERANCE, &what);
    }
}

fn compare_keyframes(model: &Model, theirs: &Value) {
    let list = theirs["keyframes"].as_array().unwrap();
    assert_eq!(model.keyframes.len(), list.len());
    for (key, other) in model.keyframes.iter().zip(list) {
        assert_close(&[key.time], &numbers(&other["time"]), TOLERANCE, "time");
        assert_close(&key.q, &numbers(&other["qpos"]), TOLERANCE, "qpos");
        assert_close(&key.v, &numbers(&other["qvel"]), TOLERANCE, "qvel");
        assert_close(&key.control, &numbers(&other["ctrl"]), TOLERANCE, "ctrl");
    }
}

fn compare_pairs(model: &Model, theirs: &Value) {
    for entry in theirs["pairs"].as_array().unwrap() {
        let [a, b, friction] = numbers(entry)[..] else { panic!("three numbers") };
        let ours = model.pair_friction(GeomId(a as u32), GeomId(b as u32));
        assert_close(&[ours], &[friction], TOLERANCE, "friction of a pair");
    }
    let collides = |g: &Geometry| !matches!(g, Geometry::HeightField(_));
    let mut ours = Vec::new();
    for b in 0..model.geoms.len() {
        for a in 0..b {
            let geoms = (&model.geoms[a], &model.geoms[b]);
            let admitted = model.contact_filter.allows((GeomId(a as u32), GeomId(b as u32)), geoms);
            if admitted && collides(&geoms.0.geometry) && collides(&geoms.1.geometry) {
                ours.push((a as u64, b as u64));
            }
        }
    }
    let is_field = |g: u64| !collides(&model.geoms[g as usize].geometry);
    let index = |v: &Value| (v[0].as_u64().unwrap(), v[1].as_u64().unwrap());
    let mut stored: Vec<(u64, u64)> = theirs["admitted"].as_array().unwrap().iter().map(index).collect();
    stored.retain(|&(a, b)| !is_field(a) && !is_field(b));
    ours.sort_unstable();
    assert_eq!(ours, stored, "pairs of geoms that can touch");
}

#[test]
fn nested_default_classes() {
    compare("defaults");
}

#[test]
fn orientations_frames_and_replicas() {
    compare("poses");
}

#[test]
fn geoms_from_two_points() {
    compare("fromto");
}

#[test]
fn explicit_bounded_and_composed_inertia() {
    compare("inertia");
}

#[test]
fn joints_actuators_and_keyframes() {
    compare("joints");
}

#[test]
fn actuators_with_defaults_of_each_other() {
    compare("actuators");
}

#[test]
fn contact_masks_pairs_and_exclusions() {
    compare("contacts");
}

#[test]
fn mesh_vertices_inertia_and_height_fields() {
    compare_within("meshes", SINGLE);
}

#[test]
fn sites_tendons_and_general_actuators() {
    compare("instruments");
}

#[test]
fn disabled_contacts_and_gravity() {
    compare("disabled");
}

#[test]
fn included_files_and_total_mass() {
    compare("include");
}

#[test]
fn attached_models_bodies_and_frames() {
    compare_within("attach", SINGLE);
}

#[test]
fn meshes_from_parameters() {
    compare_within("builtin", SINGLE);
}

#[test]
fn height_fields_from_files() {
    compare("heights_image");
    compare("heights_binary");
}
