//! Runs the scenes that all engines are given with the same numbers, and prints what counts: was every step certified, how far did
//! bodies sink and drift, how long did a step take. See `benchmarks/sim/README.md`.

use std::error::Error;
use std::path::{Path, PathBuf};

use clap::Parser;
use serde_json::Value;
use signorini::contact::SolverSettings;
use signorini::{ContactMethod, InfeasiblePolicy, Settings, Snapshot};
use signorini_benchmarks::sim::{Run, Settled, drive, settle};
use signorini_benchmarks::table;

/// A fraction of a body's height by which it may drop or drift and still count as standing.
const STANDING: f64 = 0.3;

/// Scenes in which something is meant to stand.
const STANDS: [&str; 7] = ["S1_stick", "S2", "S3", "S4r", "S8", "S9", "S13"];

/// Bricks of a bin that `--smoke` runs at most.
const SMOKE_BRICKS: usize = 400;

/// Runs scenes of a JSON file.
#[derive(Parser)]
struct Options {
    /// Names of scenes or their beginnings; all where none is given
    names: Vec<String>,
    /// The file that scenes.py makes [default: build/peers/sim/scenes.json of the repository]
    #[arg(long)]
    data: Option<PathBuf>,
    /// Folder with the robots that scenes.py writes [default: build/peers/robots of the repository]
    #[arg(long)]
    robots: Option<PathBuf>,
    /// Friction directions
    #[arg(long, default_value_t = 8)]
    directions: usize,
    /// Factor on the correction of penetrations, in (0, 1]
    #[arg(long, default_value_t = 1.0)]
    stabilization: f64,
    /// Tolerance of the certificate; islands are accepted at half of it
    #[arg(long, default_value_t = 1e-9)]
    tolerance: f64,
    /// Contact sweeps a step may make; exact steps where it is not given
    #[arg(long)]
    budget: Option<u32>,
    /// Degrees of freedom from which islands are given to contact sweeps first
    #[arg(long)]
    sweeps_from: Option<usize>,
    /// Take negative gaps as zero where they make a step unsolvable, instead of stopping
    #[arg(long)]
    clip: bool,
    /// End a scene after this many seconds of CPU time
    #[arg(long, default_value_t = 20.0)]
    cap: f64,
    /// Write the run of the scene to this file, as JSON, for compare.py; exactly one scene
    #[arg(long)]
    raw: Option<PathBuf>,
    /// Bring the bodies of scenes to rest and add these scenes to the file, S4s_… as S4r_…, others with _rest behind their names,
    /// and beside it a snapshot with the impulses that hold them; those that it has already are left out
    #[arg(long)]
    settle: bool,
    /// A few steps only: shows in seconds that the program works
    #[arg(long)]
    smoke: bool,
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options::parse();
    let build = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../build/peers"));
    let path = options.data.clone().unwrap_or_else(|| build.join("sim/scenes.json"));
    let robots = options.robots.clone().unwrap_or_else(|| build.join("robots"));
    if !path.exists() {
        println!("skipped: no scenes in {}; `python3 benchmarks/sim/scenes.py {0}` makes them", path.display());
        return Ok(());
    }
    let file: Value = serde_json::from_str(&std::fs::read_to_string(&path)?)?;
    let scenes = file.as_object().ok_or("the scenes are not a JSON object")?;
    let named = |name: &str, n: &str| name == n || (!scenes.contains_key(n) && begins(name, n));
    let wanted = |name: &str| options.names.is_empty() || options.names.iter().any(|n| named(name, n));
    let chosen: Vec<(&String, &Value)> = scenes.iter().filter(|(name, _)| wanted(name)).collect();
    if chosen.is_empty() || (options.raw.is_some() && chosen.len() != 1) {
        return Err(format!("{} scenes of {} have these names", chosen.len(), path.display()).into());
    }
    let usual = SolverSettings::default();
    let sweeps_from = options.sweeps_from.unwrap_or(usual.sweeps_from);
    let solver = usual.with_sweeps_from(sweeps_from);
    let settings = Settings::default()
        .with_tolerance(options.tolerance)
        .with_budget(options.budget)
        .with_method(ContactMethod::Structured(solver))
        .with_directions(options.directions)
        .with_stabilization(options.stabilization)
        .with_infeasible(if options.clip { InfeasiblePolicy::ClipGaps } else { InfeasiblePolicy::Stop });
    if options.settle {
        return add_settled(&path, &file, &chosen, &robots, &settings);
    }
    let header = "scene|steps|missed|clipped|worst residual|contacts|drop um|drift um|sink um|us a step|us p99|verdict";
    let mut rows = vec![header.split('|').map(str::to_owned).collect::<Vec<_>>()];
    for (name, scene) in chosen {
        let robot = scene["mjcf"].as_str().map(|file| robots.join(file));
        if let Some(missing) = robot.filter(|file| !file.exists()) {
            println!("{name} skipped: no {}; benchmarks/sim/run fetches it", missing.display());
            continue;
        }
        let mut scene = scene.clone();
        if options.smoke {
            if name.starts_with("S13") && scene["bodies"].as_array().is_some_and(|bodies| bodies.len() > SMOKE_BRICKS) {
                println!("{name} left out: its first, cold step takes minutes in an unoptimised build");
                continue;
            }
            scene["duration"] = (5.0 * scene["dt"].as_f64().unwrap_or(0.0)).into();
        }
        let rest = scene["snapshot"].as_str().map(|file| snapshot(&path.with_file_name(file))).transpose()?;
        let cap = if options.smoke { 1.0 } else { options.cap };
        let run = drive(name, &scene, rest.as_ref(), &robots, &settings, cap)?;
        if let Some(out) = &options.raw {
            std::fs::write(out, serde_json::to_string(&run)?)?;
        }
        rows.push(row(name, &scene, &run));
    }
    print!("{}", table::markdown(&rows));
    Ok(())
}

