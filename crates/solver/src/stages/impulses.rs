//! Newton's method in the space of impulses: the first attempt on robots, which have fewer rows than degrees of freedom.
//!
//! With the modes fixed the impulses of the contacts are `λ = A z`, and the laws ask for `R u = 0`: three unknowns where a contact
//! sticks, two on an edge of its polygon, one at a vertex or without friction, none where it is open. With `W = J M⁻¹ Jᵀ`, from half
//! solves with the factor of `M`, that is one small system, and no proximal iterations are needed. The next modes are those of `λ − u/g`.
//! What comes out is accepted where the laws hold to the accuracy of the polish; otherwise it was an attempt, of which nothing is kept.

use signorini_contact::StageOutcome;
use signorini_contact::projection::{Cones, Held, Mode};
use signorini_contact::scales::raise;
use signorini_contact::vector::dot;
use signorini_lcp::linalg::Lu;
use signorini_multibody::{BlockCholesky, FEW_ROWS};

use super::shared::{Outcome, Shared};
use crate::islands::Island;
use crate::iterate::{Effort, Iterate};
use crate::residual::{RESIDUALS, is_exact, law_residual};
use crate::task::Task;

/// What is tuned in this stage.
struct Tuning {
    /// What is added to the diagonal, in parts of a contact's Delassus scale, so that redundant contacts share: rounding of a velocity
    /// becomes an impulse among these that is larger by the inverse.
    shared: f64,
}

/// Chosen by: no command on record, since 22 November 2026.
const TUNING: Tuning = Tuning { shared: 1e-9 };

/// The memory of the method and its iterate.
#[derive(Clone, Debug, Default)]
pub(super) struct ImpulseNewton {
    /// The degrees of freedom on the ways from each contact to the roots, as bits.
    ways: Vec<u32>,
    /// `L⁻ᵀ Jᵀ` of each contact, `[contacts, nv]`; written in the rows of its ways.
    half: Vec<[f64; 3]>,
    /// `W`, `[contacts, contacts]` blocks, between the contacts that are known: those that pushed or were closed at some time.
    delassus: Vec<[[f64; 3]; 3]>,
    known: Vec<bool>,
    /// The contacts with unknowns.
    active: Vec<usize>,
    /// The unknowns of each contact, and where they begin; and the total.
    held: Vec<[Held; 3]>,
    begins: Vec<usize>,
    system: Lu,
    unknowns: Vec<f64>,
    /// What a step adds to the impulses and to the velocity.
    change: Vec<[f64; 3]>,
    work: Vec<f64>,
    impulse: Vec<[f64; 3]>,
    modes: Vec<Mode>,
    velocity: Vec<f64>,
    slack: Vec<[f64; 3]>,
}

/// A warm start whose velocity is that of its impulses, contacts alone, and not more rows than degrees of freedom.
pub(super) fn applies(task: &Task, iterate: &Iterate) -> bool {
    let island = task.island;
    let rows = |&unit: &u32| if task.cones.friction(unit as usize) > 0.0 { 3 } else { 1 };
    !iterate.velocity.is_empty()
        && island.nv() <= FEW_ROWS
        && island.bilateral.is_empty()
        && island.units.len() == island.contact_count
        && island.units.iter().map(rows).sum::<usize>() <= island.nv()
}

/// Solves the island, or leaves the iterate as it is.
pub(super) fn run(newton: &mut ImpulseNewton, shared: &mut Shared, task: &Task, iterate: &mut Iterate) -> Outcome {
    let residual = newton.iterate(task, iterate, &mut shared.map.effort);
    let Some(residual) = residual.filter(|residual| *residual <= task.settings.polish) else {
        return StageOutcome::Lost.into();
    };
    iterate.impulse.clone_from(&newton.impulse);
    iterate.modes.clone_from(&newton.modes);
    iterate.velocity.clone_from(&newton.velocity);
    iterate.residual = residual;
    StageOutcome::Solved.into()
}

