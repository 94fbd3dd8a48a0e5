//! Runs scenes that are given to all engines with the same numbers, and prints what counts: does it stand, how far did it
//! sink and drift, was every step certified, how long did a step take. See `benchmarks/sim/README.md`.

use std::error::Error;
use std::path::PathBuf;
use std::time::Instant;

use clap::Parser;
use serde_json::Value;
use signorini::multibody::glam::DVec3;
use signorini::{InfeasiblePolicy, RunEnd, Settings, Simulation};
use signorini_benchmarks::{scenes, table};

/// What is run where no scene is named: stacks and mechanisms that end within a minute.
const USUAL: [&str; 8] =
    ["S1_slide", "S1_stick", "S2_stack10", "S2_stack20", "S3_wall10", "S8_cards", "S9_massratio", "S12_gripper"];

/// A fraction of a body's height by which it may drop or drift and still count as standing.
const STANDING: f64 = 0.3;

/// Runs scenes of a JSON file.
#[derive(Parser)]
struct Options {
    /// Names of scenes; the usual ones where none is given
    names: Vec<String>,
    /// The file [default: ../shared/peers/sim/scenes.json beside the repository]
    #[arg(long)]
    data: Option<PathBuf>,
    /// Friction directions
    #[arg(long, default_value_t = 8)]
    directions: usize,
    /// Factor on the correction of penetrations, in (0, 1]
    #[arg(long, default_value_t = 1.0)]
    stabilization: f64,
    /// Take negative gaps as zero where they make a step unsolvable, instead of stopping
    #[arg(long)]
    clip: bool,
    /// End a scene after this many seconds of wall time
    #[arg(long, default_value_t = 120.0)]
    cap: f64,
    /// A few steps only: shows in seconds that the program works
    #[arg(long)]
    smoke: bool,
}

/// The course of a run.
struct Course {
    /// Wall time of every step, µs.
    times: Vec<f64>,
    /// Time of each step and position of the first body after it.
    path: Vec<(f64, DVec3)>,
    end: RunEnd,
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options::parse();
    let path = options.data.clone().unwrap_or_else(|| table::shared("peers/sim/scenes.json"));
    if !path.exists() {
        println!("skipped: no scenes in {}", path.display());
        return Ok(());
    }
    let file: Value = serde_json::from_str(&std::fs::read_to_string(&path)?)?;
    let names: Vec<&str> =
        if options.names.is_empty() { USUAL.to_vec() } else { options.names.iter().map(String::as_str).collect() };
    let header = "scene|steps|missed|clipped|worst residual|contacts|drop um|drift um|sink um|us a step|us p99|verdict";
    let mut rows = vec![header.split('|').map(str::to_owned).collect::<Vec<_>>()];
    for name in names {
        if !file[name].is_object() {
            return Err(format!("there is no scene '{name}' in {}", path.display()).into());
        }
        rows.push(row(&options, name, &file[name])?);
    }
    print!("{}", table::markdown(&rows));
    Ok(())
}

fn row(options: &Options, name: &str, data: &Value) -> Result<Vec<String>, Box<dyn Error>> {
    let scene = scenes::build(name, data)?;
    let settings = Settings {
        directions: options.directions,
        stabilization: options.stabilization,
        infeasible: if options.clip { InfeasiblePolicy::ClipGaps } else { InfeasiblePolicy::Stop },
        ..Settings::default()
    };
    let mut simulation = Simulation::new(scene.model, settings)?;
    simulation.input = scene.input;
    let start = positions(&simulation);
    let steps = if options.smoke { 5.0 * simulation.timestep() } else { scene.duration };
    let course = run(&mut simulation, steps, options.cap)?;
    let moved: Vec<DVec3> = start.iter().zip(positions(&simulation)).map(|(a, b)| b - *a).collect();
    let drop = moved.iter().map(|d| -d.z).fold(f64::MIN, f64::max).max(0.0);
    let drift = moved.iter().map(|d| d.truncate().length()).fold(0.0, f64::max);
    let summary = simulation.summary();
    let mut times = course.times.clone();
    let mut last_quarter = times.split_off(times.len() * 3 / 4);
    let mut all = course.times.clone();
    Ok(vec![
        name.to_owned(),
        summary.steps.to_string(),
        summary.missed_steps.to_string(),
        summary.clipped_steps.to_string(),
        format!("{:.1e}", summary.worst.worst()),
        summary.contacts_max.to_string(),
        format!("{:.3}", drop * 1e6),
        format!("{:.3}", drift * 1e6),
        format!("{:.3}", summary.deepest_penetration * 1e6),
        format!("{:.1}", table::quantile(&mut last_quarter, 0.5)),
        format!("{:.1}", table::quantile(&mut all, 0.99)),
        verdict(name, data, &course, drop.max(drift)),
    ])
}

