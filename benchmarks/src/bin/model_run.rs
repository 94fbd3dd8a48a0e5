//! Loads one model file, lets it move, and prints what happened as lines of JSON: one after loading, one at the end of the
//! run. `benchmarks/robots/corpus.py` gives each file a process of its own. See `benchmarks/robots/README.md`.

use std::error::Error;
use std::path::{Path, PathBuf};

use clap::Parser;
use cpu_time::{ProcessTime, ThreadTime};
use serde_json::{Map, Value, json};
use signorini::contact::SolverSettings;
use signorini::multibody::{Body, Kinematics, Model, Pose, State, forward_kinematics_into};
use signorini::{ContactMethod, RunEnd, Settings, Simulation, SimulationError};
use signorini_benchmarks::table::quantile;
use signorini_formats::{Imported, LoadOptions, load};

/// Loads a model file and simulates it as `signorini simulate` does.
#[derive(Parser)]
struct Options {
    /// The model file
    file: PathBuf,
    /// Simulated time, s
    #[arg(long, default_value_t = 1.0)]
    duration: f64,
    /// CPU time of the run after which it is broken off, s
    #[arg(long, default_value_t = 20.0)]
    patience: f64,
    /// JSON file with the control values of every step, a list of lists; the last one stays
    #[arg(long)]
    control: Option<PathBuf>,
    /// Tolerance of the certificate
    #[arg(long, default_value_t = 1e-9)]
    tolerance: f64,
    /// Contact sweeps a step may make; exact steps where it is not given
    #[arg(long)]
    budget: Option<u32>,
    /// Contacts from which islands are given to contact sweeps first
    #[arg(long)]
    sweeps_from: Option<usize>,
    /// Print what the stages of the solver did, and the time that they took
    #[arg(long)]
    stages: bool,
    /// Keyframe to begin with [default: the reference configuration]
    #[arg(long)]
    keyframe: Option<String>,
    /// Folder in which packages of `package://…` are looked for; may be given more than once
    #[arg(long)]
    package_dir: Vec<PathBuf>,
    /// Take meshes apart into convex parts of at most this concavity, in (0, 1]
    #[arg(long)]
    decompose: Option<f64>,
    /// Points at which two convex shapes touch at most; 0: all
    #[arg(long)]
    contact_points: Option<usize>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options::parse();
    let begin = ProcessTime::now();
    let mut load_options = LoadOptions::default().with_decompose(options.decompose);
    load_options.package_dirs.clone_from(&options.package_dir);
    let made = load(&options.file, &load_options).map_err(|e| ("refused", e.to_string())).and_then(|imported| {
        let usual = SolverSettings::default();
        let sweeps_from = options.sweeps_from.unwrap_or(usual.sweeps_from);
        let solver = usual.with_sweeps_from(sweeps_from).with_time_stages(options.stages);
        let settings = Settings::default()
            .with_tolerance(options.tolerance)
            .with_budget(options.budget)
            .with_method(ContactMethod::Structured(solver))
            .with_contact_points(options.contact_points.unwrap_or(Settings::default().contact_points));
        let simulation = Simulation::new(imported.model.clone(), settings).map_err(|e| ("refused", e.to_string()))?;
        Ok((imported, simulation))
    });
    let (imported, mut simulation) = match made {
        Ok(made) => made,
        Err((end, message)) => {
            println!("{}", json!({ "end": end, "message": message }));
            return Ok(());
        }
    };
    println!("{}", loading(&imported, begin.elapsed().as_secs_f64()));
    println!("{}", run(&options, &mut simulation));
    if options.stages {
        for (stage, count) in simulation.summary().stages.iter().filter(|(_, count)| count.asked > 0) {
            let seconds = 1e-9 * count.nanoseconds as f64;
            eprintln!("{:16} asked {:8} ended {:8} {seconds:9.3} s", stage.name(), count.asked, count.ended);
        }
    }
    Ok(())
}

/// What loading came to.
fn loading(imported: &Imported, seconds: f64) -> Value {
    let (model, report) = (&imported.model, &imported.report);
    let left_out = report.motion_warnings().map(ToString::to_string).collect::<Vec<_>>();
    json!({
        "load_s": seconds,
        "nv": model.nv,
        "geoms": model.geoms.len(),
        "actuators": model.actuators.len(),
        "timestep": model.timestep,
        "warnings": report.warnings.len(),
        "left_out": left_out,
    })
}

