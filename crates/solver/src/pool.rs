//! Taking the islands of a problem through the cascade, on one thread or on several.
//!
//! An island's result depends on nothing but the island: it is solved into an [`IslandResult`] of its own, and the results are
//! written to the solution by one thread. The bits are those of one thread, however many there are.

use std::sync::{Mutex, PoisonError};

use rayon::iter::{IndexedParallelIterator, IntoParallelRefMutIterator, ParallelIterator};
use signorini_contact::projection::{Cones, Mode};
use signorini_contact::{ContactProblem, ContactSolution, SolveStatus, StageKind, StageRun};

use crate::islands::Island;
use crate::settings::SolverSettings;
use crate::stages::hold::GivenStart;
use crate::stages::{IslandResult, Workspace, solve_island};
use crate::task::{Look, SIZES, Task};

/// The workspaces of the threads, and a result for every island.
#[derive(Debug, Default)]
pub(crate) struct IslandPool {
    workspaces: Vec<Workspace>,
    results: Vec<(usize, IslandResult)>,
    /// How many results the last run had.
    count: usize,
}

/// Islands of a problem, and how they are to be solved.
#[derive(Clone, Copy)]
pub(crate) struct Request<'a> {
    pub problem: &'a ContactProblem,
    pub cones: &'a Cones,
    pub islands: &'a [Island],
    pub settings: &'a SolverSettings,
    pub look: Look,
    /// The start; without impulses if there is none.
    pub given: Option<&'a GivenStart>,
}

impl IslandPool {
    /// Contacts of the last run's islands whose rows are proved to contradict each other.
    pub fn contradictions(&self) -> impl Iterator<Item = usize> {
        self.results[..self.count].iter().flat_map(|(_, result)| result.contradiction.iter().map(|&i| i as usize))
    }

    /// What the last run's islands failed with: the first denial, or else the first failure.
    pub fn failure(&self) -> Option<SolveStatus> {
        let failures = || self.results[..self.count].iter().filter_map(|(_, result)| result.failure.as_ref());
        failures().find(|status| is_denial(status)).or_else(|| failures().next()).cloned()
    }

    /// Takes the islands that are `chosen` by index and residual through the cascade, writes what they gave to `solution` and the
    /// residuals to their places in `residuals`.
    pub fn run(
        &mut self,
        request: Request,
        chosen: impl Fn(usize, f64) -> bool,
        residuals: &mut [f64],
        solution: &mut ContactSolution,
    ) {
        let Request { islands, settings, .. } = request;
        self.count = 0;
        for island in (0..islands.len()).filter(|&k| chosen(k, residuals[k])) {
            if self.results.len() == self.count {
                self.results.push(Default::default());
            }
            self.results[self.count].0 = island;
            self.count += 1;
        }
        let results = &mut self.results[..self.count];
        let threads = threads_for(islands, results, settings.threads);
        if self.workspaces.len() < threads {
            self.workspaces.resize_with(threads, Workspace::default);
        }
        if threads == 1 {
            results.iter_mut().for_each(|(island, result)| request.solve(*island, &mut self.workspaces[0], result));
        } else {
            // Large islands first: the last ones to finish are small.
            results.sort_unstable_by_key(|(island, _)| (usize::MAX - rows(&islands[*island]), *island));
            let queue = Mutex::new(results.iter_mut());
            let next = || queue.lock().unwrap_or_else(PoisonError::into_inner).next();
            self.workspaces[..threads].par_iter_mut().with_max_len(1).for_each(|workspace| {
                while let Some((island, result)) = next() {
                    request.solve(*island, workspace, result);
                }
            });
            results.sort_unstable_by_key(|(island, _)| *island);
        }
        for (island, result) in results {
            residuals[*island] = result.iterate.residual;
            write(result, *island, &islands[*island], solution);
        }
    }
}

impl Request<'_> {
    fn solve(&self, island: usize, workspace: &mut Workspace, result: &mut IslandResult) {
        let Self { problem, cones, islands, settings, look, given } = *self;
        let is_warm = given.is_some() && look != Look::Second;
        let is_nearly_solved = is_warm && given.is_some_and(|given| given.nearly_solves);
        let task = Task { problem, cones, island: &islands[island], settings, look, is_warm, is_nearly_solved };
        result.begin();
        match given {
            Some(given) => given.give(problem, task.island, &mut result.iterate),
            None => result.iterate.clear(problem, task.island),
        }
        solve_island(workspace, &task, result);
    }
}

/// Whether a status says that there is no solution.
pub(crate) fn is_denial(status: &SolveStatus) -> bool {
    matches!(status, SolveStatus::Ray { .. } | SolveStatus::Infeasible { .. })
}

/// Writes impulses, modes and velocity to their places. An island that no stage brought to a number leaves them alone.
fn write(result: &mut IslandResult, index: usize, island: &Island, solution: &mut ContactSolution) {
    let report = &mut solution.report;
    report.factorizations += result.effort.factorizations;
    report.mode_changes += result.effort.mode_changes;
    report.proximal_iterations += result.effort.proximal_iterations;
    report.lemke_pivots += result.effort.pivots;
    report.lemke_islands += result.stages[StageKind::Lemke].asked as u32;
    report.sweeps = report.sweeps.max(result.effort.sweeps);
    report.unfinished_islands += u32::from(result.is_unfinished);
    report.stages.add(&result.stages);
    solution.history.extend(result.history.drain(..).map(|run| StageRun { island: index as u32, ..run }));
    let iterate = &result.iterate;
    if iterate.residual == f64::INFINITY {
        return;
    }
    for (c, &i) in island.units.iter().enumerate() {
        let mode = iterate.modes.get(c).copied().unwrap_or(Mode::Open);
        solution.take_unit(i as usize, iterate.impulse[c], mode);
    }
    for (k, &i) in island.bilateral.iter().enumerate() {
        solution.bilateral[i as usize] = iterate.bilateral[k];
    }
    island.scatter(&iterate.velocity, &mut solution.velocity);
}

fn rows(island: &Island) -> usize {
    island.units.len() + island.bilateral.len()
}

/// How many threads the work at hand is worth: 1 unless there is enough of it beside the largest island.
fn threads_for(islands: &[Island], results: &[(usize, IslandResult)], wanted: usize) -> usize {
    if wanted == 1 || results.len() < 2 {
        return 1;
    }
    let sizes = || results.iter().map(|(island, _)| rows(&islands[*island]));
    let beside = sizes().sum::<usize>() - sizes().max().unwrap_or(0);
    // What makes up less than a large island is not worth the threads' wake-up.
    if beside < SIZES.large {
        return 1;
    }
    let wanted = if wanted == 0 { rayon::current_num_threads() } else { wanted };
    wanted.min(results.len())
}
