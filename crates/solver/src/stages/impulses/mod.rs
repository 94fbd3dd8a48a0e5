//! Newton's method in the space of impulses: the first attempt on robots, which have few rows beside their degrees of freedom.
//!
//! With the modes fixed the impulses are `λ = A z`, and the laws ask for `R u = 0`: three unknowns where a contact sticks, two on an edge
//! of its polygon, one at a vertex or without friction, none where it is open; one where a joint with dry friction sticks, none where it
//! slides, since its bound is given; one for each bilateral row. With `W = J M⁻¹ Jᵀ`, from half solves with the factor of `M`, that is one
//! small system, and no proximal iterations are needed. The next modes are those of `λ − u/g`. What comes out is accepted where the laws
//! hold to the accuracy of the polish; otherwise it was an attempt, of which nothing is kept.

mod delassus;

use std::ops::Range;

use signorini_contact::StageOutcome;
use signorini_contact::projection::{Cones, Held, Mode};
use signorini_contact::scales::raise;
use signorini_contact::vector::dot;
use signorini_lcp::linalg::Lu;
use signorini_multibody::{BlockCholesky, FEW_ROWS};

use super::shared::{Outcome, Shared};
use crate::islands::Island;
use crate::iterate::Iterate;
use crate::proximal::ProximalMap;
use crate::residual::{RESIDUALS, is_exact, law_residual};
use crate::task::Task;
use delassus::{Delassus, Part};

/// What is tuned in this stage.
struct Tuning {
    /// What is added to the diagonal, in parts of a contact's Delassus scale, so that redundant contacts share: rounding of a velocity
    /// becomes an impulse among these that is larger by the inverse.
    shared: f64,
}

/// Chosen by: no command on record, since 22 November 2026.
const TUNING: Tuning = Tuning { shared: 1e-9 };

/// The memory of the method and its iterate. Its *parts* are the units of the island, then its bilateral rows.
#[derive(Clone, Debug, Default)]
pub(super) struct ImpulseNewton {
    /// `W` between the parts that are known: those that were held or changed at some time.
    delassus: Delassus,
    /// The parts with unknowns.
    active: Vec<Active>,
    system: Lu,
    unknowns: Vec<f64>,
    /// A row of `R W`.
    pulled: Vec<f64>,
    /// What a step adds to the impulses of the known rows and to the velocity.
    change: Vec<f64>,
    work: Vec<f64>,
    impulse: Vec<[f64; 3]>,
    modes: Vec<Mode>,
    bilateral: Vec<f64>,
    velocity: Vec<f64>,
    /// `u` of each part.
    slack: Vec<[f64; 3]>,
}

/// A warm start whose velocity is that of its impulses, friction whose bounds are given apart from that of contacts, and a system that is not
/// much larger than the mass matrix. Where there are contacts alone they have to have fewer rows than that, stuck or not: proximal iterations
/// are few there, and more exact where contacts are redundant, as under a body that slides.
pub(super) fn applies(task: &Task, iterate: &Iterate) -> bool {
    let (island, cones) = (task.island, task.cones);
    let groups = island.contact_count..island.units.len();
    let are_alone = island.bilateral.is_empty() && groups.is_empty();
    let rows = |(c, &mode): (usize, &Mode)| {
        let may_stick = are_alone && cones.friction(island.units[c] as usize) > 0.0;
        if may_stick { 3 } else { held(cones, island, c, mode).0 }
    };
    let most = if are_alone { island.nv() } else { 2 * island.nv() };
    !iterate.velocity.is_empty()
        && island.nv() <= FEW_ROWS
        && groups.zip(&island.bounded_by).all(|(c, &by)| by as usize == c)
        && iterate.modes.iter().enumerate().map(rows).sum::<usize>() + island.bilateral.len() <= most
}

/// Solves the island, or leaves the iterate as it is.
pub(super) fn run(newton: &mut ImpulseNewton, shared: &mut Shared, task: &Task, iterate: &mut Iterate) -> Outcome {
    let residual = newton.iterate(task, iterate, &mut shared.map);
    let Some(residual) = residual.filter(|residual| *residual <= task.settings.polish) else {
        return StageOutcome::Lost.into();
    };
    iterate.impulse.clone_from(&newton.impulse);
    iterate.bilateral.clone_from(&newton.bilateral);
    iterate.modes.clone_from(&newton.modes);
    iterate.velocity.clone_from(&newton.velocity);
    iterate.residual = residual;
    StageOutcome::Solved.into()
}

/// Whether the last digits of velocities along rows are more than is asked for.
fn rounding_matters(task: &Task) -> bool {
    let scale = task.island.velocity_scale;
    f64::EPSILON * scale.terms > task.settings.polish * scale.value()
}

