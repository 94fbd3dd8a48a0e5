//! Block Gauss–Seidel sweeps over a large island.
//!
//! A block is a few dozen neighbouring contacts. With the impulses of all other contacts held where they are it is a contact
//! problem of its own, of the size that the proximal iterations and their paths solve exactly and at once; block after block
//! gets its solution, as contacts do in Jourdan, Alart and Jean (1998). Where the modes of a whole island are hard to find
//! because a path through them turns back, it is mostly a few contacts that have to jump, and within a block they do. Only
//! blocks in which a law is violated are solved; every sweep cuts the island in another way, so that no contact stays at a
//! seam.

use super::SolverSettings;
use super::island::Island;
use super::island_solver::{IslandSolver, law_residual};
use super::lists::Lists;
use super::proximal::LARGE;
use signorini_contact::ContactProblem;
use signorini_contact::projection::Cones;
use signorini_sparse::Random;

/// Units of a block at most: as many as the iterations for small islands take.
const BLOCK: usize = LARGE - 4;
/// Sweeps at most.
const SWEEPS: u32 = 30;
/// Part of the residual at the start, and the least residual, that blocks are left with.
const SETTLED: f64 = 1e-7;
const LEAST: f64 = 1e-9;

/// Memory of the block sweeps.
#[derive(Clone, Debug, Default)]
pub(crate) struct BlockSweeps {
    /// What solves the blocks.
    solver: Option<Box<IslandSolver>>,
    /// The block at hand, and the places of its units, bilateral rows and degrees of freedom in the island.
    block: Island,
    units: Vec<u32>,
    rows: Vec<u32>,
    dofs: Vec<u32>,
    /// Place of each of the island's degrees of freedom in the block.
    local: Vec<u32>,
    /// Units and bilateral rows at each block of the mass matrix.
    units_at: Lists,
    rows_at: Lists,
    /// The friction groups that each contact bounds.
    groups_of: Lists,
    order: Vec<u32>,
    taken: Vec<bool>,
    bodies: Vec<u32>,
    is_touched: Vec<bool>,
    free_velocity: Vec<f64>,
    /// A block whose laws are violated by less than this, relative to the velocity scale, is left as it is.
    settled: f64,
}

impl IslandSolver {
    /// Sweeps over the island from the present centre, until every block is settled or often enough. Moves the centre and the
    /// modes.
    pub(super) fn sweep_blocks(
        &mut self,
        problem: &ContactProblem,
        cones: &Cones,
        island: &Island,
        settings: &SolverSettings,
    ) {
        let mut memory = std::mem::take(&mut self.block_sweeps);
        self.set_weights(island, settings.proximal_weight);
        let residual = self.evaluate_centre(problem, cones, island);
        memory.settled = (SETTLED * residual).max(LEAST);
        memory.begin(self, cones, island);
        for sweep in 0..SWEEPS {
            if memory.sweep(self, problem, cones, island, settings, sweep) == 0 {
                break;
            }
        }
        self.block_sweeps = memory;
    }
}

impl BlockSweeps {
    fn begin(&mut self, solver: &mut IslandSolver, cones: &Cones, island: &Island) {
        let bodies = island.blocks.len();
        self.units_at.fill(bodies, |add| {
            (0..island.units.len())
                .for_each(|c| visit_bodies(island, island.jacobian.group(c).0, |b| add(b, c as u32)));
        });
        self.rows_at.fill(bodies, |add| {
            let columns = |k: usize| island.bilateral_jacobian.group(k).0;
            (0..island.bilateral.len()).for_each(|k| visit_bodies(island, columns(k), |b| add(b, k as u32)));
        });
        self.groups_of.fill(island.units.len(), |add| {
            for (k, &by) in island.bounded_by.iter().enumerate() {
                add(by as usize, (island.contact_count + k) as u32);
            }
        });
        self.local.clear();
        self.local.resize(island.nv(), 0);
        self.is_touched.clear();
        self.is_touched.resize(bodies, false);
        solver.modes.clear();
        for (c, &i) in island.units.iter().enumerate() {
            let (p, u, g) = (solver.impulse[c], island.slack(c, &solver.velocity), island.scale[c]);
            let bound = if c < island.contact_count { p[0] - u[0] / g } else { p[0] };
            solver.modes.push(cones.mode_at(i as usize, [bound, p[1] - u[1] / g, p[2] - u[2] / g]));
        }
    }