fn run(simulation: &mut Simulation, duration: f64, cap: f64) -> Result<Course, Box<dyn Error>> {
    let (mut times, mut path) = (Vec::new(), vec![(0.0, first(simulation))]);
    let begin = Instant::now();
    let mut mark = begin;
    let end = simulation.run(duration, |simulation, _| {
        times.push(mark.elapsed().as_secs_f64() * 1e6);
        path.push((simulation.state().time, first(simulation)));
        mark = Instant::now();
        begin.elapsed().as_secs_f64() < cap
    })?;
    Ok(Course { times, path, end })
}

/// What the scene is about, in words.
fn verdict(name: &str, data: &Value, course: &Course, moved: f64) -> String {
    let (time, last) = course.path[course.path.len() - 1];
    let ended = match &course.end {
        RunEnd::NoSolution(report) => format!("stopped at {time:.3} s: {:?}; ", report.status),
        RunEnd::Stopped => format!("only {time:.3} s; "),
        RunEnd::Finished => String::new(),
    };
    let along = |t: f64| course.path.iter().find(|(time, _)| *time >= t - 1e-9).map_or(last, |p| p.1);
    let words = match name {
        "S1_slide" => {
            let exact = slide(data, course.path.len() - 1);
            format!("slid {:.6} m, {:.1e} % off", last.x - course.path[0].1.x, slide_error(course, exact))
        }
        "S1_stick" => format!("creeps {:.1e} mm/s", 1e3 * (last - along(2.0)).x / (time - 2.0).max(1e-9)),
        "S12_gripper" => format!("slips {:.1e} mm/s", 1e3 * (along(1.0) - last).z / (time - 1.0).max(1e-9)),
        _ if name.starts_with("S4") || name.starts_with("S5") => String::new(),
        _ => {
            let height = 2.0 * data["bodies"][0][3].as_f64().unwrap_or(0.0);
            (if moved < STANDING * height { "stands" } else { "fell" }).to_owned()
        }
    };
    ended + &words
}

/// How far the box of S1 slides in `n` steps of the semi-implicit scheme, m: `a Δt² n(n+1)/2` with `a = g_x − μ|g_z|`.
fn slide(data: &Value, n: usize) -> f64 {
    let number = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
    let acceleration = number(&data["gravity"][0]) - number(&data["mu"]) * number(&data["gravity"][2]).abs();
    acceleration * number(&data["dt"]).powi(2) * (n * (n + 1)) as f64 / 2.0
}

fn slide_error(course: &Course, exact: f64) -> f64 {
    100.0 * ((course.path[course.path.len() - 1].1.x - course.path[0].1.x) / exact - 1.0).abs()
}

/// World position of the first free body.
fn first(simulation: &Simulation) -> DVec3 {
    positions(simulation).first().copied().unwrap_or(DVec3::ZERO)
}

/// World positions of all free bodies.
fn positions(simulation: &Simulation) -> Vec<DVec3> {
    let q = &simulation.state().q;
    let free = simulation.model().joints.iter().filter(|j| j.kind.nq() == 7);
    free.map(|j| DVec3::new(q[j.q_index], q[j.q_index + 1], q[j.q_index + 2])).collect()
}
