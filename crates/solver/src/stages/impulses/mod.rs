//! Newton's method in the space of impulses: the first attempt on robots, which have few rows beside their degrees of freedom.
//!
//! With the modes fixed the impulses are `λ = A z`, and the laws ask for `R u = 0`: three unknowns where a contact sticks, two on an edge
//! of its polygon, one at a vertex or without friction, none where it is open; one where a joint with dry friction sticks, none where it
//! slides, since its bound is given; one for each bilateral row. Friction that a contact's normal impulse bounds, as against spinning, has
//! those of a joint, and where it slides its impulse is a part of what that normal impulse's unknown carries. With `W = J M⁻¹ Jᵀ`, from half solves with the factor of `M`, that is one
//! small system, and no proximal iterations are needed. The next modes are those of `λ − u/g`. What comes out is accepted where the laws
//! hold to the accuracy of the polish, or to that which is asked for where rows almost depend on each other, so that steps gain little;
//! otherwise it was an attempt, of which nothing is kept.

mod delassus;
mod parts;
mod system;

use signorini_contact::StageOutcome;
use signorini_contact::projection::{Cones, Mode};
use signorini_contact::scales::{FREE_ROWS, raise};
use signorini_multibody::{BlockCholesky, FEW_ROWS};

use super::shared::{Outcome, Shared};
use crate::islands::Island;
use crate::iterate::{Effort, Iterate};
use crate::proximal::ProximalMap;
use crate::residual::{RESIDUALS, is_exact, law_residual};
use crate::task::Task;
use delassus::Delassus;
use parts::{bounding, components, held, scale};
use system::ModeSystem;

/// The memory of the method and its iterate. Its *parts* are the units of the island, then its bilateral rows.
#[derive(Clone, Debug, Default)]
pub(super) struct ImpulseNewton {
    /// `W` between the parts that are known: those that were held or changed at some time.
    delassus: Delassus,
    /// The equations of the present modes.
    system: ModeSystem,
    /// What a step adds to the impulses of the known rows and to the velocity.
    change: Vec<f64>,
    work: Vec<f64>,
    impulse: Vec<[f64; 3]>,
    modes: Vec<Mode>,
    bilateral: Vec<f64>,
    velocity: Vec<f64>,
    /// `u` of each part.
    slack: Vec<[f64; 3]>,
    /// The best point whose laws hold but for what may be rounding, though some modes would change.
    best: Iterate,
}

/// A warm start whose velocity is that of its impulses, and at most half as many rows more than degrees of freedom, and as many as a body has: with more of
/// them a step costs more than all of the proximal iterations, and most attempts fail (of 18 humanoids, hands and arms steps took 0.95 of the time with one and
/// a half times the degrees of freedom in place of once, 0.96 with twice, 28 November 2026). Contacts of free bodies alone have to have fewer rows than degrees of freedom, stuck
/// or not: proximal iterations are few there, and more exact where contacts are redundant, as under a body that slides.
pub(super) fn applies(task: &Task, iterate: &Iterate) -> bool {
    let (island, cones) = (task.island, task.cones);
    let groups = island.contact_count..island.units.len();
    let is_free = island.starts.windows(2).all(|block| block[1] - block[0] <= FREE_ROWS);
    let are_alone = is_free && island.bilateral.is_empty() && groups.is_empty();
    let rows = |(c, &mode): (usize, &Mode)| {
        let may_stick = are_alone && cones.friction(island.units[c] as usize) > 0.0;
        if may_stick { 3 } else { held(cones, island, c, mode).0 }
    };
    let most = if are_alone { island.nv() } else { 3 * island.nv() / 2 + FREE_ROWS };
    !iterate.velocity.is_empty()
        && island.nv() <= FEW_ROWS
        && iterate.modes.iter().enumerate().map(rows).sum::<usize>() + island.bilateral.len() <= most
}