/// Adds scenes at rest to the file, each as soon as it is found.
fn add_settled(
    path: &Path,
    file: &Value,
    chosen: &[(&String, &Value)],
    robots: &Path,
    settings: &Settings,
) -> Result<(), Box<dyn Error>> {
    let mut file = file.clone();
    let mut rows = vec![Settled::HEADER.map(str::to_owned).to_vec()];
    for (name, scene) in chosen {
        let rest = name.strip_prefix("S4s_").map_or(format!("{name}_rest"), |pile| format!("S4r_{pile}"));
        if !file[&rest].is_null() {
            continue;
        }
        let mut settled = settle(name, &rest, scene, robots, settings)?;
        rows.push(settled.row(&rest));
        let snapshot = format!("{rest}.state");
        std::fs::write(path.with_file_name(&snapshot), settled.snapshot.to_bytes())?;
        settled.scene["snapshot"] = snapshot.into();
        file[rest] = settled.scene;
        std::fs::write(path, serde_json::to_string(&file)?)?;
    }
    print!("{}", table::markdown(&rows));
    Ok(())
}

/// Reads where a scene begins that was brought to rest.
fn snapshot(file: &Path) -> Result<Snapshot, Box<dyn Error>> {
    let bytes = std::fs::read(file).map_err(|e| format!("{}: {e}; `--settle` writes it", file.display()))?;
    Ok(Snapshot::from_bytes(&bytes).map_err(|e| format!("{}: {e}", file.display()))?)
}

/// Whether a scene belongs to a beginning: `S4` stands for `S4_…`, not for `S4s_…`; a whole name stands for itself alone.
fn begins(name: &str, start: &str) -> bool {
    name.strip_prefix(start).is_some_and(|rest| rest.starts_with('_'))
}

fn row(name: &str, scene: &Value, run: &Run) -> Vec<String> {
    let (drop, drift) = run.largest_motion();
    let micro = |times: &[u64], q| table::quantile(&mut times.iter().map(|&t| t as f64 / 1e3).collect::<Vec<_>>(), q);
    let worst = run.certificates.iter().copied().fold(0.0, f64::max);
    let height = 2.0 * scene["bodies"][0][3].as_f64().unwrap_or(0.0);
    let stands = if drop.max(drift) < STANDING * height { "stands" } else { "fell" };
    let verdict = match &run.error {
        Some(error) => error.clone(),
        None if !run.finished() => format!("only {} steps", run.done),
        None if STANDS.iter().any(|s| name == *s || begins(name, s)) => stands.to_owned(),
        None => String::new(),
    };
    vec![
        name.to_owned(),
        run.done.to_string(),
        run.missed.to_string(),
        run.clipped.to_string(),
        format!("{worst:.1e}"),
        run.contacts_max.to_string(),
        format!("{:.3}", drop * 1e6),
        format!("{:.3}", drift * 1e6),
        format!("{:.3}", run.deepest * 1e6),
        format!("{:.1}", micro(&run.step_ns[run.step_ns.len() * 3 / 4..], 0.5)),
        format!("{:.1}", micro(&run.step_ns, 0.99)),
        verdict,
    ]
}
