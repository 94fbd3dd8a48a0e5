//! Loads one model file, lets it move, and prints what happened as lines of JSON: one after loading, one at the end of the
//! run. `benchmarks/robots/corpus.py` gives each file a process of its own. See `benchmarks/robots/README.md`.

use std::error::Error;
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Parser;
use cpu_time::{ProcessTime, ThreadTime};
use serde_json::{Map, Value, json};
use signorini::contact::{SolveStatus, SolverSettings};
use signorini::multibody::{Body, Kinematics, Model, Pose, State, forward_kinematics_into};
use signorini::{ContactMethod, RunEnd, Settings, Simulation, Snapshot, StepReport};
use signorini_benchmarks::random_steps::Judge;
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
    /// Gaps and overlaps of at most this many metres count as closed
    #[arg(long, default_value_t = 0.0)]
    gap_resolution: f64,
    /// Degrees of freedom from which islands are given to contact sweeps first
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
    /// CSV file to write a line to for every step: what it took and what was done in it
    #[arg(long)]
    trace: Option<PathBuf>,
    /// File with a saved state to begin with, where it exists; the state at the end is written to it
    #[arg(long)]
    snapshot: Option<PathBuf>,
    /// Judge every step by a second writing of the laws, too, which shares no code with the certificate
    #[arg(long)]
    judge: bool,
}

/// A step called solved is called wrong where the second judge finds a residual above so many times its tolerance.
const WRONG: f64 = 1e3;

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
            .with_gap_resolution(options.gap_resolution)
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
            eprintln!("{:16} asked {:8} ended {:8} {seconds:11.5} s", stage.name(), count.asked, count.ended);
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
    if let Some(Err(error)) =
        options.snapshot.as_deref().filter(|file| file.exists()).map(|file| resume(file, simulation))
    {
        return json!({ "end": "error", "message": error.to_string() });
    }
    let start = poses(simulation.model(), simulation.state());
    let resident = resident_kib();
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
    let saved = options.snapshot.as_deref().map(|file| std::fs::write(file, simulation.save().to_bytes()));
    let (end, message) = match saved {
        Some(Err(error)) => ("error", error.to_string()),
        _ => (end, message),
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
        "steady_steps": times.steady.len(),
        "steady_slowest_us": times.steady.iter().copied().fold(0.0, f64::max),
        "steady_median_us": quantile(&mut times.steady, 0.5),
        "steady_p99_us": quantile(&mut times.steady, 0.99),
        "enlargements": times.enlargements,
        "solves": times.solves,
        "points_found": times.found,
        "limited": summary.limited_steps,
        "smallest_theta": summary.smallest_theta,
        "deepest_kept": summary.deepest_kept,
        "limited_slowest_us": times.limited.iter().copied().fold(0.0, f64::max),
        "limited_median_us": quantile(&mut times.limited, 0.5),
        "full_median_us": quantile(&mut times.full, 0.5),
        "correction_energy": summary.correction_energy,
        "judged_worst": times.judged_worst,
        "judged_wrong": times.judged_wrong,
        "resident_kib": [resident, resident_kib()],
        "start": start,
        "poses": poses(simulation.model(), simulation.state()),
    })
}

/// Steps in a row with as many contacts, after which the next one of them belongs to a motion that goes on as it was. Chosen by reasoning: a change of
/// contacts is solved within a few steps, and scenes that move have few runs of more (drums 1 % of their steps).
const STEADY: u32 = 10;

/// What steps took, µs: all of them, those that were permitted a part of their corrections only (θ < 1), and the others.
#[derive(Default)]
struct Times {
    all: Vec<f64>,
    limited: Vec<f64>,
    full: Vec<f64>,
    /// Those with as many contacts as each of the last [`STEADY`].
    steady: Vec<f64>,
    /// The number of contacts of the last step, and how many steps before it had as many.
    contacts: usize,
    alike: u32,
    /// Further searches for contacts, solved problems, factorisations, and the points that searches found, in all steps.
    enlargements: u64,
    solves: u64,
    factorizations: u64,
    found: u64,
    /// Worst residual that the second judge found in a step called solved, and in how many it found too much.
    judge: Judge,
    judged_worst: f64,
    judged_wrong: u64,
}

