//! Seeds solved on several threads.

use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use cpu_time::ThreadTime;
use signorini::contact::{Certificate, ContactProblem, ContactSolution, ContactSolver, SolveStatus, WarmStart};

use super::{FAMILIES, Finding, Judge, Outcome, Sequence, Step, Tally, Trial, examine, promised, sequence};

/// Residual up to which a claimed solution is one; for rounding ten times the solver's own tolerance.
const HOLDS: f64 = 1e-8;

/// The solver's own tolerance.
const TOLERANCE: f64 = 1e-9;

/// What a run may take.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Threads.
    pub threads: usize,
    /// Seconds of wall time for the problems of one seed.
    pub seconds: f64,
    /// Every so many seeds, what was not solved is examined with linear programs, too.
    pub examine_every: u64,
    /// How many linear programs; none for problems with more rows than the next number.
    pub programs: usize,
    /// Rows of the problems that are examined with linear programs.
    pub examined_rows: usize,
}

/// A thread's seed and when it began; nothing between two seeds, and for a thread that was given up.
type Clock = Arc<Mutex<Option<(u64, Instant)>>>;

/// Solves the problems of a range of seeds and calls `each` for every one, seed by seed in the order in which they end.
/// Returns the counts of each family.
pub fn run(seeds: Range<u64>, limits: Limits, mut each: impl FnMut(&Trial)) -> Vec<Tally> {
    let mut tallies = vec![Tally::default(); FAMILIES.len()];
    let mut left = seeds.end.saturating_sub(seeds.start);
    let pool = Pool { next: Arc::new(AtomicU64::new(seeds.start)), end: seeds.end, limits };
    let (sender, receiver) = channel();
    let mut clocks: Vec<Clock> = (0..limits.threads.max(1)).map(|_| pool.spawn(sender.clone())).collect();
    while left > 0 {
        let finished = match receiver.recv_timeout(Duration::from_millis(500)) {
            Ok(trials) => vec![trials],
            Err(_) => pool.give_up(&mut clocks, &sender),
        };
        for trials in finished {
            left -= 1;
            for trial in &trials {
                tallies[trial.family].add(trial);
                each(trial);
            }
        }
    }
    tallies
}

/// What the threads share.
struct Pool {
    next: Arc<AtomicU64>,
    end: u64,
    limits: Limits,
}

impl Pool {
    fn spawn(&self, sender: Sender<Vec<Trial>>) -> Clock {
        let clock = Clock::default();
        let (own, next, end, limits) = (clock.clone(), self.next.clone(), self.end, self.limits);
        std::thread::spawn(move || {
            let mut worker = Worker::default();
            loop {
                let seed = next.fetch_add(1, Ordering::Relaxed);
                if seed >= end {
                    return;
                }
                exchange(&own, Some((seed, Instant::now())));
                let trials = worker.run(seed, &limits);
                // A thread that was given up has been replaced, and its seed counted.
                if exchange(&own, None).is_none() || sender.send(trials).is_err() {
                    return;
                }
            }
        });
        clock
    }

    /// Replaces the threads that are over their time. Returns what became of their seeds.
    fn give_up(&self, clocks: &mut [Clock], sender: &Sender<Vec<Trial>>) -> Vec<Vec<Trial>> {
        let mut lost = Vec::new();
        for clock in clocks {
            let over = |begin: Instant| begin.elapsed().as_secs_f64() > self.limits.seconds;
            let Some((seed, begin)) = *lock(clock) else { continue };
            if over(begin) && exchange(clock, None).is_some_and(|(now, _)| now == seed) {
                lost.push(vec![timed_out(seed, begin)]);
                *clock = self.spawn(sender.clone());
            }
        }
        lost
    }
}

fn lock(clock: &Clock) -> MutexGuard<'_, Option<(u64, Instant)>> {
    clock.lock().unwrap_or_else(PoisonError::into_inner)
}

