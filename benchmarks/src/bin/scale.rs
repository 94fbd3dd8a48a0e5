//! Large scenes and many scenes: fields of stacks in separated islands, with islands on several threads and with sleeping,
//! and batches of a robot. Everything that is compared takes turns in one run. See `benchmarks/scale/README.md`.

use std::error::Error;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use clap::Parser;
use signorini::contact::SolverSettings;
use signorini::multibody::Model;
use signorini::{Batch, ContactMethod, Settings, Simulation};
use signorini_benchmarks::{sim, table};

/// Steps that a batch makes before its threads meet again.
const STEPS_A_CALL: u64 = 20;

/// Runs fields of stacks and batches.
#[derive(Parser)]
struct Options {
    /// Stacks in the field; 0 runs the batch alone
    #[arg(long, default_value_t = 250)]
    stacks: usize,
    /// Cubes in a stack
    #[arg(long, default_value_t = 4)]
    height: usize,
    /// Steps
    #[arg(long, default_value_t = 120)]
    steps: usize,
    /// Numbers of threads to compare
    #[arg(long, value_delimiter = ',', default_values_t = [1, 2])]
    threads: Vec<usize>,
    /// Also with sleeping, on the first number of threads
    #[arg(long)]
    sleeping: bool,
    /// Simulations of the quadruped in a batch; 0 leaves the batch out
    #[arg(long, default_value_t = 0)]
    batch: usize,
    /// A few steps only: shows in seconds that the program works
    #[arg(long)]
    smoke: bool,
}

/// One of those that take turns.
struct Runner {
    name: String,
    simulation: Simulation,
    /// Wall time of every step, µs.
    times: Vec<f64>,
    sleeping_islands: usize,
    islands: usize,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut options = Options::parse();
    if options.smoke {
        (options.stacks, options.steps, options.batch, options.sleeping) = (16, 4, 4, true);
    }
    if options.stacks > 0 {
        field(&options)?;
    }
    if options.batch > 0 {
        batch(&options)?;
    }
    if let Some(peak) = peak_memory() {
        println!("peak memory of the program: {peak} MiB");
    }
    Ok(())
}

fn field(options: &Options) -> Result<(), Box<dyn Error>> {
    let model = Arc::new(sim::field(options.stacks, options.height)?);
    let mut runners = Vec::new();
    for &threads in &options.threads {
        runners.push(Runner::new(&model, threads, false)?);
    }
    if let (true, Some(&threads)) = (options.sleeping, options.threads.first()) {
        runners.push(Runner::new(&model, threads, true)?);
    }
    for _ in 0..options.steps {
        for runner in &mut runners {
            runner.step()?;
        }
    }
    let first = &runners[0];
    for other in &runners[1..] {
        let (a, b) = (first.simulation.state(), other.simulation.state());
        let apart = a.q.iter().zip(&b.q).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
        println!("{} and {}: same bits {}, apart by {apart:.1e}", first.name, other.name, a == b);
    }
    let header = "field|runner|steps|missed|worst residual|contacts|islands|asleep|us a step|at the end|times faster";
    let mut rows = vec![header.split('|').map(str::to_owned).collect::<Vec<_>>()];
    let quarter = runners[0].last_quarter();
    for runner in &runners {
        let summary = runner.simulation.summary();
        rows.push(vec![
            model.name.clone(),
            runner.name.clone(),
            summary.steps.to_string(),
            summary.missed_steps.to_string(),
            format!("{:.1e}", summary.worst.worst()),
            summary.contacts_max.to_string(),
            runner.islands.to_string(),
            runner.sleeping_islands.to_string(),
            format!("{:.0}", table::quantile(&mut runner.times.clone(), 0.5)),
            format!("{:.0}", runner.last_quarter()),
            format!("{:.2}", quarter / runner.last_quarter()),
        ]);
    }
    print!("{}", table::markdown(&rows));
    Ok(())
}

impl Runner {
    fn new(model: &Arc<Model>, threads: usize, sleeping: bool) -> Result<Self, Box<dyn Error>> {
        let solver = SolverSettings::default().with_threads(threads);
        let method = ContactMethod::Structured(solver);
        let simulation =
            Simulation::new(model.clone(), Settings::default().with_method(method).with_sleeping(sleeping))?;
        let name = format!("{threads} threads{}", if sleeping { ", sleeping" } else { "" });
        Ok(Self { name, simulation, times: Vec::new(), sleeping_islands: 0, islands: 0 })
    }

    fn step(&mut self) -> Result<(), Box<dyn Error>> {
        let start = Instant::now();
        let report = self.simulation.step()?;
        self.times.push(start.elapsed().as_secs_f64() * 1e6);
        (self.islands, self.sleeping_islands) = (report.solver.islands, report.solver.sleeping_islands);
        Ok(())
    }

    /// Median time of the last quarter of the steps, µs.
    fn last_quarter(&self) -> f64 {
        table::quantile(&mut self.times[self.times.len() * 3 / 4..].to_vec(), 0.5)
    }
}

/// The quadruped, so many times, on all numbers of threads.
fn batch(options: &Options) -> Result<(), Box<dyn Error>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/quadruped.xml");
    let model = Arc::new(signorini_formats::load(path, &Default::default())?.model);
    let mut batches = Vec::new();
    for &threads in &options.threads {
        let mut batch = Batch::new(model.clone(), Settings::default(), options.batch, threads)?;
        (0..options.batch).for_each(|i| batch.state_mut(i).v[0] = 0.01 * i as f64);
        batches.push((threads, batch, Vec::new()));
    }
    for _ in 0..options.steps.div_ceil(STEPS_A_CALL as usize) {
        for (_, batch, times) in &mut batches {
            let start = Instant::now();
            batch.step(STEPS_A_CALL);
            times.push(start.elapsed().as_secs_f64() * 1e6 / STEPS_A_CALL as f64);
        }
    }
    let mut rows = vec![vec!["quadrupeds".into(), "threads".into(), "us a step of all".into(), "times faster".into()]];
    let first = table::quantile(&mut batches[0].2.clone(), 0.5);
    for (threads, batch, times) in &mut batches {
        let time = table::quantile(times, 0.5);
        let row = [batch.len().to_string(), threads.to_string(), format!("{time:.0}"), format!("{:.2}", first / time)];
        rows.push(row.to_vec());
    }
    print!("{}", table::markdown(&rows));
    Ok(())
}

/// Peak resident memory of this process, MiB, where the system tells it (Linux).
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(line.trim().trim_end_matches("kB").trim().parse::<u64>().ok()? / 1024)
}
