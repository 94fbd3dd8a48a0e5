//! Solving the islands of a problem, on one thread or on several.
//!
//! An island's result depends on nothing but the island: it is solved into an [`Outcome`] of its own, and the outcomes are
//! written to the solution by one thread. The bits are those of one thread, however many there are.

use std::sync::{Mutex, PoisonError};

use rayon::iter::{IndexedParallelIterator, IntoParallelRefMutIterator, ParallelIterator};

use super::SolverSettings;
use super::attempts::{Start, solve_island};
use super::island::Island;
use super::island_solver::{Effort, IslandSolver};
use signorini_contact::projection::{Cones, Mode};
use signorini_contact::{ContactProblem, ContactSolution};

/// Contacts, friction groups and bilateral rows outside the largest island from which threads are worth their wake-up.
const PARALLEL_ROWS: usize = 96;

/// What the attempts on an island gave.
#[derive(Clone, Debug, Default)]
pub(super) struct Outcome {
    island: usize,
    pub residual: f64,
    pub effort: Effort,
    pub restarts: u32,
    /// Whether nothing had to be solved.
    pub asleep: bool,
    /// Units whose rows are proved to contradict each other.
    pub contradiction: Vec<u32>,
    impulse: Vec<[f64; 3]>,
    modes: Vec<Mode>,
    bilateral: Vec<f64>,
    velocity: Vec<f64>,
}

impl Outcome {
    /// Takes over the iterate of a solver.
    pub fn take(&mut self, solver: &IslandSolver) {
        self.impulse.clone_from(&solver.impulse);
        self.modes.clone_from(&solver.modes);
        self.bilateral.clone_from(&solver.bilateral_impulse);
        self.velocity.clone_from(&solver.velocity);
    }

    /// Gives a solver what was taken.
    pub fn give(&self, solver: &mut IslandSolver) {
        solver.impulse.clone_from(&self.impulse);
        solver.modes.clone_from(&self.modes);
        solver.bilateral_impulse.clone_from(&self.bilateral);
    }

    /// Forgets an earlier island.
    fn begin(&mut self, island: usize) {
        (self.island, self.residual) = (island, f64::INFINITY);
        (self.effort, self.restarts, self.asleep) = (Effort::default(), 0, false);
        self.contradiction.clear();
    }

    /// Writes impulses, modes and velocity to their places. An island that no attempt brought to a number leaves them alone.
    fn write(&self, island: &Island, solution: &mut ContactSolution) {
        self.effort.add_to(&mut solution.report);
        solution.report.restarts += self.restarts;
        solution.report.sleeping_islands += usize::from(self.asleep);
        if self.residual == f64::INFINITY {
            return;
        }
        for (c, &i) in island.units.iter().enumerate() {
            let mode = self.modes.get(c).copied().unwrap_or(Mode::Open);
            solution.take_unit(i as usize, self.impulse[c], mode);
        }
        for (k, &i) in island.bilateral.iter().enumerate() {
            solution.bilateral[i as usize] = self.bilateral[k];
        }
        island.scatter(&self.velocity, &mut solution.velocity);
    }
}

/// The solvers of the threads, and an outcome for every island.
#[derive(Debug, Default)]
pub(super) struct IslandPool {
    solvers: Vec<IslandSolver>,
    outcomes: Vec<Outcome>,
    /// How many outcomes the last run had.
    count: usize,
}

impl IslandPool {
    /// Units of the last run's islands whose rows are proved to contradict each other.
    pub fn contradictions(&self) -> impl Iterator<Item = u32> {
        self.outcomes[..self.count].iter().flat_map(|outcome| outcome.contradiction.iter().copied())
    }

    /// Runs the first two stages of the cascade on the islands that are `chosen`, writes what they gave to `solution` and
    /// the residuals to their places in `residuals`.
    pub fn run(
        &mut self,
        (problem, cones, islands): (&ContactProblem, &Cones, &[Island]),
        settings: &SolverSettings,
        start: Start,
        solution: &mut ContactSolution,
        residuals: &mut [f64],
        chosen: impl Fn(f64) -> bool,
    ) {
        let mut count = 0;
        for island in (0..islands.len()).filter(|&k| chosen(residuals[k])) {
            if self.outcomes.len() == count {
                self.outcomes.push(Outcome::default());
            }
            self.outcomes[count].begin(island);
            count += 1;
        }
        self.count = count;
        let outcomes = &mut self.outcomes[..count];
        let threads = threads_for(islands, outcomes, settings.threads);
        if self.solvers.len() < threads {
            self.solvers.resize_with(threads, IslandSolver::default);
        }
        let solve = |solver: &mut IslandSolver, outcome: &mut Outcome| {
            solve_island(solver, problem, cones, &islands[outcome.island], settings, start, outcome);
        };
        if threads == 1 {
            outcomes.iter_mut().for_each(|outcome| solve(&mut self.solvers[0], outcome));
        } else {
            // Large islands first: the last ones to finish are small.
            outcomes.sort_unstable_by_key(|outcome| (usize::MAX - rows(&islands[outcome.island]), outcome.island));
            let queue = Mutex::new(outcomes.iter_mut());
            let next = || queue.lock().unwrap_or_else(PoisonError::into_inner).next();
            self.solvers[..threads].par_iter_mut().with_max_len(1).for_each(|solver| {
                while let Some(outcome) = next() {
                    solve(solver, outcome);
                }
            });
        }
        for outcome in &self.outcomes[..count] {
            residuals[outcome.island] = outcome.residual;
            outcome.write(&islands[outcome.island], solution);
        }
    }
}

fn rows(island: &Island) -> usize {
    island.units.len() + island.bilateral.len()
}

/// How many threads the work at hand is worth: 1 unless there is enough of it beside the largest island.
fn threads_for(islands: &[Island], outcomes: &[Outcome], wanted: usize) -> usize {
    if wanted == 1 || outcomes.len() < 2 {
        return 1;
    }
    let sizes = || outcomes.iter().map(|outcome| rows(&islands[outcome.island]));
    let beside = sizes().sum::<usize>() - sizes().max().unwrap_or(0);
    if beside < PARALLEL_ROWS {
        return 1;
    }
    let wanted = if wanted == 0 { rayon::current_num_threads() } else { wanted };
    wanted.min(outcomes.len())
}
