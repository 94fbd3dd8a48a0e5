//! Runs scenes of a JSON file and prints what counts: does it stand, how far did it sink and drift, was every step
//! certified, how long did a step take.
//!
//! ```text
//! cargo run --release -p signorini-benchmarks --bin peer_scenes -- SCENES.json [NAME ...] [--directions M]
//! ```

use std::time::Instant;

use signorini::multibody::glam::DVec3;
use signorini::{RunEnd, Settings, Simulation};
use signorini_benchmarks::scenes;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().ok_or("usage: peer_scenes SCENES.json [NAME ...] [--directions M]")?;
    let mut names: Vec<String> = Vec::new();
    let mut settings = Settings::default();
    while let Some(argument) = arguments.next() {
        if argument == "--directions" {
            settings.directions = arguments.next().ok_or("--directions needs a number")?.parse()?;
        } else {
            names.push(argument);
        }
    }
    let file: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(&path)?)?;
    println!(
        "{:<14} {:>6} {:>7} {:>5} {:>11} {:>11} {:>11} {:>10} {:>9} {:>9}",
        "scene", "steps", "missed", "nc", "drop um", "drift um", "sink um", "worst", "us median", "us p99"
    );
    for (name, scene) in file.as_object().ok_or("the file must hold an object of scenes")? {
        if scene["robot"].as_bool() == Some(true) || (!names.is_empty() && !names.contains(name)) {
            continue;
        }
        run(name, scene, settings.clone())?;
    }
    Ok(())
}

fn run(name: &str, scene: &serde_json::Value, settings: Settings) -> Result<(), Box<dyn std::error::Error>> {
    let scene = scenes::build(name, scene)?;
    let mut simulation = Simulation::new(scene.model, settings)?;
    simulation.input = scene.input;
    let start = positions(&simulation);
    let mut times = Vec::new();
    let mut mark = Instant::now();
    let end = simulation.run(scene.duration, |_, _| {
        times.push(mark.elapsed().as_secs_f64() * 1e6);
        mark = Instant::now();
        true
    })?;
    times.sort_by(f64::total_cmp);
    let moved = start.iter().zip(positions(&simulation)).map(|(a, b)| b - *a).collect::<Vec<_>>();
    let drop = moved.iter().map(|d| -d.z).fold(f64::MIN, f64::max);
    let drift = moved.iter().map(|d| d.truncate().length()).fold(0.0, f64::max);
    let summary = simulation.summary();
    println!(
        "{:<14} {:>6} {:>7} {:>5} {:>11.3e} {:>11.3e} {:>11.3e} {:>10.1e} {:>9.1} {:>9.1}",
        name,
        summary.steps,
        summary.missed_steps,
        summary.contacts_max,
        drop * 1e6,
        drift * 1e6,
        summary.deepest_penetration * 1e6,
        summary.worst.worst(),
        times[times.len() / 2],
        times[times.len() * 99 / 100],
    );
    if let RunEnd::NoSolution(report) = end {
        println!("    stopped at t = {:.4} s: {:?}", simulation.state().time, report.status);
    }
    Ok(())
}

/// World positions of all free bodies.
fn positions(simulation: &Simulation) -> Vec<DVec3> {
    let q = &simulation.state().q;
    let free = simulation.model().joints.iter().filter(|j| j.kind.nq() == 7);
    free.map(|j| DVec3::new(q[j.q_index], q[j.q_index + 1], q[j.q_index + 2])).collect()
}