impl ImpulseNewton {
    /// Newton steps from the iterate; the residual, if they ended with laws that hold to rounding, or came no further.
    fn iterate(&mut self, task: &Task, start: &Iterate, effort: &mut Effort) -> Option<f64> {
        let (cones, island, factor) = (task.cones, task.island, &task.problem.mass_factor);
        self.impulse.clone_from(&start.impulse);
        self.modes.clone_from(&start.modes);
        self.velocity.clone_from(&start.velocity);
        self.find_slack(island);
        self.forget_delassus(island);
        let (mut last, mut factored) = (f64::INFINITY, false);
        for _ in 0..task.settings.newton_iterations {
            if !factored {
                effort.factorizations += 1;
                self.find_delassus(factor, island);
                self.fix_modes(cones, island);
                factored = self.system.factorize() > 0.0;
            }
            if !factored {
                return None;
            }
            self.take_step(factor, cones, island);
            self.find_slack(island);
            let (residual, largest) = self.measure(cones, island, island.velocity_scale.value());
            if is_exact(residual, largest) {
                return Some(residual);
            }
            let changes = self.take_next_modes(cones, island);
            if changes == 0 && residual > RESIDUALS.slow * last {
                return Some(residual);
            }
            effort.mode_changes += changes;
            (last, factored) = (residual, changes == 0);
        }
        None
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
        if velocity_scale > 0.0 { (residual / velocity_scale, largest * scale / velocity_scale) } else { (0.0, 0.0) }
    }

    /// Makes room for `L⁻ᵀ Jᵀ` and `W`, of which nothing is known.
    fn forget_delassus(&mut self, island: &Island) {
        let (count, n) = (island.units.len(), island.nv());
        self.ways.clear();
        self.ways.resize(count, 0);
        self.known.clear();
        self.known.resize(count, false);
        self.half.resize(count * n, [0.0; 3]);
        self.delassus.resize(count * count, [[0.0; 3]; 3]);
    }

    /// `L⁻ᵀ Jᵀ` and `W` of the contacts that push or are closed: what is open changes nothing, and its slack follows from the velocity.
    fn find_delassus(&mut self, factor: &BlockCholesky, island: &Island) {
        let (count, n) = (island.units.len(), island.nv());
        for c in 0..count {
            if self.known[c] || (self.modes[c] == Mode::Open && self.impulse[c] == [0.0; 3]) {
                continue;
            }
            self.known[c] = true;
            let way = half_solve(factor, island, c, &mut self.half[c * n..(c + 1) * n]);
            self.ways[c] = way;
            for d in (0..count).filter(|&d| self.known[d]) {
                let (own, other) = (&self.half[c * n..(c + 1) * n], &self.half[d * n..(d + 1) * n]);
                let block = multiply_shared(own, other, way & self.ways[d]);
                self.delassus[c * count + d] = block;
                self.delassus[d * count + c] = std::array::from_fn(|r| std::array::from_fn(|s| block[s][r]));
            }
        }
    }

    /// Assembles `R W A` for the present modes.
    fn fix_modes(&mut self, cones: &Cones, island: &Island) {
        self.held.clear();
        self.active.clear();
        self.begins.clear();
        self.begins.push(0);
        let mut unknowns = 0;
        for (c, &i) in island.units.iter().enumerate() {
            let (free, held) = cones.held_directions(i as usize, self.modes[c]);
            unknowns += free;
            if free > 0 {
                self.active.push(c);
            }
            self.held.push(held);
            self.begins.push(unknowns);
        }
        let system = self.system.start(unknowns);
        // What sticks, or is closed without friction, has the rows of its block for unknowns.
        let is_plain = |c: usize| matches!(self.modes[c], Mode::Stick | Mode::Closed);
        for &c in &self.active {
            let blocks = &self.delassus[c * island.units.len()..(c + 1) * island.units.len()];
            for (r, own) in (self.begins[c]..self.begins[c + 1]).enumerate() {
                let (row, velocity) = (&mut system[own * unknowns..(own + 1) * unknowns], self.held[c][r].velocity);
                for &d in &self.active {
                    let (block, columns) = (&blocks[d], &mut row[self.begins[d]..self.begins[d + 1]]);
                    if is_plain(c) && is_plain(d) {
                        columns.iter_mut().zip(block[r]).for_each(|(x, w)| *x = w);
                        continue;
                    }
                    let pulled: [f64; 3] = std::array::from_fn(|s| {
                        velocity[0] * block[0][s] + velocity[1] * block[1][s] + velocity[2] * block[2][s]
                    });
                    columns.iter_mut().zip(&self.held[d]).for_each(|(x, other)| *x = dot(pulled, other.impulse));
                }
                row[own] += TUNING.shared * island.scale[c];
            }
        }
    }

