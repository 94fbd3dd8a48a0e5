//! The proximal iterations of an island: centre after centre, with ε where it helps.

mod breakpoint;
mod coupling;
mod gathering;
mod growth;
mod map;
mod modes;
mod motion;
mod path;
mod system;
mod weight;

use signorini_contact::projection::Mode;

use crate::iterate::{Iterate, relative_impulse};
use crate::residual::{RESIDUALS, is_exact};
use crate::task::{Task, accepted_closely};
use breakpoint::crossings;
use growth::Growth;
pub(crate) use map::ProximalMap;
use modes::ModeSearch;
pub use system::ProximalSystem;
pub(crate) use weight::ProximalWeight;

/// Why the iterations ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum End {
    /// The laws hold to the accuracy of the polish.
    Polished,
    /// They hold well enough for an island whose factorisations are costly.
    Accepted,
    /// The last change of the impulses proves that the rows contradict each other.
    Contradiction,
    /// The residual no longer falls, whatever ε is.
    Slow,
    /// The modes of a proximal problem were not found, nor with a larger ε.
    Lost,
    /// The number of iterations is used up.
    Limit,
}

/// Memory of the iterations.
#[derive(Clone, Debug, Default)]
pub(crate) struct ProximalIterations {
    search: ModeSearch,
    growth: Growth,
    /// After how many iterations contacts leave their modes.
    crossings: Vec<f64>,
    best: Iterate,
    /// The modes before a proximal problem.
    earlier_modes: Vec<Mode>,
    /// `M v`.
    momentum: Vec<f64>,
}

/// How the residual falls.
struct Progress {
    last: f64,
    /// What the last iteration left of the residual.
    ratio: f64,
    /// Below this residual another stride is worth it.
    stride_below: f64,
    /// So many contacts may leave their modes in a stride, which ends where the next one would.
    may_leave: usize,
    /// Slow iterations in a row.
    slow: u32,
}

impl ProximalIterations {
    /// Goes on from the impulses and modes of the iterate until its residual is at `settings.polish` or stops falling; leaves the best
    /// point in it. `history` takes the residual of every centre.
    pub fn run(
        &mut self,
        map: &mut ProximalMap,
        task: &Task,
        iterate: &mut Iterate,
        mut weight: ProximalWeight,
        history: &mut dyn FnMut(f64),
    ) -> End {
        if iterate.residual < f64::INFINITY {
            // A velocity that was measured may be refined, and a centre's is that of its impulses.
            iterate.velocity.clear();
            iterate.residual = f64::INFINITY;
        }
        self.growth.begin(task.island);
        self.best.copy_impulses(iterate);
        map.set_weights(task.island, weight.epsilon);
        let end = self.approach(map, task, iterate, &mut weight, history);
        self.conclude(map, task, iterate, end == End::Polished);
        end
    }

    /// The contacts of the problem whose rows were proved to contradict each other.
    pub fn contradicting<'a>(&'a self, task: &'a Task) -> impl Iterator<Item = u32> + 'a {
        self.growth.contradicting(task.island)
    }

    /// The loop.
    fn approach(
        &mut self,
        map: &mut ProximalMap,
        task: &Task,
        iterate: &mut Iterate,
        weight: &mut ProximalWeight,
        history: &mut dyn FnMut(f64),
    ) -> End {
        let may_leave = if weight.strides_far { task.island.units.len() / modes::few(task) } else { 0 };
        let mut progress =
            Progress { last: f64::INFINITY, ratio: 0.0, stride_below: f64::INFINITY, may_leave, slow: 0 };
        let mut solved = 0;
        for iteration in 0..task.settings.max_proximal_iterations * if task.is_large() { 2 } else { 1 } {
            let residual = map.evaluate_centre(task, iterate);
            history(residual);
            self.keep_best(iterate, residual);
            if task.is_short_of(iteration, self.best.residual) {
                return End::Limit;
            }
            progress.note(residual, weight);
            if let Some(end) = self.reason_to_end(map, task, iterate, &progress) {
                return end;
            }
            // The first one may be slow for a change of its modes.
            if progress.slow == 2 {
                progress.slow = 0;
                if self.stride(map, task, iterate, &mut progress) {
                    progress.last = f64::INFINITY;
                } else if !weight.change(self.best.residual, progress.last) {
                    return End::Slow;
                }
                map.set_weights(task.island, weight.epsilon);
                map.evaluate_centre(task, iterate);
            }
            map.prepare(task);
            self.earlier_modes.clone_from(&iterate.modes);
            if self.search.solve(map, task, iterate) {
                solved += 1;
                map.effort.proximal_iterations += 1;
                self.growth.take_solution(map, task, iterate);
                iterate.velocity.clear();
                weight.fall(iterate.modes == self.earlier_modes);
            } else {
                iterate.modes.clone_from(&self.earlier_modes);
                map.change_modes();
                let may_rise = task.is_large() && (solved > 0 || weight.is_falling());
                if !may_rise || !weight.rise(self.best.residual) {
                    return End::Lost;
                }
            }
            if weight.epsilon != map.epsilon {
                map.set_weights(task.island, weight.epsilon);
                progress.last = f64::INFINITY;
            }
        }
        End::Limit
    }