/// Solves the island, or leaves the iterate as it is.
pub(super) fn run(newton: &mut ImpulseNewton, shared: &mut Shared, task: &Task, iterate: &mut Iterate) -> Outcome {
    newton.best.residual = f64::INFINITY;
    let residual = newton.iterate(task, iterate, &mut shared.map);
    if let Some(residual) = residual.filter(|residual| *residual <= task.accept()) {
        newton.write(residual, iterate);
    } else if newton.best.residual <= task.accept() {
        std::mem::swap(iterate, &mut newton.best);
    } else {
        return StageOutcome::Lost.into();
    }
    StageOutcome::Solved.into()
}

/// The residual that is asked for: that of the polish, or the last digits of velocities along rows where they are more.
fn enough(task: &Task) -> f64 {
    let scale = task.island.velocity_scale;
    let digits = if scale.value() > 0.0 { f64::EPSILON * scale.terms / scale.value() } else { 0.0 };
    task.settings.polish.max(digits.min(task.accept()))
}

impl ImpulseNewton {
    /// Writes the point at hand.
    fn write(&self, residual: f64, iterate: &mut Iterate) {
        iterate.impulse.clone_from(&self.impulse);
        iterate.bilateral.clone_from(&self.bilateral);
        iterate.modes.clone_from(&self.modes);
        iterate.velocity.clone_from(&self.velocity);
        iterate.residual = residual;
    }

    /// Newton steps from the iterate; the residual, if they ended with laws that hold to rounding, or came no further.
    fn iterate(&mut self, task: &Task, start: &Iterate, map: &mut ProximalMap) -> Option<f64> {
        let (cones, island, factor) = (task.cones, task.island, &task.problem.mass_factor);
        let effort = &mut map.effort;
        self.impulse.clone_from(&start.impulse);
        self.bilateral.clone_from(&start.bilateral);
        self.modes.clone_from(&start.modes);
        self.velocity.clone_from(&start.velocity);
        self.find_slack(island);
        self.delassus.forget(island);
        let (mut last, mut factored, mut is_rough) = (f64::INFINITY, false, false);
        let mut is_summed = false;
        let most = effort.factorizations + task.settings.newton_iterations / 2;
        for _ in 0..task.settings.newton_iterations {
            // Of the attempts that come this far most fail (of 17 robots, 1 s each, 86 succeeded and 509 did not, 28 November 2026).
            if !factored && (effort.factorizations > most || !self.factorize(task, effort)) {
                return None;
            }
            is_rough |= self.take_step(task);
            self.add_velocity(factor, island);
            self.find_slack(island);
            let (residual, largest) = self.measure(cones, island, island.velocity_scale.value());
            let is_exact = is_exact(residual, largest);
            if residual >= self.best.residual {
                return None; // Modes that held but for last digits were left for others.
            }
            if !is_exact && !is_rough && residual <= RESIDUALS.noise {
                let mut best = std::mem::take(&mut self.best);
                self.write(residual, &mut best);
                self.best = best;
            }
            let changes = if is_exact { 0 } else { self.take_next_modes(cones, island) };
            effort.mode_changes += changes;
            (factored, last) = if is_exact || changes == 0 && residual > RESIDUALS.slow * last {
                if self.is_end(task, &map.free_velocity, is_rough, is_summed) {
                    return Some(residual);
                }
                if is_summed {
                    return None;
                }
                (is_rough, is_summed) = (false, true);
                (true, f64::INFINITY)
            } else if residual * RESIDUALS.far > last.max(1.0) {
                // So much farther from the laws than before, and than no impulses at all: modes that contradict each other go back and forth.
                return None;
            } else {
                (changes == 0, residual)
            };
        }
        None
    }

    /// Factorises the equations of the modes at hand; whether they are regular.
    fn factorize(&mut self, task: &Task, effort: &mut Effort) -> bool {
        effort.factorizations += 1;
        self.find_delassus(&task.problem.mass_factor, task.cones, task.island);
        self.system.fix_modes(&self.delassus, &self.modes, task.cones, task.island);
        self.system.factorize(&self.delassus, task.island)
    }