/// What the run came to.
fn run(options: &Options, simulation: &mut Simulation) -> Value {
    if let Some(keyframe) = &options.keyframe
        && let Err(error) = simulation.reset_to(keyframe)
    {
        return json!({ "end": "error", "message": error.to_string() });
    }
    let start = poses(simulation.model(), simulation.state());
    let mut times = Times::default();
    let controls = match options.control.as_deref().map(read_controls).transpose() {
        Ok(controls) => controls.unwrap_or_default(),
        Err(error) => return json!({ "end": "error", "message": error.to_string() }),
    };
    let result = step_on(options, &controls, simulation, &mut times);
    let (end, message) = match result {
        Err(error) => ("error", error.to_string()),
        Ok(_) if !simulation.state().v.iter().all(|v| v.is_finite()) => ("not finite", String::new()),
        Ok(RunEnd::Finished) => ("finished", String::new()),
        Ok(RunEnd::NoSolution(report)) => ("no solution", format!("{:?}", report.status)),
        Ok(RunEnd::Stopped) => ("patience", String::new()),
    };
    let summary = simulation.summary();
    json!({
        "end": end,
        "message": message,
        "time": simulation.state().time,
        "steps": summary.steps,
        "missed": summary.missed_steps,
        "worst": summary.worst.worst(),
        "contacts_max": summary.contacts_max,
        "contacts_end": simulation.report().contacts,
        "deepest_mm": 1e3 * summary.deepest_penetration,
        "fastest": simulation.state().v.iter().fold(0.0_f64, |a, v| a.max(v.abs())),
        "total_s": 1e-6 * times.all.iter().sum::<f64>(),
        "factorizations": times.factorizations,
        "slowest_us": times.all.iter().copied().fold(0.0, f64::max),
        "mean_us": times.all.iter().sum::<f64>() / times.all.len().max(1) as f64,
        "median_us": quantile(&mut times.all, 0.5),
        "p99_us": quantile(&mut times.all, 0.99),
        "enlargements": times.enlargements,
        "solves": times.solves,
        "points_found": times.found,
        "limited": summary.limited_steps,
        "smallest_theta": summary.smallest_theta,
        "deepest_kept": summary.deepest_kept,
        "limited_slowest_us": times.limited.iter().copied().fold(0.0, f64::max),
        "limited_median_us": quantile(&mut times.limited, 0.5),
        "full_median_us": quantile(&mut times.full, 0.5),
        "start": start,
        "poses": poses(simulation.model(), simulation.state()),
    })
}

/// What steps took, µs: all of them, those that were permitted a part of their corrections only (θ < 1), and the others.
#[derive(Default)]
struct Times {
    all: Vec<f64>,
    limited: Vec<f64>,
    full: Vec<f64>,
    /// Further searches for contacts, solved problems, factorisations, and the points that searches found, in all steps.
    enlargements: u64,
    solves: u64,
    factorizations: u64,
    found: u64,
}

impl Times {
    fn note(&mut self, microseconds: f64, is_limited: bool) {
        self.all.push(microseconds);
        if is_limited { &mut self.limited } else { &mut self.full }.push(microseconds);
    }
}

fn read_controls(file: &Path) -> Result<Vec<Vec<f64>>, Box<dyn Error>> {
    Ok(serde_json::from_str(&std::fs::read_to_string(file)?)?)
}

/// Steps until the time, or the patience, is over; notes what each step took.
fn step_on(
    options: &Options,
    controls: &[Vec<f64>],
    simulation: &mut Simulation,
    times: &mut Times,
) -> Result<RunEnd, SimulationError> {
    let begin = ThreadTime::now();
    let steps = (options.duration / simulation.timestep()).round() as u64;
    for step in 0..steps as usize {
        if let Some(control) = controls.get(step) {
            simulation.input.control.clone_from(control);
        }
        let clock = ThreadTime::now();
        let advanced = simulation.step()?.advanced();
        let seconds = clock.elapsed().as_secs_f64();
        let report = simulation.report();
        times.enlargements += u64::from(report.enlargements);
        times.solves += u64::from(report.solves);
        times.found += simulation.workspace().candidate_points().count() as u64;
        times.factorizations += u64::from(report.solver.factorizations);
        times.note(1e6 * seconds, report.theta < 1.0);
        if !advanced {
            return Ok(RunEnd::NoSolution(Box::new(simulation.report().clone())));
        }
        if begin.elapsed().as_secs_f64() > options.patience {
            return Ok(RunEnd::Stopped);
        }
    }
    Ok(RunEnd::Finished)
}

/// Position and quaternion (w first) of every body but the world, by name.
fn poses(model: &Model, state: &State) -> Map<String, Value> {
    let mut kinematics = Kinematics::new(model);
    forward_kinematics_into(model, &state.q, &state.v, &mut kinematics);
    let pose = |(body, pose): (&Body, &Pose)| {
        let (p, r) = (pose.position, pose.rotation);
        (body.name.clone(), json!([p.x, p.y, p.z, r.w, r.x, r.y, r.z]))
    };
    model.bodies.iter().zip(&kinematics.pose).skip(1).map(pose).collect()
}