impl Times {
    fn note(&mut self, microseconds: f64, report: &StepReport) {
        self.all.push(microseconds);
        if report.theta < 1.0 { &mut self.limited } else { &mut self.full }.push(microseconds);
        self.alike = if report.contacts == self.contacts { self.alike + 1 } else { 0 };
        self.contacts = report.contacts;
        if self.alike >= STEADY {
            self.steady.push(microseconds);
        }
    }
}

/// A table of the steps while it grows.
struct Trace(std::io::BufWriter<std::fs::File>);

impl Trace {
    fn create(file: &Path) -> std::io::Result<Self> {
        let mut out = std::io::BufWriter::new(std::fs::File::create(file)?);
        writeln!(
            out,
            "step,us,theta,kept,contacts,solves,enlargements,factorizations,mode_changes,proximal,worst,stages"
        )?;
        Ok(Self(out))
    }

    fn step(&mut self, step: usize, microseconds: f64, report: &StepReport) -> std::io::Result<()> {
        let StepReport { theta, kept, contacts, solves, enlargements, solver, .. } = report;
        let (kept, worst) = (kept.len(), report.certificate.worst());
        let (lu, changes, proximal) = (solver.factorizations, solver.mode_changes, solver.proximal_iterations);
        let stages = solver.stages.iter().filter(|(_, count)| count.asked > 0);
        let stages: Vec<_> = stages.map(|(stage, c)| format!("{}:{}/{}", stage.name(), c.ended, c.asked)).collect();
        let stages = stages.join(" ");
        writeln!(
            self.0,
            "{step},{microseconds:.1},{theta},{kept},{contacts},{solves},{enlargements},{lu},{changes},{proximal},{worst:.1e},{stages}"
        )
    }
}

/// Goes on from the saved state in a file.
fn resume(file: &Path, simulation: &mut Simulation) -> Result<(), Box<dyn Error>> {
    Ok(simulation.restore(&Snapshot::from_bytes(&std::fs::read(file)?)?)?)
}

/// Memory of this process that is in use, KiB; 0 where the system does not say.
fn resident_kib() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    line.and_then(|line| line.trim().trim_end_matches(" kB").parse().ok()).unwrap_or(0)
}

fn read_controls(file: &Path) -> Result<Vec<Vec<f64>>, Box<dyn Error>> {
    Ok(serde_json::from_str(&std::fs::read_to_string(file)?)?)
}

/// What the clock takes for a measurement of nothing, which is as much as the step of a small model, s.
fn clock_cost() -> f64 {
    quantile(&mut (0..101).map(|_| ThreadTime::now().elapsed().as_secs_f64()).collect::<Vec<_>>(), 0.5)
}

/// Steps until the time, or the patience, is over; notes what each step took.
fn step_on(
    options: &Options,
    controls: &[Vec<f64>],
    simulation: &mut Simulation,
    times: &mut Times,
) -> Result<RunEnd, Box<dyn Error>> {
    let mut trace = options.trace.as_deref().map(Trace::create).transpose()?;
    let (begin, nothing) = (ThreadTime::now(), clock_cost());
    let steps = (options.duration / simulation.timestep()).round() as u64;
    for step in 0..steps as usize {
        if let Some(control) = controls.get(step) {
            simulation.input.control.clone_from(control);
        }
        let clock = ThreadTime::now();
        let advanced = simulation.step()?.advanced();
        let seconds = (clock.elapsed().as_secs_f64() - nothing).max(0.0);
        let report = simulation.report();
        times.enlargements += u64::from(report.enlargements);
        times.solves += u64::from(report.solves);
        times.found += simulation.workspace().candidate_points().count() as u64;
        times.factorizations += u64::from(report.solver.factorizations);
        times.note(1e6 * seconds, report);
        if let Some(trace) = &mut trace {
            trace.step(step, 1e6 * seconds, report)?;
        }
        if options.judge && report.status == SolveStatus::Solved {
            let (problem, solution) = (simulation.workspace().problem(), simulation.workspace().solution());
            let violation = times.judge.residual(problem, solution);
            times.judged_worst = times.judged_worst.max(violation);
            times.judged_wrong += u64::from(violation > WRONG * options.tolerance + times.judge.rounding());
        }
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
