//! Loads every model file of folders and lets each move for a while. See `benchmarks/robots/README.md`.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::Parser;
use signorini::multibody::{Model, State};
use signorini::{InfeasiblePolicy, RunEnd, Settings, Simulation};
use signorini_benchmarks::{robots, table};
use signorini_formats::{FormatError, ImportReport, LoadOptions, load};

/// Loads every model file below the folders and simulates it.
#[derive(Parser)]
struct Options {
    /// Folders or files [default: what benchmarks/robots/fetch.py fetched]
    paths: Vec<PathBuf>,
    /// Simulated time, s
    #[arg(long, default_value_t = 1.0)]
    duration: f64,
    /// Computing time after which a run is broken off, s
    #[arg(long, default_value_t = 60.0)]
    patience: f64,
    /// Print every warning of the imports
    #[arg(long)]
    warnings: bool,
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options::parse();
    let fetched = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../build/robots"));
    let roots = if options.paths.is_empty() { vec![fetched] } else { options.paths.clone() };
    if let Some(missing) = roots.iter().find(|root| !root.exists()) {
        println!("skipped: there is no {}; fetch the models with benchmarks/robots/fetch.py", missing.display());
        return Ok(());
    }
    let mut files = Vec::new();
    roots.iter().for_each(|root| find_models(root, &mut files));
    files.sort();
    let header = "file|nv|geoms|not taken over|steps|missed|clipped|end";
    let mut rows = vec![header.split('|').map(str::to_owned).collect::<Vec<_>>()];
    let (mut loaded, mut ran) = (0, 0);
    for file in &files {
        let shown = short(&roots, &file.to_string_lossy());
        let start = Instant::now();
        let cells = match import(file) {
            Err(error) => vec!["".into(); 6]
                .into_iter()
                .chain([format!("refused: {}", short(&roots, &error.to_string()))])
                .collect(),
            Ok((model, report)) => {
                loaded += 1;
                if options.warnings {
                    print!("{report}");
                }
                let (cells, finished) = run(&options, model, &report);
                ran += usize::from(finished);
                cells
            }
        };
        eprintln!("{:6.1} s  {shown}", start.elapsed().as_secs_f64());
        rows.push(std::iter::once(shown).chain(cells).collect());
    }
    print!("{}", table::markdown(&rows));
    println!("\n{} files, {loaded} loaded, {ran} simulated to the end without a failed step", files.len());
    Ok(())
}

/// A text without the folders that all files are in.
fn short(roots: &[PathBuf], text: &str) -> String {
    let inside = roots.iter().fold(text.to_owned(), |text, root| text.replace(&format!("{}/", root.display()), ""));
    inside.replace("cmeel.prefix/share/example-robot-data/robots/", "")
}

/// Collects what looks like a model: URDF, SDF, and XML whose first element is MuJoCo's.
fn find_models(path: &Path, out: &mut Vec<PathBuf>) {
    if path.is_dir() {
        let entries = std::fs::read_dir(path).into_iter().flatten().flatten();
        entries.for_each(|entry| find_models(&entry.path(), out));
        return;
    }
    let is_model = match path.extension().and_then(|e| e.to_str()) {
        Some("urdf" | "sdf") => true,
        Some("xml") => {
            std::fs::read_to_string(path).is_ok_and(|text| text.contains("<mujoco") && !text.contains("<mujocoinclude"))
        }
        _ => false,
    };
    if is_model {
        out.push(path.to_owned());
    }
}

/// The model of a file. The links of a URDF meet nothing: their convex hulls often overlap.
fn import(file: &Path) -> Result<(Model, ImportReport), FormatError> {
    let mut imported = load(file, &LoadOptions::default())?;
    if file.extension().is_some_and(|e| e == "urdf") {
        imported.model.geoms.iter_mut().for_each(|geom| geom.contact_affinity = 0);
    }
    Ok((imported.model, imported.report))
}

/// Simulates a model; its cells of the table, and whether it came to the end without a failed step.
fn run(options: &Options, model: Model, report: &ImportReport) -> (Vec<String>, bool) {
    let mut cells = vec![model.nv.to_string(), model.geoms.len().to_string(), left_out(report)];
    match simulate(options, model) {
        Ok((summary, end, finished)) => {
            cells.extend(summary.map(|n| n.to_string()));
            cells.push(end);
            (cells, finished)
        }
        Err(error) => {
            cells.resize(6, String::new());
            cells.push(error.to_string());
            (cells, false)
        }
    }
}

/// Steps, missed and clipped ones; how the run ended; whether it came to its end.
fn simulate(options: &Options, model: Model) -> Result<([u64; 3], String, bool), Box<dyn Error>> {
    let settings = Settings::default().with_infeasible(InfeasiblePolicy::ClipGaps);
    let start = start(&model);
    let keyframe = model.keyframes.first().map(|k| k.name.clone());
    let mut simulation = Simulation::new(model, settings)?;
    match keyframe {
        Some(name) => simulation.reset_to(&name)?,
        None => simulation.set_state(&start)?,
    }
    let (begin, patience) = (Instant::now(), Duration::from_secs_f64(options.patience));
    let end = simulation.run(options.duration, |_, _| begin.elapsed() < patience)?;
    let finite = simulation.state().v.iter().all(|v| v.is_finite());
    let (text, finished) = match end {
        RunEnd::Finished if finite => ("finished".to_owned(), true),
        RunEnd::Finished => ("not finite".to_owned(), false),
        RunEnd::NoSolution(report) => (format!("no solution: {:?}", report.status), false),
        RunEnd::Stopped => (format!("broken off at t = {:.2} s", simulation.state().time), false),
    };
    let summary = simulation.summary();
    Ok(([summary.steps, summary.missed_steps, summary.clipped_steps], text, finished))
}

/// The reference configuration with every joint inside its limits.
fn start(model: &Model) -> State {
    let mut state = State::new(model);
    robots::clamp_to_limits(model, &mut state);
    state
}

/// What of a file can change the motion and is not taken over: elements with what is missing, shortened.
fn left_out(report: &ImportReport) -> String {
    let mut words: Vec<String> = Vec::new();
    for warning in report.motion_warnings() {
        let what = warning.what.split(['\'', '(']).nth(1).filter(|w| !w.contains(' ')).unwrap_or("");
        let word = if what.is_empty() { warning.element.clone() } else { format!("{} {what}", warning.element) };
        if !words.contains(&word) {
            words.push(word);
        }
    }
    words.join(", ")
}
