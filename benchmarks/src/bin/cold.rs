//! What a cold solve takes, in factorisations of its own system: the first step of scenes, and contact problems without a start.
//! See `benchmarks/README.md`.

use std::error::Error;
use std::path::{Path, PathBuf};

use clap::Parser;
use cpu_time::ThreadTime;
use serde_json::Value;
use signorini::contact::projection::Cones;
use signorini::contact::{ContactProblem, ContactSolution, ContactSolver, Islands, ProximalSystem, SolverSettings};
use signorini::{Settings, Simulation};
use signorini_benchmarks::contact_lcp::{Problem, Spec};
use signorini_benchmarks::sim::build;
use signorini_benchmarks::table;

/// ε of the systems: the weight with which proximal iterations end.
const EPSILON: f64 = 1e-5;

/// Factorisations of one system, of which the quickest counts.
const TRIES: usize = 3;

/// Compares cold solves with one factorisation of their largest island's system.
#[derive(Parser)]
struct Options {
    /// Scenes of the file that scenes.py makes, whose first step is made, or contact problems as `contact_lcp` names them: `list:75:8`
    /// (seed, directions), `cluster:320:8` (bodies), `stack:500:8`
    #[arg(required = true)]
    problems: Vec<String>,
    /// The file with the scenes [default: build/peers/sim/scenes.json of the repository]
    #[arg(long)]
    data: Option<PathBuf>,
    /// Tolerance of the certificate
    #[arg(long, default_value_t = 1e-9)]
    tolerance: f64,
}

/// A cold solve, and the problem that was solved.
struct Cold {
    problem: ContactProblem,
    solution: ContactSolution,
    factorizations: u32,
    worst: f64,
    seconds: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options::parse();
    let path = options.data.clone();
    let path = path.unwrap_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../build/peers/sim/scenes.json"));
    let header =
        "problem|contacts|in the largest island|worst residual|cold solve s|factorisations|one of them s|as many as";
    let mut rows = vec![header.split('|').map(str::to_owned).collect::<Vec<_>>()];
    for name in &options.problems {
        let cold = match name.parse::<Spec>() {
            Ok(spec) => of_problem(&spec, options.tolerance)?,
            Err(_) => first_step(name, &path, options.tolerance)?,
        };
        let (contacts, one) = one_factorization(&cold)?;
        rows.push(vec![
            name.clone(),
            cold.problem.contact_count().to_string(),
            contacts.to_string(),
            format!("{:.1e}", cold.worst),
            format!("{:.3}", cold.seconds),
            cold.factorizations.to_string(),
            format!("{one:.5}"),
            format!("{:.0}", cold.seconds / one),
        ]);
        eprintln!("{}", rows[rows.len() - 1].join(" | "));
    }
    print!("{}", table::markdown(&rows));
    Ok(())
}

/// The first step of a scene, collisions and all.
fn first_step(name: &str, path: &Path, tolerance: f64) -> Result<Cold, Box<dyn Error>> {
    let file: Value = serde_json::from_str(&std::fs::read_to_string(path)?)?;
    let scene = file.get(name).ok_or_else(|| format!("{name} is neither a problem nor in {}", path.display()))?;
    let scene = build(name, scene, Path::new(""))?;
    let mut simulation = Simulation::new(scene.model, Settings::default().with_tolerance(tolerance))?;
    simulation.input = scene.input;
    let clock = ThreadTime::now();
    let report = simulation.step()?;
    let (seconds, factorizations, worst) =
        (clock.elapsed().as_secs_f64(), report.solver.factorizations, report.certificate.worst());
    let (problem, solution) = (simulation.workspace().problem().clone(), simulation.workspace().solution().clone());
    Ok(Cold { problem, solution, factorizations, worst, seconds })
}

/// A contact problem, solved without a start.
fn of_problem(spec: &Spec, tolerance: f64) -> Result<Cold, Box<dyn Error>> {
    let Problem::Contact(problem) = spec.build()? else { return Err(format!("{spec} has no bodies").into()) };
    let mut solver = ContactSolver::new(SolverSettings::default().for_tolerance(tolerance))?;
    let mut solution = ContactSolution::default();
    let clock = ThreadTime::now();
    solver.solve_into(&problem, None, &mut solution);
    let (seconds, factorizations) = (clock.elapsed().as_secs_f64(), solution.report.factorizations);
    let worst = solution.certificate.worst();
    Ok(Cold { problem: *problem, solution, factorizations, worst, seconds })
}

/// Contacts of the largest island, and the CPU time of assembling and factorising its system in the modes of the solution, s; its
/// structure and order of elimination are known.
fn one_factorization(cold: &Cold) -> Result<(usize, f64), Box<dyn Error>> {
    let Cold { problem, solution, .. } = cold;
    let (mut cones, mut islands, mut system) = (Cones::default(), Islands::default(), ProximalSystem::default());
    cones.prepare(problem);
    islands.find(problem);
    islands.assemble(problem, |_| true);
    let island = islands.all().iter().max_by_key(|island| island.nv()).ok_or("no islands")?;
    let weights = |scales: &[f64]| scales.iter().map(|g| 1.0 / (EPSILON * g)).collect::<Vec<_>>();
    let (weight, bilateral) = (weights(&island.scale), weights(&island.bilateral_scale));
    let modes: Vec<_> = island.units.iter().map(|&i| solution.solver_modes[i as usize]).collect();
    system.analyse(problem, island);
    system.prepare(problem, island, &bilateral);
    let mut best = f64::INFINITY;
    for _ in 0..TRIES {
        let clock = ThreadTime::now();
        if !system.factor(island, &cones, &modes, &weight) {
            return Err("a singular system".into());
        }
        best = best.min(clock.elapsed().as_secs_f64());
    }
    Ok((island.contact_count, best))
}
