//! Accelerated contact sweeps, in turn with exact solutions of the parts of an island that lag behind.
//!
//! A sweep gives contact after contact the impulse that its own law asks for with the others as they are (Jourdan, Alart, Jean 1998), exactly, which takes
//! tens of nanoseconds a contact. [Extrapolated](acceleration) sweeps soon leave few contacts with most of the residual; these are solved
//! with their neighbours as [islands of their own](parts), the impulses around them held, and the sweeps go on. Where bodies move this comes so near
//! to a solution that iterations find the rest with a few factorisations of the island, which cost less than the sweeps that it would take.

mod acceleration;
mod half_rows;
mod parts;
mod single;
mod system;
mod tuning;

use signorini_contact::projection::Mode;

use crate::islands::Island;
use crate::iterate::Iterate;
use crate::residual::RESIDUALS;
use crate::task::{SIZES, Task};
use acceleration::Acceleration;
use parts::Parts;
use system::{Lacking, Point, System};
use tuning::TUNING;

/// The sweeps' memory.
#[derive(Clone, Debug, Default)]
pub(crate) struct ContactSweeps {
    system: System,
    point: Point,
    acceleration: Acceleration,
    lacking: Lacking,
    parts: Parts,
    /// The smallest residual so far, at every look after the first sweeps.
    best: Vec<f64>,
    /// A part's impulses.
    own: Iterate,
    /// The point that lacked least, where the sweeps are counted, and how many were made.
    least: Point,
    made: u32,
}

/// How the sweeps ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ended {
    /// What the laws lack is small enough.
    Enough,
    /// It is so small from the start that other stages find the rest.
    Near,
    /// Iterations do better from here: few modes are wrong, or what is left falls too slowly.
    ForIterations,
    /// It is large, and falls too slowly.
    Far,
    /// The sweeps are used up.
    OutOfBudget,
}

/// Solves an island from an iterate as well as can be, to a residual; what it came down to.
pub(crate) trait SolvePart: FnMut(&Island, &mut Iterate, f64) -> f64 {}

impl<F: FnMut(&Island, &mut Iterate, f64) -> f64> SolvePart for F {}

impl ContactSweeps {
    /// Sweeps from an iterate until what the laws lack is small enough, or [iterations do better](Ended::ForIterations). The iterate gets impulses and
    /// modes unless they are [far](Ended::Far) from a solution.
    ///
    /// - `solve_part`: what solves parts; `history`: takes the residual at every look
    pub fn run(
        &mut self,
        task: &Task,
        iterate: &mut Iterate,
        mut solve_part: impl SolvePart,
        history: &mut dyn FnMut(f64),
    ) -> Ended {
        let enough = task.accept();
        self.begin(task, iterate, history);
        self.parts.begin();
        self.best.clear();
        if self.lacking.worst <= SIZES.rough && enough < SIZES.rough {
            return Ended::Near;
        }
        let mut is_first = true;
        while self.lacking.worst > enough {
            if !is_first {
                let has_few_wrong = self.lacking.worst <= RESIDUALS.far && !task.is_rough();
                if has_few_wrong || self.is_slow() {
                    return self.hand_on(iterate);
                }
                self.solve_parts(task, enough, &mut solve_part);
            }
            self.sweep(task, round(is_first), is_first);
            is_first = false;
            self.look(task, history);
        }
        if self.lacking.worst.is_nan() {
            return Ended::Far;
        }
        self.give(iterate);
        Ended::Enough
    }

    /// Makes so many sweeps from an iterate, fewer if what the laws lack is small enough before. The iterate gets the impulses and modes of the
    /// point that lacked least in the root mean square: what lacks most may be a single contact, which tells little of all others.
    pub fn run_within(
        &mut self,
        task: &Task,
        iterate: &mut Iterate,
        budget: u32,
        history: &mut dyn FnMut(f64),
    ) -> Ended {
        let enough = task.accept();
        self.begin(task, iterate, history);
        self.least.copy(&self.point);
        let mut least = (self.lacking.rms, self.lacking.worst);
        while self.lacking.worst > enough && self.made < budget {
            let is_first = self.made == 0;
            self.sweep(task, round(is_first).min(budget - self.made), is_first);
            self.look(task, history);
            if self.lacking.rms <= least.0 {
                least = (self.lacking.rms, self.lacking.worst);
                self.least.copy(&self.point);
            }
        }
        std::mem::swap(&mut self.point, &mut self.least);
        (self.lacking.rms, self.lacking.worst) = least;
        self.give(iterate);
        if least.1 <= enough { Ended::Enough } else { Ended::OutOfBudget }
    }