    /// Whether steps that came no further have come to the end, where they or the problem leave rounding, and where they went on from the sum.
    fn is_end(&mut self, task: &Task, free_velocity: &[f64], is_rough: bool, is_summed: bool) -> bool {
        let enough = enough(task);
        let rounds = is_rough || enough > task.settings.polish;
        // What is left after steps from the sum are its own last digits.
        let asked = if is_summed { task.accept() } else { enough };
        !rounds || self.holds_as_summed(task, free_velocity, asked)
    }

    /// Whether the laws hold with `v^f + M⁻¹Jᵀλ`, too, from which the velocity that the steps led to differs by the last digits of all that was
    /// added to it. Otherwise the iterate goes on with that velocity.
    fn holds_as_summed(&mut self, task: &Task, free_velocity: &[f64], asked: f64) -> bool {
        let (island, scale) = (task.island, task.island.velocity_scale.value());
        self.sum_velocity(task, free_velocity);
        std::mem::swap(&mut self.velocity, &mut self.work);
        self.find_slack(island);
        let holds = self.measure(task.cones, island, scale).0 <= asked;
        if holds {
            std::mem::swap(&mut self.velocity, &mut self.work);
        }
        holds
    }

    /// Writes `v^f + M⁻¹Jᵀλ` to the work vector.
    fn sum_velocity(&mut self, task: &Task, free_velocity: &[f64]) {
        let (island, v) = (task.island, &mut self.work);
        v.clear();
        v.resize(island.nv(), 0.0);
        self.impulse.iter().enumerate().for_each(|(c, p)| island.add_impulse(c, *p, v));
        let rows = self.bilateral.iter().enumerate();
        rows.for_each(|(k, p)| island.bilateral_jacobian.add_transposed(k, [*p], v));
        island.solve_mass(&task.problem.mass_factor, v);
        v.iter_mut().zip(free_velocity).for_each(|(v, f)| *v += f);
    }

    /// Takes the modes of `λ − u/g`; how many changed. A contact that is open, and would close by less than what is exact, stays open: among
    /// contacts that follow from others last digits would decide.
    fn take_next_modes(&mut self, cones: &Cones, island: &Island) -> u32 {
        let (mut changes, exact) = (0, RESIDUALS.exact * island.velocity_scale.value());
        for (c, &i) in island.units.iter().enumerate() {
            if c < island.contact_count && self.modes[c] == Mode::Open && self.slack[c][0] >= -exact {
                continue;
            }
            let trial = |c: usize, r: usize| self.impulse[c][r] - self.slack[c][r] / island.scale[c];
            let bound = trial(bounding(island, c).unwrap_or(c), 0);
            let mode = cones.mode_at(i as usize, [bound, trial(c, 1), trial(c, 2)]);
            changes += u32::from(mode != self.modes[c]);
            self.modes[c] = mode;
        }
        changes
    }

    fn find_slack(&mut self, island: &Island) {
        self.slack.clear();
        self.slack.extend((0..island.units.len()).map(|c| island.slack(c, &self.velocity)));
        for (k, offset) in island.bilateral_offset.iter().enumerate() {
            let [c] = island.bilateral_jacobian.multiply(k, &self.velocity);
            self.slack.push([c + offset, 0.0, 0.0]);
        }
    }

    /// The residual of the laws, and the largest impulse, as the proximal iterations measure them.
    fn measure(&self, cones: &Cones, island: &Island, velocity_scale: f64) -> (f64, f64) {
        let (mut residual, mut largest, mut scale) = (0.0, 0.0, 0.0);
        for (c, &i) in island.units.iter().enumerate() {
            let (p, u) = (self.impulse[c], island.pushing(c, self.slack[c]));
            raise(&mut residual, law_residual(cones, i as usize, p, u, island.residual_scale));
            island.pushing(c, p).iter().for_each(|p| raise(&mut largest, p.abs()));
            raise(&mut scale, island.scale[c]);
        }
        self.slack[island.units.len()..].iter().for_each(|u| raise(&mut residual, u[0].abs()));
        if velocity_scale > 0.0 { (residual / velocity_scale, largest * scale / velocity_scale) } else { (0.0, 0.0) }
    }

