//! Lets robots of others fall on a floor. See `benchmarks/robots/README.md`.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Parser;
use signorini::{InfeasiblePolicy, OverlapPolicy, RunEnd, Settings, Simulation};
use signorini_benchmarks::robots::{self, ROBOTS, Robot};
use signorini_benchmarks::table;

/// Height of a robot's lowest point over the floor at the start, m.
const CLEARANCE: f64 = 0.05;

/// Lets robots fall on a floor, without control.
#[derive(Parser)]
struct Options {
    /// Names of robots; all where none is given
    names: Vec<String>,
    /// Folder of all robots [default: what benchmarks/robots/fetch.py fetched]
    #[arg(long)]
    data: Option<PathBuf>,
    /// Simulated time, s
    #[arg(long, default_value_t = 2.0)]
    duration: f64,
    /// Time step, s
    #[arg(long, default_value_t = 0.002)]
    timestep: f64,
    /// Friction of the floor, and at least that of all shapes
    #[arg(long, default_value_t = 0.7)]
    friction: f64,
    /// Friction directions
    #[arg(long, default_value_t = 8)]
    directions: usize,
    /// Factor on the correction of penetrations, in (0, 1]
    #[arg(long, default_value_t = 1.0)]
    stabilization: f64,
    /// Whether the links of a robot meet each other, too (the convex hulls of some overlap from the start)
    #[arg(long)]
    self_collision: bool,
    /// Stop where penetrations make a step unsolvable, instead of taking negative gaps as zero
    #[arg(long)]
    stop: bool,
    /// Print every warning of the import
    #[arg(long)]
    warnings: bool,
    /// A few steps only: shows in seconds that the program works
    #[arg(long)]
    smoke: bool,
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options::parse();
    let fetched = concat!(env!("CARGO_MANIFEST_DIR"), "/../build/robots/cmeel.prefix/share/example-robot-data/robots");
    let folder = options.data.clone().unwrap_or_else(|| PathBuf::from(fetched));
    if !folder.is_dir() {
        println!("skipped: no robots in {}; fetch them with benchmarks/robots/fetch.py", folder.display());
        return Ok(());
    }
    let header = "robot|nv|shapes|warnings (motion)|overlap at start mm|contacts|steps|missed|clipped|worst residual|\
                  deepest mm|steps/s|end";
    let mut rows = vec![header.split('|').map(str::to_owned).collect::<Vec<_>>()];
    for robot in ROBOTS.iter().filter(|r| options.names.is_empty() || options.names.iter().any(|n| n == r.name)) {
        rows.push(fall(&options, &folder, robot).unwrap_or_else(|e| {
            let mut row = vec![robot.name.to_owned()];
            row.resize(12, String::new());
            row.push(e.to_string());
            row
        }));
    }
    print!("{}", table::markdown(&rows));
    Ok(())
}

/// Simulates one robot and gives its row of the table.
fn fall(options: &Options, folder: &Path, robot: &Robot) -> Result<Vec<String>, Box<dyn Error>> {
    let (model, report) = robots::load_above_floor(folder, robot, options.friction, options.self_collision)?;
    if options.warnings {
        print!("{report}");
    }
    let start = robots::state_above_floor(&model, CLEARANCE)?;
    let (overlap, between) = robots::deepest_overlap(&model, &start)?;
    if overlap > 0.0 {
        println!("{}: starts with {:.2} mm of overlap between {between}", robot.name, overlap * 1e3);
    }
    let settings = Settings::default()
        .with_timestep(options.timestep)
        .with_directions(options.directions)
        .with_stabilization(options.stabilization)
        .with_overlaps(OverlapPolicy::Keep)
        .with_infeasible(if options.stop { InfeasiblePolicy::Stop } else { InfeasiblePolicy::ClipGaps });
    let (nv, shapes) = (model.nv, model.geoms.len() - 1);
    let mut simulation = Simulation::new(model, settings)?;
    simulation.set_state(&start)?;
    simulation.assemble()?;
    let begin = Instant::now();
    let duration = if options.smoke { 10.0 * options.timestep } else { options.duration };
    let end = match simulation.run(duration, |_, _| true) {
        Ok(RunEnd::NoSolution(report)) => format!("stopped: {:?}", report.status),
        Ok(_) => at_rest(&simulation),
        Err(error) => error.to_string(),
    };
    let seconds = begin.elapsed().as_secs_f64();
    let summary = simulation.summary();
    Ok(vec![
        robot.name.to_owned(),
        nv.to_string(),
        shapes.to_string(),
        format!("{} ({})", report.warnings.len(), report.motion_warnings().count()),
        format!("{:.2}", overlap * 1e3),
        summary.contacts_max.to_string(),
        summary.steps.to_string(),
        summary.missed_steps.to_string(),
        summary.clipped_steps.to_string(),
        format!("{:.1e}", summary.worst.worst()),
        format!("{:.2}", summary.deepest_penetration * 1e3),
        format!("{:.0}", summary.steps as f64 / seconds),
        end,
    ])
}

/// What moves at the end.
fn at_rest(simulation: &Simulation) -> String {
    let fastest = simulation.state().v.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    format!("t = {:.2} s, max |v| {fastest:.1e}", simulation.state().time)
}