    /// Makes a few sweeps, unless the iterate is [near](Ended::Near) its modes. They find most of these; where its factorisations cost little
    /// more than sweeps, iterations find the others sooner. What a contact changes comes to all others in the fewer sweeps the fewer contacts there
    /// are.
    pub fn run_short(&mut self, task: &Task, iterate: &mut Iterate, history: &mut dyn FnMut(f64)) -> Ended {
        self.begin(task, iterate, history);
        if self.lacking.worst <= RESIDUALS.far {
            return Ended::Near;
        }
        let breadth = (task.island.units.len() as f64 / SIZES.large as f64).sqrt();
        self.sweep(task, (f64::from(TUNING.sweeps_a_round) * breadth) as u32, true);
        self.look(task, history);
        if self.lacking.worst.is_nan() {
            return Ended::Far;
        }
        self.give(iterate);
        if self.lacking.worst <= task.accept() { Ended::Enough } else { Ended::ForIterations }
    }

    /// What the point of the last run lacks.
    pub fn lacks(&self) -> f64 {
        self.lacking.worst
    }

    /// How many sweeps the last run made.
    pub fn made(&self) -> u32 {
        self.made
    }

    /// Takes an island and an iterate, and looks at what it lacks.
    fn begin(&mut self, task: &Task, iterate: &Iterate, history: &mut dyn FnMut(f64)) {
        self.made = 0;
        self.system.begin(task);
        self.system.start(task, iterate, &mut self.point);
        self.look(task, history);
    }

    /// Makes so many sweeps, the first ones all forward.
    fn sweep(&mut self, task: &Task, sweeps: u32, is_first: bool) {
        self.acceleration.sweep(&self.system, task, &mut self.point, sweeps, !is_first);
        self.made += sweeps;
    }

    fn hand_on(&self, iterate: &mut Iterate) -> Ended {
        if self.lacking.worst <= TUNING.worthless {
            self.give(iterate);
            Ended::ForIterations
        } else {
            Ended::Far
        }
    }

    fn look(&mut self, task: &Task, history: &mut dyn FnMut(f64)) {
        self.system.measure(task, &self.point, &mut self.lacking);
        history(self.lacking.worst);
    }

    /// Whether the smallest residual has not fallen as it should in the last rounds.
    fn is_slow(&mut self) -> bool {
        let worst = self.lacking.worst;
        self.best.push(self.best.last().map_or(worst, |best| best.min(worst)));
        let before = self.best.len().checked_sub(TUNING.slow_rounds + 1);
        before.is_some_and(|k| self.best[self.best.len() - 1] > RESIDUALS.less * self.best[k])
    }

    /// Solves the parts that lag behind, one after the other.
    fn solve_parts(&mut self, task: &Task, enough: f64, solve_part: &mut impl SolvePart) {
        let Self { system, point, parts, lacking, own, .. } = self;
        let least = (TUNING.lagging * lacking.worst).max(enough);
        for seed in 0..parts.seed(system, task.island, lacking, least) {
            let size = parts.take(system, task.island, seed);
            if size.is_none_or(|size| size > TUNING.largest_part) {
                continue;
            }
            parts.assemble(system, task.island, point);
            let (units, bilateral) = parts.unknown(task.island);
            own.clear(task.problem, &parts.island);
            for (k, &c) in units.iter().enumerate() {
                own.impulse[k] = point.impulse[c as usize];
                own.modes.push(point.modes[c as usize]);
            }
            for (k, &row) in bilateral.iter().enumerate() {
                own.bilateral[k] = point.bilateral[row as usize - task.island.units.len()];
            }
            let residual = solve_part(&parts.island, own, RESIDUALS.slow * enough);
            if residual <= RESIDUALS.slow * lacking.worst {
                system.take_part(task.island, point, (units, bilateral), own);
            }
        }
        system.settle(task, point);
    }

    fn give(&self, iterate: &mut Iterate) {
        iterate.impulse.clone_from(&self.point.impulse);
        iterate.bilateral.clone_from(&self.point.bilateral);
        iterate.modes.clone_from(&self.point.modes);
        iterate.velocity.clear();
        iterate.residual = f64::INFINITY;
    }
}

/// Sweeps of a round.
fn round(is_first: bool) -> u32 {
    if is_first { 2 * TUNING.sweeps_a_round } else { TUNING.sweeps_a_round }
}

impl System {
    /// Takes over the impulses and modes of a part.
    fn take_part(&self, island: &Island, point: &mut Point, (units, bilateral): (&[u32], &[u32]), part: &Iterate) {
        for (k, &c) in units.iter().enumerate() {
            let (c, next) = (c as usize, part.impulse[k]);
            let before = std::mem::replace(&mut point.impulse[c], next);
            point.modes[c] = part.modes.get(k).copied().unwrap_or(Mode::Stick);
            self.rows.add_transposed(c, std::array::from_fn(|r| next[r] - before[r]), &mut point.sum);
        }
        for (k, &row) in bilateral.iter().enumerate() {
            let (row, next) = (row as usize - island.units.len(), part.bilateral[k]);
            let before = std::mem::replace(&mut point.bilateral[row], next);
            self.bilateral_rows.add_transposed(row, [next - before], &mut point.sum);
        }
    }
}