    /// Solves the blocks of one cut; returns how many were solved.
    fn sweep(
        &mut self,
        solver: &mut IslandSolver,
        problem: &ContactProblem,
        cones: &Cones,
        island: &Island,
        settings: &SolverSettings,
        sweep: u32,
    ) -> usize {
        let mut random = Random::new(sweep);
        self.order.clear();
        self.order.extend(0..island.units.len() as u32);
        for k in (1..self.order.len()).rev() {
            self.order.swap(k, random.below(k + 1));
        }
        self.taken.clear();
        self.taken.resize(island.units.len(), false);
        let mut solved = 0;
        for k in 0..self.order.len() {
            if self.taken[self.order[k] as usize] {
                continue;
            }
            self.gather_block(island, self.order[k]);
            if self.residual(solver, cones, island) > self.settled * solver.velocity_scale {
                self.cut(solver, problem, island);
                solved += usize::from(self.solve(solver, problem, cones, settings));
            }
        }
        solved
    }

    /// Takes units that are not taken yet, nearest first.
    fn gather_block(&mut self, island: &Island, seed: u32) {
        self.units.clear();
        self.bodies.clear();
        self.take_with_groups(island, seed);
        let mut next = 0;
        while next < self.units.len() && self.units.len() < BLOCK {
            let columns = island.jacobian.group(self.units[next] as usize).0;
            let mut first = 0;
            while first < columns.len() && self.units.len() < BLOCK {
                let body = island.block_of(columns[first] as usize);
                if !self.is_touched[body] {
                    self.is_touched[body] = true;
                    self.bodies.push(body as u32);
                    for k in 0..self.units_at.get(body).len() {
                        let c = self.units_at.get(body)[k];
                        if !self.taken[c as usize] && self.units.len() < BLOCK {
                            self.take_with_groups(island, c);
                        }
                    }
                }
                first += columns[first..].partition_point(|&c| (c as usize) < island.starts[body + 1]);
            }
            next += 1;
        }
        for &body in &self.bodies {
            self.is_touched[body as usize] = false;
        }
        self.units.sort_unstable();
    }

    /// Takes a unit, the contact that bounds it and the groups that the same contact bounds.
    fn take_with_groups(&mut self, island: &Island, c: u32) {
        let contact = (c as usize).checked_sub(island.contact_count).map_or(c, |k| island.bounded_by[k]);
        if !std::mem::replace(&mut self.taken[contact as usize], true) {
            self.units.push(contact);
        }
        for &group in self.groups_of.get(contact as usize) {
            if !std::mem::replace(&mut self.taken[group as usize], true) {
                self.units.push(group);
            }
        }
    }

    /// The worst residual of the laws of the block's units, m/s.
    fn residual(&self, solver: &IslandSolver, cones: &Cones, island: &Island) -> f64 {
        self.units.iter().fold(0.0, |worst, &c| {
            let c = c as usize;
            let u = island.pushing(c, island.slack(c, &solver.velocity));
            law_residual(cones, island.units[c] as usize, solver.impulse[c], u, island.residual_scale).max(worst)
        })
    }