    /// Solves with the modes fixed, `R (u + W (r + A z)) = 0`, where `r` brings the impulses to where their modes have them, and takes
    /// impulses and velocity there.
    fn take_step(&mut self, factor: &BlockCholesky, cones: &Cones, island: &Island) {
        self.change.clear();
        for (c, &i) in island.units.iter().enumerate() {
            let (p, projected) = (self.impulse[c], cones.project(i as usize, self.modes[c], self.impulse[c]));
            self.change.push(std::array::from_fn(|r| projected[r] - p[r]));
        }
        // A second solution with the same factorisation leaves about `shared` of what the first one left.
        for _ in 0..2 {
            self.add_solution(island.units.len());
        }
        for (c, &i) in island.units.iter().enumerate() {
            let (before, change) = (self.impulse[c], self.change[c]);
            let p = cones.project(i as usize, self.modes[c], std::array::from_fn(|r| before[r] + change[r]));
            self.change[c] = std::array::from_fn(|r| p[r] - before[r]);
            self.impulse[c] = p;
        }
        self.add_velocity(factor, island);
    }

    /// Adds `A z` to the change of the impulses, with which `R (u + W p)` vanishes but for what is shared.
    fn add_solution(&mut self, count: usize) {
        self.unknowns.clear();
        for &c in &self.active {
            let (mut u, blocks) = (self.slack[c], &self.delassus[c * count..(c + 1) * count]);
            for (block, p) in blocks.iter().zip(&self.change).filter(|(_, p)| **p != [0.0; 3]) {
                (0..3).for_each(|r| u[r] += dot(block[r], *p));
            }
            let free = self.begins[c + 1] - self.begins[c];
            self.unknowns.extend(self.held[c][..free].iter().map(|held| -dot(held.velocity, u)));
        }
        self.system.solve(&mut self.unknowns);
        for &c in &self.active {
            let p = &mut self.change[c];
            let own = self.unknowns[self.begins[c]..self.begins[c + 1]].iter().zip(&self.held[c]);
            own.for_each(|(z, held)| (0..3).for_each(|r| p[r] += z * held.impulse[r]));
        }
    }

    /// Adds `M⁻¹ Jᵀ` times the change of the impulses to the velocity.
    fn add_velocity(&mut self, factor: &BlockCholesky, island: &Island) {
        let n = island.nv();
        self.work.clear();
        self.work.resize(n, 0.0);
        for (c, p) in self.change.iter().enumerate() {
            let half = &self.half[c * n..(c + 1) * n];
            for_each_bit(self.ways[c], |k| self.work[k] += dot(half[k], *p));
        }
        for (k, &block) in island.blocks.iter().enumerate() {
            let own = island.starts[k]..island.starts[k + 1];
            factor.other_half_solve_block_in_place(block as usize, &mut self.work[own]);
        }
        self.velocity.iter_mut().zip(&self.work).for_each(|(v, d)| *v += d);
    }
}

/// `L⁻ᵀ Jᵀ` of one contact over the degrees of freedom of the island; returns those on its ways to the roots as bits.
fn half_solve(factor: &BlockCholesky, island: &Island, c: usize, half: &mut [[f64; 3]]) -> u32 {
    let (columns, entries) = island.jacobian.group(c);
    let (mut first, mut way) = (0, 0);
    while first < columns.len() {
        let k = island.block_of(columns[first] as usize);
        let (start, end) = (island.starts[k], island.starts[k + 1]);
        let (mut rows, mut last) = ([0; FEW_ROWS], first);
        while last < columns.len() && (columns[last] as usize) < end {
            rows[last - first] = columns[last] as usize - start;
            last += 1;
        }
        let own = &mut half[start..end];
        let rows = &rows[..last - first];
        way |= factor.half_solve_on_ways(island.blocks[k] as usize, rows, &entries[first..last], own) << start;
        first = last;
    }
    way
}

/// `Aᵀ B` over the rows whose bits are set.
fn multiply_shared(a: &[[f64; 3]], b: &[[f64; 3]], rows: u32) -> [[f64; 3]; 3] {
    let (mut product, mut left) = ([[0.0; 3]; 3], rows);
    while left != 0 {
        let first = left.trailing_zeros();
        let run = first as usize..(first + (left >> first).trailing_ones()) as usize;
        for (a, b) in a[run.clone()].iter().zip(&b[run]) {
            for r in 0..3 {
                (0..3).for_each(|s| product[r][s] += a[r] * b[s]);
            }
        }
        // A carry out of the run clears it.
        left &= left.wrapping_add(1 << first);
    }
    product
}

fn for_each_bit(mut bits: u32, mut visit: impl FnMut(usize)) {
    while bits != 0 {
        visit(bits.trailing_zeros() as usize);
        bits &= bits - 1;
    }
}