    /// Where iterations are slow, because each adds nearly the same impulses, which nearly balance each other: what all that follow would add, in
    /// one stride, as the sum of a geometric series (Aitken 1926), and no farther than until more contacts than may would leave their modes. Whether
    /// that was worth it: after a stride that ended at no facet another one is, if that one has paid.
    fn stride(&mut self, map: &ProximalMap, task: &Task, iterate: &mut Iterate, progress: &mut Progress) -> bool {
        let best = self.best.residual;
        let Some(change) = self.growth.change(task.island) else { return false };
        if best <= task.accept() || best > progress.stride_below {
            return false;
        }
        let most = if progress.ratio < 1.0 { progress.ratio / (1.0 - progress.ratio) } else { f64::INFINITY };
        let (cones, units) = (task.cones, &task.island.units);
        crossings(cones, units, &iterate.modes, &map.trial, change, &mut self.crossings);
        // Bilateral rows alone have no modes to leave.
        self.crossings.push(f64::INFINITY);
        let (_, leaving, _) = self.crossings.select_nth_unstable_by(progress.may_leave, f64::total_cmp);
        let times = leaving.min(most);
        // Impulses that grow for ever contradict each other, and very large ones have no digits left for the velocity.
        let largest = relative_impulse(change, task.island);
        if !(times > 1.0 && times * largest <= RESIDUALS.noise / f64::EPSILON) {
            return false;
        }
        progress.stride_below = if times < most { f64::INFINITY } else { RESIDUALS.less * best };
        self.growth.go_on(task.island, iterate, times);
        true
    }

    fn keep_best(&mut self, iterate: &mut Iterate, residual: f64) {
        if residual < self.best.residual {
            self.best.copy_impulses(iterate);
            self.best.residual = residual;
        }
    }

    fn reason_to_end(
        &mut self,
        map: &mut ProximalMap,
        task: &Task,
        iterate: &Iterate,
        progress: &Progress,
    ) -> Option<End> {
        let (best, settings) = (self.best.residual, task.settings);
        if best <= settings.polish {
            return Some(End::Polished);
        }
        // Rest is approached to the last digit, but no closer than a tolerance that does not tell it from motion.
        if task.is_costly() && task.is_rough() && best <= task.accept() {
            return Some(End::Accepted);
        }
        // What moves needs no more digits than were asked for; what comes to rest shall not creep.
        let is_enough = task.is_large() && task.is_warm && progress.last <= task.accept();
        if is_enough && self.moves(map, task, iterate) {
            return Some(End::Accepted);
        }
        if progress.slow == 0 {
            return None;
        }
        // What is accepted and does not get better is paid for with factorisations.
        if task.spares_factorizations() && best <= accepted_closely(task.island.units.len(), settings) {
            return Some(End::Accepted);
        }
        let most = settings.tolerance * map.velocity_scale;
        (best > RESIDUALS.noise && self.growth.is_contradiction(task.island, most)).then_some(End::Contradiction)
    }

    /// Whether the island keeps more than a part of the energy that its free motion has.
    fn moves(&mut self, map: &ProximalMap, task: &Task, iterate: &Iterate) -> bool {
        let mut energy = |v: &[f64]| {
            self.momentum.clear();
            self.momentum.resize(v.len(), 0.0);
            task.island.multiply_mass(&task.problem.mass, v, &mut self.momentum);
            self.momentum.iter().zip(v).map(|(p, v)| p * v).sum::<f64>()
        };
        energy(&iterate.velocity) > RESIDUALS.less * energy(&map.free_velocity)
    }

    /// Goes back to the best point, and refines its velocity where that is worth it.
    fn conclude(&mut self, map: &mut ProximalMap, task: &Task, iterate: &mut Iterate, is_polished: bool) {
        // A polished centre is the best one, and evaluated.
        if !is_polished {
            if iterate.modes != self.best.modes {
                map.change_modes();
            }
            iterate.copy_impulses(&self.best);
            iterate.velocity.clear();
            map.evaluate_centre(task, iterate);
        }
        iterate.residual = self.best.residual;
        if is_exact(iterate.residual, iterate.largest_impulse(task.island)) {
            return;
        }
        map.prepare(task);
        if refine_velocity(map, task, iterate) && is_polished {
            // The next step starts from impulses that need no refinement.
            self.growth.take_solution(map, task, iterate);
        }
    }
}

impl Progress {
    fn note(&mut self, residual: f64, weight: &ProximalWeight) {
        self.slow = if residual > RESIDUALS.slow * self.last && !weight.is_falling() { self.slow + 1 } else { 0 };
        (self.last, self.ratio) = (residual, residual / self.last);
    }
}

/// The velocity of the solution, one more fixed-mode correction beyond what the impulses can express: where impulses
/// are large against the masses they move, `v^f + M⁻¹Jᵀλ` cancels, while `v + δv` satisfies the contact rows to rounding.
/// Whether the modes hold with it.
fn refine_velocity(map: &mut ProximalMap, task: &Task, iterate: &mut Iterate) -> bool {
    let solved = !iterate.modes.is_empty() && map.solve_modes(task, iterate);
    let holds = solved && map.violations(task, iterate) == 0;
    if holds {
        iterate.velocity.iter_mut().zip(&map.step).for_each(|(v, d)| *v += d);
    }
    holds
}