fn exchange(clock: &Clock, value: Option<(u64, Instant)>) -> Option<(u64, Instant)> {
    std::mem::replace(&mut *lock(clock), value)
}

/// The first problem stands for all of a seed whose time was up.
fn timed_out(seed: u64, begin: Instant) -> Trial {
    let Sequence { family, steps } = sequence(seed);
    Trial {
        seed,
        step: 0,
        family,
        rows: steps[0].problem.standard_layout().size,
        outcome: Outcome::TimedOut,
        status: String::new(),
        certificate: Certificate::default(),
        residual: f64::INFINITY,
        lemke: false,
        seconds: begin.elapsed().as_secs_f64(),
    }
}

/// The memory of a thread.
#[derive(Default)]
struct Worker {
    solver: ContactSolver,
    judge: Judge,
    start: WarmStart,
    solution: ContactSolution,
    before: ContactSolution,
}

impl Worker {
    fn run(&mut self, seed: u64, limits: &Limits) -> Vec<Trial> {
        let Sequence { family, steps } = sequence(seed);
        let mut trials = Vec::new();
        for (step, data) in steps.iter().enumerate() {
            self.load_start(data);
            let warm = (step > 0).then_some(&self.start);
            let begin = ThreadTime::now();
            let solve = || self.solver.solve_into(&data.problem, warm, &mut self.solution);
            let ended = catch_unwind(AssertUnwindSafe(solve)).is_ok();
            let seconds = begin.elapsed().as_secs_f64();
            let residual = if ended { self.judge.residual(&data.problem, &self.solution) } else { f64::INFINITY };
            let rows = data.problem.standard_layout().size;
            let examined = seed.is_multiple_of(limits.examine_every.max(1)) && rows <= limits.examined_rows;
            let programs = if examined { limits.programs } else { 0 };
            let outcome = if ended { self.outcome(&data.problem, residual, programs) } else { Outcome::Panicked };
            trials.push(Trial {
                seed,
                step,
                family,
                rows,
                outcome,
                status: if ended { format!("{:?}", self.solution.status) } else { String::new() },
                certificate: self.solution.certificate,
                residual,
                lemke: ended && self.solution.report.lemke_islands > 0,
                seconds,
            });
            if !ended {
                *self = Self::default();
                break;
            }
            std::mem::swap(&mut self.before, &mut self.solution);
        }
        trials
    }

    fn load_start(&mut self, step: &Step) {
        self.start.clear();
        step.contacts.iter().for_each(|&from| self.start.push(&self.before, from));
        step.groups.iter().for_each(|&from| self.start.push_group(&self.before, from));
        self.start.set_bilateral(&self.before.bilateral);
    }

    fn outcome(&self, problem: &ContactProblem, residual: f64, programs: usize) -> Outcome {
        let denied = match self.solution.status {
            SolveStatus::Solved if residual <= HOLDS => return Outcome::Solved,
            SolveStatus::Solved if residual <= self.judge.rounding() => return Outcome::ClaimedRounded,
            SolveStatus::Solved => return Outcome::FalselyClaimed,
            SolveStatus::Ray { .. } | SolveStatus::Infeasible { .. } => true,
            _ if residual <= TOLERANCE => return Outcome::Unclaimed,
            _ if residual <= self.judge.rounding() => return Outcome::Rounded,
            _ => false,
        };
        let exists = if denied { Outcome::WronglyDenied } else { Outcome::Missed };
        if promised(problem) {
            return exists;
        }
        match (examine(problem, programs), denied) {
            (Finding::Solvable(_), _) => exists,
            (Finding::Infeasible, true) => Outcome::Infeasible,
            (Finding::NoSolution, true) => Outcome::NoSolution,
            (Finding::Infeasible | Finding::NoSolution, false) => Outcome::InaccurateWithoutSolution,
            (Finding::Open, true) => Outcome::Denied,
            (Finding::Open, false) => Outcome::Inaccurate,
        }
    }
}