    /// Makes the block an island, with the velocity that is left without its impulses as its free velocity.
    fn cut(&mut self, solver: &IslandSolver, problem: &ContactProblem, island: &Island) {
        let Self { block, units, rows, dofs, local, bodies, is_touched, free_velocity, .. } = self;
        block.clear();
        bodies.clear();
        for &c in units.iter() {
            visit_bodies(island, island.jacobian.group(c as usize).0, |b| {
                if !std::mem::replace(&mut is_touched[b], true) {
                    bodies.push(b as u32);
                }
            });
        }
        bodies.sort_unstable();
        dofs.clear();
        block.starts.push(0);
        for &b in bodies.iter() {
            is_touched[b as usize] = false;
            for dof in island.starts[b as usize]..island.starts[b as usize + 1] {
                local[dof] = dofs.len() as u32;
                dofs.push(dof as u32);
            }
            block.blocks.push(island.blocks[b as usize]);
            block.global_starts.push(island.global_starts[b as usize]);
            block.starts.push(dofs.len());
        }
        rows.clear();
        bodies.iter().for_each(|&b| rows.extend_from_slice(self.rows_at.get(b as usize)));
        rows.sort_unstable();
        rows.dedup();
        // A row that reaches out of the block stays as it is.
        let inside = |&k: &u32| {
            let mut inside = true;
            visit_bodies(island, island.bilateral_jacobian.group(k as usize).0, |b| {
                inside &= bodies.binary_search(&(b as u32)).is_ok();
            });
            inside
        };
        rows.retain(inside);
        block.velocity_scale = island.velocity_scale;
        block.residual_scale = island.residual_scale;
        free_velocity.clear();
        free_velocity.resize(dofs.len(), 0.0);
        for &c in units.iter() {
            let c = c as usize;
            let (columns, entries) = island.jacobian.group(c);
            block.jacobian.push_renumbered(columns.iter().map(|&k| local[k as usize]), entries);
            block.units.push(island.units[c]);
            match c.checked_sub(island.contact_count) {
                None => block.contact_count += 1,
                Some(k) => block.bounded_by.push(units.binary_search(&island.bounded_by[k]).unwrap_or(0) as u32),
            }
            block.offset.push(island.offset[c]);
            block.scale.push(island.scale[c]);
            let p = solver.impulse[c].map(|p| -p);
            let place = block.units.len() - 1;
            block.jacobian.add_transposed(place, island.pushing(c, p), free_velocity);
        }
        for &k in rows.iter() {
            let k = k as usize;
            let (columns, entries) = island.bilateral_jacobian.group(k);
            block.bilateral_jacobian.push_renumbered(columns.iter().map(|&k| local[k as usize]), entries);
            block.bilateral.push(island.bilateral[k]);
            block.bilateral_offset.push(island.bilateral_offset[k]);
            block.bilateral_scale.push(island.bilateral_scale[k]);
            let place = block.bilateral.len() - 1;
            block.bilateral_jacobian.add_transposed(place, [-solver.bilateral_impulse[k]], free_velocity);
        }
        block.solve_mass(&problem.mass_factor, free_velocity);
        for (v, &dof) in free_velocity.iter_mut().zip(dofs.iter()) {
            *v += solver.velocity[dof as usize];
        }
        for c in 0..block.units.len() {
            block.free_slack.push(block.slack(c, free_velocity));
        }
        for (k, offset) in block.bilateral_offset.iter().enumerate() {
            let [u] = block.bilateral_jacobian.multiply(k, free_velocity);
            block.bilateral_free_slack.push(u + offset);
        }
    }

    /// Solves the block, first from where it is; whether it took a solution.
    fn solve(
        &mut self,
        solver: &mut IslandSolver,
        problem: &ContactProblem,
        cones: &Cones,
        settings: &SolverSettings,
    ) -> bool {
        let Self { block, units, rows, dofs, free_velocity, settled, .. } = self;
        let inner = self.solver.get_or_insert_default();
        for attempt in 0..=settings.max_restarts {
            inner.start(problem, block);
            inner.free_velocity.copy_from_slice(free_velocity);
            if attempt == 0 {
                for (p, &c) in inner.impulse.iter_mut().zip(units.iter()) {
                    *p = solver.impulse[c as usize];
                }
                for (p, &k) in inner.bilateral_impulse.iter_mut().zip(rows.iter()) {
                    *p = solver.bilateral_impulse[k as usize];
                }
                inner.modes.extend(units.iter().map(|&c| solver.modes[c as usize]));
            }
            let residual = inner.run(problem, cones, block, settings, attempt);
            solver.effort.add(inner.effort);
            if residual > *settled {
                continue;
            }
            for (k, &c) in units.iter().enumerate() {
                solver.impulse[c as usize] = inner.impulse[k];
                solver.modes[c as usize] = inner.modes[k];
            }
            for (k, &row) in rows.iter().enumerate() {
                solver.bilateral_impulse[row as usize] = inner.bilateral_impulse[k];
            }
            for (v, &dof) in inner.velocity.iter().zip(dofs.iter()) {
                solver.velocity[dof as usize] = *v;
            }
            return true;
        }
        false
    }
}

/// Calls `visit` with every block of the mass matrix, by its place in the island, that ascending columns lie in.
fn visit_bodies(island: &Island, columns: &[u32], mut visit: impl FnMut(usize)) {
    let mut first = 0;
    while first < columns.len() {
        let body = island.block_of(columns[first] as usize);
        visit(body);
        first += columns[first..].partition_point(|&c| (c as usize) < island.starts[body + 1]);
    }
}

#[cfg(test)]
mod tests {
    use signorini_multibody::BlockDiagonal;

    use super::super::island_solver::started_on;
    use super::*;
    use signorini_contact::recovery::recover_into;
    use signorini_contact::{ContactSolution, FrictionPolygon, certify};