    /// `W` of the parts that have unknowns, or whose impulses are not where their modes have them; the slack of others follows from the
    /// velocity.
    fn find_delassus(&mut self, factor: &BlockCholesky, cones: &Cones, island: &Island) {
        for c in 0..self.slack.len() {
            let is_steady = island.units.get(c).is_some_and(|&i| {
                let (mode, p) = (self.modes[c], self.impulse[c]);
                let is_carried = mode != Mode::Open && bounding(island, c).is_some();
                let projected = island.pushing(c, cones.project(i as usize, mode, p));
                held(cones, island, c, mode).0 == 0 && !is_carried && projected == island.pushing(c, p)
            });
            if !is_steady {
                self.delassus.learn(c, components(cones, island, c));
            }
        }
        self.delassus.find(factor, island);
    }

    /// Solves with the modes fixed, `R (u + W (r + A z)) = 0`, where `r` brings the impulses to where their modes have them, and takes the
    /// impulses there. Whether the last digits of the change are more of a velocity than is asked for: between rows that contradict each other in
    /// modes that are not the solution's impulses are enormous, and leave rounding when they are taken back.
    fn take_step(&mut self, task: &Task) -> bool {
        let (cones, island) = (task.cones, task.island);
        self.change.clear();
        self.change.resize(self.delassus.len(), 0.0);
        for part in self.delassus.parts().iter().filter(|part| part.part < island.units.len()) {
            let (c, mut p) = (part.part, self.impulse[part.part]);
            if bounding(island, c).is_some_and(|by| self.modes[by] == Mode::Open) {
                p[0] = 0.0;
            }
            let projected = cones.project(island.units[c] as usize, self.modes[c], p);
            let rows = self.change[part.rows()].iter_mut().zip(part.first..);
            rows.for_each(|(change, r)| *change = projected[r] - p[r]);
        }
        // A second solution with the same factorisation leaves about `shared` of what the first one left.
        for _ in 0..2 {
            self.system.add_solution(&self.delassus, &self.slack, &mut self.change);
        }
        self.take_change(cones, island);
        let mut largest = 0.0;
        for part in self.delassus.parts() {
            let scale = scale(island, part.part);
            self.change[part.rows()].iter().for_each(|p| raise(&mut largest, p.abs() * scale));
        }
        f64::EPSILON * largest > task.settings.polish * island.velocity_scale.value()
    }

    /// Adds the change to the impulses; those of units come to where their modes have them, contacts before what they bound.
    fn take_change(&mut self, cones: &Cones, island: &Island) {
        let Self { delassus, change, impulse, bilateral, modes, .. } = self;
        let (contacts, units) = (island.contact_count, island.units.len());
        for is_group in [false, true] {
            for part in delassus.parts().iter().filter(|part| (contacts..units).contains(&part.part) == is_group) {
                let (c, change) = (part.part, &mut change[part.rows()]);
                let Some(&i) = island.units.get(c) else {
                    bilateral[c - units] += change[0];
                    continue;
                };
                let (before, mut p) = (impulse[c], impulse[c]);
                p[part.first..].iter_mut().zip(&*change).for_each(|(p, change)| *p += change);
                let projected = cones.project(i as usize, modes[c], p);
                impulse[c] = if is_group { [p[0], projected[1], projected[2]] } else { projected };
                let rows = change.iter_mut().zip(part.first..);
                rows.for_each(|(change, r)| *change = projected[r] - before[r]);
            }
            island.bind(impulse);
        }
    }

    /// Adds `M⁻¹ Jᵀ` times the change of the impulses to the velocity.
    fn add_velocity(&mut self, factor: &BlockCholesky, island: &Island) {
        self.work.clear();
        self.work.resize(island.nv(), 0.0);
        self.delassus.add_half(&self.change, &mut self.work);
        for (k, &block) in island.blocks.iter().enumerate() {
            let own = island.starts[k]..island.starts[k + 1];
            factor.other_half_solve_block_in_place(block as usize, &mut self.work[own]);
        }
        self.velocity.iter_mut().zip(&self.work).for_each(|(v, d)| *v += d);
    }
}
