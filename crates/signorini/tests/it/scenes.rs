//! Bundled scenes do what their first comment says; those that only stand are in `stacking`.

use signorini::Simulation;
use signorini::multibody::glam::DVec3;

use crate::support::{body_poses, bundled, run_certified, run_observed};

fn body(simulation: &Simulation, name: &str) -> DVec3 {
    body_poses(simulation)[simulation.model().body_named(name).unwrap().index()].position
}

#[test]
fn every_scene_is_tested_and_listed() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes");
    let list = std::fs::read_to_string(format!("{folder}/README.md")).unwrap();
    let tests = [include_str!("scenes.rs"), include_str!("stacking.rs")].concat();
    let mut count = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let Some(name) = name.strip_suffix(".xml") else { continue };
        count += 1;
        assert!(list.contains(&format!("({name}.xml)")), "{name} is not in the list");
        assert!(tests.contains(&format!("bundled(\"{name}\")")), "{name} is not tested");
    }
    assert!(count >= 9);
}

#[test]
fn incline() {
    let mut simulation = bundled("incline");
    let (slider, sticker) = (body(&simulation, "slider"), body(&simulation, "sticker"));
    run_certified(&mut simulation, 5.0);
    assert!((body(&simulation, "sticker") - sticker).length() < 1e-9);
    let slid = body(&simulation, "slider") - slider;
    assert!(slid.x > 2.0 && body(&simulation, "slider").z < 0.11, "slid by {slid}");
    assert!(simulation.state().v.iter().all(|v| v.abs() < 1e-9), "all at rest");
}

#[test]
fn gripper() {
    let mut simulation = bundled("gripper");
    let floor = body(&simulation, "box").z;
    run_certified(&mut simulation, 0.5);
    let held = |now: &Simulation| body(now, "box") - body(now, "palm");
    let start = held(&simulation);
    let mut slip = 0.0_f64;
    run_observed(&mut simulation, 3.0, |now, _| slip = slip.max((held(now) - start).length()));
    assert!(slip < 3e-9, "slips {slip:e} m in 3 s");
    assert!(body(&simulation, "box").z - floor > 0.27);
}

#[test]
fn quadruped() {
    let mut simulation = bundled("quadruped");
    let start = body(&simulation, "torso");
    run_certified(&mut simulation, 4.0);
    let sag = start.z - body(&simulation, "torso").z;
    assert!(sag > 0.0 && sag < 0.02, "sags by {sag} m");
    assert!(simulation.state().v.iter().all(|v| v.abs() < 1e-8), "{:?}", simulation.state().v);
}

#[test]
fn dominoes() {
    let mut simulation = bundled("dominoes");
    run_certified(&mut simulation, 1.0);
    let poses = body_poses(&simulation);
    for pose in &poses[1..] {
        let upward = pose.rotation * DVec3::Z;
        assert!(upward.x > 0.5, "a domino still stands: {upward}");
    }
}

/// A fast top of axial moment I₃ and spin s, its centre of mass at d from the tip, precesses at about m g d / (I₃ s).
#[test]
fn spinning_top() {
    let mut simulation = bundled("spinning_top");
    let inertia = simulation.model().bodies[1].inertia;
    let rate = 9.81 * inertia.mass * inertia.center_of_mass.z / (inertia.rotational.z_axis.z * 150.0);
    let (mut angle, mut before) = (0.0, DVec3::X);
    run_observed(&mut simulation, 2.0, |now, _| {
        let axis = body_poses(now)[1].rotation * DVec3::Z;
        assert!(axis.z > 16_f64.to_radians().cos(), "it falls: {axis}");
        angle += (before.x * axis.y - before.y * axis.x).atan2(before.x * axis.x + before.y * axis.y);
        before = axis;
    });
    let turned = angle / (2.0 * rate);
    assert!((0.8..1.25).contains(&turned), "precesses at {turned} times the rate of the fast top");
}