    const BODIES: usize = 60;

    /// Points of unit mass, each pushed into its predecessor, one farther away and the ground from random directions; what is open
    /// may stay so, so that there is a solution.
    fn heap(seed: u32) -> Box<ContactProblem> {
        let mut random = Random::new(seed);
        let n = 3 * BODIES;
        let unit = |k: usize| f64::from(u8::from(k / n == k % n));
        let mass = BlockDiagonal::from_dense(n, &(0..n * n).map(unit).collect::<Vec<_>>()).expect("the identity");
        let free_velocity = (0..n).map(|_| random.between(-1.0, 1.0)).collect();
        let mut problem = Box::new(ContactProblem::new(mass, free_velocity, 1e-2).expect("numbers"));
        let polygon = FrictionPolygon::regular(6, 0.0).expect("even");
        for body in 1..BODIES {
            for other in [Some(body - 1), (body > 9).then(|| body - random.below(9)), None] {
                let (polar, azimuth) = (random.between(0.2, 2.9_f64), random.between(0.0, std::f64::consts::TAU));
                let ((s, c), (sa, ca)) = (polar.sin_cos(), azimuth.sin_cos());
                let frame = [[s * ca, s * sa, c], [c * ca, c * sa, -s], [-sa, ca, 0.0]];
                let columns = |body: usize, sign: f64| {
                    (0..3).map(move |k| ((3 * body + k) as u32, frame.map(|direction| sign * direction[k])))
                };
                let other = other.filter(|&other| other != body).into_iter().flat_map(|other| columns(other, -1.0));
                let gap = if random.below(4) == 0 { random.between(0.0, 1e-3) } else { 0.0 };
                problem.push_contact(other.chain(columns(body, 1.0)), gap, random.between(0.1, 1.0), &polygon);
            }
        }
        problem
    }

    #[test]
    fn later_attempts_end_in_certified_solutions() {
        for (seed, attempt) in (0..6).flat_map(|seed| [(seed, 1), (seed, 2)]) {
            let problem = heap(seed);
            let (cones, islands, mut solver) = started_on(&problem);
            let island = &islands.all()[0];
            solver.run(&problem, &cones, island, &SolverSettings::default(), attempt);
            let mut solution = ContactSolution::default();
            solution.prepare(&problem);
            for (c, &i) in island.units.iter().enumerate() {
                solution.take_unit(i as usize, solver.impulse[c], solver.modes[c]);
            }
            island.scatter(&solver.velocity, &mut solution.velocity);
            recover_into(&problem, &cones, islands.velocity_scale(), &mut solution);
            let certificate = certify(&problem, &solution);
            assert!(certificate.holds(1e-9), "{seed}, {attempt}: {certificate:?}");
        }
    }

    /// Every unit is in exactly one block of a cut, no block is too large, and what is held outside explains the rest: at its own
    /// impulses a block moves as the whole island does.
    #[test]
    fn cuts_are_partitions_that_move_as_the_whole() {
        let problem = heap(7);
        let (cones, islands, mut solver) = started_on(&problem);
        let island = &islands.all()[0];
        let mut random = Random::new(1);
        solver.impulse.iter_mut().for_each(|p| *p = [random.between(0.1, 1.0), 0.0, 0.0]);
        solver.set_weights(island, 1.0);
        solver.evaluate_centre(&problem, &cones, island);
        let mut memory = BlockSweeps::default();
        memory.begin(&mut solver, &cones, island);
        memory.taken.resize(island.units.len(), false);
        let mut seen = vec![0; island.units.len()];
        for seed in 0..island.units.len() as u32 {
            if memory.taken[seed as usize] {
                continue;
            }
            memory.gather_block(island, seed);
            assert!(memory.units.len() < LARGE);
            memory.units.iter().for_each(|&c| seen[c as usize] += 1);
            memory.cut(&solver, &problem, island);
            let mut moved = vec![0.0; memory.dofs.len()];
            for (k, &c) in memory.units.iter().enumerate() {
                memory.block.add_impulse(k, solver.impulse[c as usize], &mut moved);
            }
            for ((moved, free), &dof) in moved.iter().zip(&memory.free_velocity).zip(&memory.dofs) {
                assert!((moved + free - solver.velocity[dof as usize]).abs() < 1e-12);
            }
        }
        assert!(seen.iter().all(|&count| count == 1), "{seen:?}");
    }
}