impl ImpulseNewton {
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
        for _ in 0..task.settings.newton_iterations {
            if !factored {
                effort.factorizations += 1;
                self.find_delassus(factor, cones, island);
                self.fix_modes(cones, island);
                factored = self.system.factorize() > 0.0;
            }
            if !factored {
                return None;
            }
            is_rough |= self.take_step(task);
            self.add_velocity(factor, island);
            self.find_slack(island);
            let (residual, largest) = self.measure(cones, island, island.velocity_scale.value());
            let is_exact = is_exact(residual, largest);
            let changes = if is_exact { 0 } else { self.take_next_modes(cones, island) };
            effort.mode_changes += changes;
            (factored, last) = if is_exact || changes == 0 && residual > RESIDUALS.slow * last {
                if !is_rough && !rounding_matters(task) || self.holds_as_summed(task, &map.free_velocity) {
                    return Some(residual);
                }
                is_rough = false;
                (true, f64::INFINITY)
            } else {
                (changes == 0, residual)
            };
        }
        None
    }

    /// Whether the laws hold with `v^f + M⁻¹Jᵀλ`, too, from which the velocity that the steps led to differs by the last digits of all that was
    /// added to it. Otherwise the iterate goes on with that velocity.
    fn holds_as_summed(&mut self, task: &Task, free_velocity: &[f64]) -> bool {
        let (island, scale) = (task.island, task.island.velocity_scale.value());
        self.sum_velocity(task, free_velocity);
        std::mem::swap(&mut self.velocity, &mut self.work);
        self.find_slack(island);
        let holds = self.measure(task.cones, island, scale).0 <= task.settings.polish;
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

    /// Takes the modes of `λ − u/g`; how many changed.
    fn take_next_modes(&mut self, cones: &Cones, island: &Island) -> u32 {
        let mut changes = 0;
        for (c, &i) in island.units.iter().enumerate() {
            let (p, u, g) = (self.impulse[c], self.slack[c], island.scale[c]);
            let mode = cones.mode_at(i as usize, std::array::from_fn(|r| p[r] - u[r] / g));
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
            let (p, u) = (self.impulse[c], self.slack[c]);
            raise(&mut residual, law_residual(cones, i as usize, p, u, island.residual_scale));
            p.iter().for_each(|p| raise(&mut largest, p.abs()));
            raise(&mut scale, island.scale[c]);
        }
        self.slack[island.units.len()..].iter().for_each(|u| raise(&mut residual, u[0].abs()));
        if velocity_scale > 0.0 { (residual / velocity_scale, largest * scale / velocity_scale) } else { (0.0, 0.0) }
    }

    /// The mode of a part; that of a bilateral row is closed.
    fn mode(&self, c: usize) -> Mode {
        self.modes.get(c).copied().unwrap_or(Mode::Closed)
    }

    /// `W` of the parts that have unknowns, or whose impulses are not where their modes have them; the slack of others follows from the
    /// velocity.
    fn find_delassus(&mut self, factor: &BlockCholesky, cones: &Cones, island: &Island) {
        for c in 0..self.slack.len() {
            let is_steady = island.units.get(c).is_some_and(|&i| {
                let (mode, p) = (self.modes[c], self.impulse[c]);
                held(cones, island, c, mode).0 == 0 && cones.project(i as usize, mode, p) == p
            });
            if !is_steady {
                self.delassus.learn(factor, island, c, components(cones, island, c));
            }
        }
    }

    /// Assembles `R W A` for the present modes.
    fn fix_modes(&mut self, cones: &Cones, island: &Island) {
        self.active.clear();
        let mut begin = 0;
        for part in self.delassus.parts() {
            let (free, held) = held(cones, island, part.part, self.mode(part.part));
            if free > 0 {
                self.active.push(Active { part: *part, held, begin, end: begin + free });
            }
            begin += free;
        }
        let (system, n) = (self.system.start(begin), begin);
        for one in &self.active {
            let rows = one.part.rows();
            for (r, own) in (one.begin..one.end).enumerate() {
                let out = &mut system[own * n..(own + 1) * n];
                if one.has_all_rows() {
                    push_along(self.delassus.row(rows.start + r), &self.active, out);
                } else {
                    let velocity = &one.held[r].velocity[one.part.first..];
                    self.pulled.clear();
                    self.pulled.resize(self.delassus.len(), 0.0);
                    for (row, v) in rows.clone().zip(velocity) {
                        self.pulled.iter_mut().zip(self.delassus.row(row)).for_each(|(x, w)| *x += v * w);
                    }
                    push_along(&self.pulled, &self.active, out);
                }
                out[own] += TUNING.shared * scale(island, one.part.part);
            }
        }
    }

    /// Solves with the modes fixed, `R (u + W (r + A z)) = 0`, where `r` brings the impulses to where their modes have them, and takes the
    /// impulses there. Whether the last digits of the change are more of a velocity than is asked for: between rows that contradict each other in
    /// modes that are not the solution's impulses are enormous, and leave rounding when they are taken back.
    fn take_step(&mut self, task: &Task) -> bool {
        let (cones, island) = (task.cones, task.island);
        self.change.clear();
        self.change.resize(self.delassus.len(), 0.0);
        for part in self.delassus.parts().iter().filter(|part| part.part < island.units.len()) {
            let (c, p) = (part.part, self.impulse[part.part]);
            let projected = cones.project(island.units[c] as usize, self.modes[c], p);
            let rows = self.change[part.rows()].iter_mut().zip(part.first..);
            rows.for_each(|(change, r)| *change = projected[r] - p[r]);
        }
        // A second solution with the same factorisation leaves about `shared` of what the first one left.
        for _ in 0..2 {
            self.add_solution();
        }
        let mut largest = 0.0;
        for part in self.delassus.parts() {
            let (c, change) = (part.part, &mut self.change[part.rows()]);
            change.iter().for_each(|p| raise(&mut largest, p.abs() * scale(island, c)));
            let Some(&i) = island.units.get(c) else {
                self.bilateral[c - island.units.len()] += change[0];
                continue;
            };
            let (before, mut p) = (self.impulse[c], self.impulse[c]);
            p[part.first..].iter_mut().zip(&*change).for_each(|(p, change)| *p += change);
            let p = cones.project(i as usize, self.modes[c], p);
            change.iter_mut().zip(part.first..).for_each(|(change, r)| *change = p[r] - before[r]);
            self.impulse[c] = if c < island.contact_count { p } else { [before[0], p[1], p[2]] };
        }
        f64::EPSILON * largest > task.settings.polish * island.velocity_scale.value()
    }

    /// Adds `A z` to the change of the impulses, with which `R (u + W p)` vanishes but for what is shared.
    fn add_solution(&mut self) {
        self.unknowns.clear();
        let changes = self.change.iter().any(|p| *p != 0.0);
        for one in &self.active {
            let mut u = self.slack[one.part.part];
            for (u, row) in u[one.part.first..].iter_mut().zip(one.part.rows()).filter(|_| changes) {
                *u += self.delassus.row(row).iter().zip(&self.change).map(|(w, p)| w * p).sum::<f64>();
            }
            self.unknowns.extend(one.held[..one.end - one.begin].iter().map(|held| -dot(held.velocity, u)));
        }
        self.system.solve(&mut self.unknowns);
        for one in &self.active {
            let change = &mut self.change[one.part.rows()];
            for (z, held) in self.unknowns[one.begin..one.end].iter().zip(&one.held) {
                change.iter_mut().zip(&held.impulse[one.part.first..]).for_each(|(p, a)| *p += z * a);
            }
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

/// A part with unknowns.
#[derive(Clone, Copy, Debug)]
struct Active {
    part: Part,
    held: [Held; 3],
    /// Where its unknowns begin and end.
    begin: usize,
    end: usize,
}

impl Active {
    /// Whether its unknowns are the impulses of all its rows.
    fn has_all_rows(&self) -> bool {
        self.end - self.begin == self.part.rows().len()
    }
}

/// `w A` for a row over the known rows.
fn push_along(w: &[f64], active: &[Active], out: &mut [f64]) {
    for one in active {
        let (w, out) = (&w[one.part.rows()], &mut out[one.begin..one.end]);
        if one.has_all_rows() {
            out.copy_from_slice(w);
        } else {
            let along = |held: &Held| w.iter().zip(&held.impulse[one.part.first..]).map(|(w, p)| w * p).sum();
            out.iter_mut().zip(&one.held).for_each(|(x, held)| *x = along(held));
        }
    }
}

/// The components of a part that have a row: a contact without friction has its normal, a group along a line its first direction.
fn components(cones: &Cones, island: &Island, c: usize) -> Range<usize> {
    let Some(&i) = island.units.get(c) else { return 0..1 };
    if c >= island.contact_count && is_line(cones, i as usize) {
        1..2
    } else if c < island.contact_count && cones.friction(i as usize) == 0.0 {
        0..1
    } else {
        0..3
    }
}

/// Whether the polygon of a group is an interval of its first direction.
fn is_line(cones: &Cones, i: usize) -> bool {
    cones.direction_count(i) == 2 && cones.admissible(i, [0.0, 1.0]) == [0.0; 2]
}

/// What is free with the mode fixed, and what it holds: of a group its friction alone, as its bound is given; of a bilateral row all of it.
fn held(cones: &Cones, island: &Island, c: usize, mode: Mode) -> (usize, [Held; 3]) {
    let unit = |r: usize| {
        let mut unit = [0.0; 3];
        unit[r] = 1.0;
        Held { impulse: unit, velocity: unit }
    };
    let Some(&i) = island.units.get(c) else { return (1, [unit(0), Held::default(), Held::default()]) };
    let (free, held) = cones.held_directions(i as usize, mode);
    if c < island.contact_count || free == 0 {
        (free, held)
    } else if is_line(cones, i as usize) {
        (free - 1, [unit(1), Held::default(), Held::default()])
    } else {
        (free - 1, [held[1], held[2], Held::default()])
    }
}

/// The Delassus scale of a part.
fn scale(island: &Island, c: usize) -> f64 {
    island.scale.get(c).copied().unwrap_or_else(|| island.bilateral_scale[c - island.units.len()])
}
