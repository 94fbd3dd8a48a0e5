//! Our side of `benchmarks/batch/compare.py`: batches of a robot that make steps when they are told to.
//!
//! Every line on the standard input is a number of threads; the batch with so many makes its next steps, and their wall time and
//! processor time are printed, s.
//! At the end of the input comes a line about all steps.

use std::error::Error;
use std::io::BufRead;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use clap::Parser;
use cpu_time::ProcessTime;
use signorini::multibody::Model;
use signorini::{Batch, Settings, Simulation};
use signorini_benchmarks::sim::{BatchTask, hash_of};

/// Steps batches of a robot in turns that another program gives
#[derive(Parser)]
struct Options {
    /// Task that compare.py writes: model, targets of the servos
    #[arg(long)]
    task: PathBuf,
    /// Simulations
    #[arg(long, default_value_t = 64)]
    simulations: usize,
    /// Steps in a turn
    #[arg(long, default_value_t = 250)]
    steps: usize,
    /// Numbers of threads
    #[arg(long, value_delimiter = ',', default_values_t = [1, 2])]
    threads: Vec<usize>,
}

/// A batch with its record.
struct Runner {
    threads: usize,
    batch: Batch,
    steps: usize,
    q: Vec<f64>,
    v: Vec<f64>,
    /// Steps whose certificate exceeds the tolerance, and the worst residual, of every simulation.
    missed: Vec<u64>,
    worst: Vec<f64>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let options = Options::parse();
    let task = BatchTask::read(&options.task)?;
    let model = Arc::new(signorini_formats::load(&task.model, &Default::default())?.model);
    let make = |&threads: &usize| Runner::new(&model, &task, &options, threads);
    let mut runners = options.threads.iter().map(make).collect::<Result<Vec<_>, _>>()?;
    println!("ready");
    for line in std::io::stdin().lock().lines() {
        let threads: usize = line?.trim().parse()?;
        let runner = runners.iter_mut().find(|r| r.threads == threads).ok_or("no batch with so many threads")?;
        let controls = task.controls(options.simulations, runner.steps, options.steps);
        let [wall, processor] = runner.turn(&controls, options.steps)?;
        println!("{wall} {processor}");
    }
    for runner in &runners {
        let missed: u64 = runner.missed.iter().sum();
        let worst = runner.worst.iter().copied().fold(0.0, f64::max);
        let height = (0..runner.batch.len()).map(|i| runner.batch.state(i).q[2]).fold(f64::INFINITY, f64::min);
        let steps = runner.steps * runner.batch.len();
        println!("{} {steps} {missed} {worst:.1e} {height:.4} {:016x}", runner.threads, runner.hash());
    }
    Ok(())
}

impl Runner {
    fn new(model: &Arc<Model>, task: &BatchTask, options: &Options, threads: usize) -> Result<Self, Box<dyn Error>> {
        let count = options.simulations;
        let mut batch = Batch::new(model.clone(), Settings::default(), count, threads)?;
        for i in 0..count {
            batch.state_mut(i).q.copy_from_slice(&task.start);
        }
        let record = |size: usize| vec![0.0; count * options.steps * size];
        let (q, v) = (record(model.nq), record(model.nv));
        Ok(Self { threads, batch, steps: 0, q, v, missed: vec![0; count], worst: vec![0.0; count] })
    }

    /// Makes the steps of a turn; their wall time and the time of all processors, s.
    fn turn(&mut self, controls: &[f64], steps: usize) -> Result<[f64; 2], Box<dyn Error>> {
        let (start, begin) = (Instant::now(), ProcessTime::now());
        let all = self.batch.rollout(steps, controls, &mut self.q, &mut self.v);
        let elapsed = [start.elapsed().as_secs_f64(), begin.elapsed().as_secs_f64()];
        if !all {
            return Err(format!("simulations stopped: {:?}", self.batch.stops().next()).into());
        }
        self.steps += steps;
        for i in 0..self.batch.len() {
            let summary = Simulation::summary(self.batch.simulation(i));
            (self.missed[i], self.worst[i]) = (summary.missed_steps, summary.worst.worst());
        }
        Ok(elapsed)
    }

    fn hash(&self) -> u64 {
        hash_of((0..self.batch.len()).map(|i| self.batch.state(i)))
    }
}
