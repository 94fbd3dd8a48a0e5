//! Impulses inside the cones of their contacts, where a step admits such.
//!
//! Contacts that are redundant carry their load in many ways, and a solver ends where its method led: often where some contact carries
//! nothing or stands at its friction bound, though nothing asks for that. Whether the velocity has a derivative does not depend on the
//! choice, but its margins do. Here it is the centre of the set: of all impulses `x ≥ 0` along the edges of the cones that `v⁺` admits,
//! with the same sum of momenta `G x = p`,
//!
//! ```text
//! minimise  Σ (½ x² − log x)   subject to   G x = p,
//! ```
//!
//! with momenta in units of `p` and each `x` in those of the impulse that alone had its size. What stays at zero does so in all of them.
//!
//! # Source
//! The primal–dual method for convex quadratic programs; S. Wright, *Primal-Dual Interior-Point Methods* (1997), chapters 1 and 8. That the
//! derivative exists where one solution of the impulses is strictly complementary: Pang, Stewart (2009), theorem 3.

use signorini_contact::projection::Cones;
use signorini_contact::recovery::recover_into;
use signorini_contact::{ContactProblem, ContactSolution};

use crate::matrix::{Rows, add_scaled, cholesky, cholesky_solve, dot, largest};
use crate::mode::Scales;

/// A velocity is zero up to this part of the scale, or ten times the residual of the solution.
const STILL: f64 = 1e-9;
/// Momentum may be missed by this part times the square root of what the balance costs: what bounds impulses that have to be zero.
const SLACK: f64 = 1e-13;
/// Iterations of the method, which needs about ten; twice as many where impulses have to vanish.
const ITERATIONS: usize = 40;
/// How far products of impulses and multipliers may be from 1: any place well inside will do.
const CENTRED: f64 = 0.5;
/// The balance of the impulses found, relative to the momentum.
const BALANCED: f64 = 1e-11;
/// Degrees of freedom of what hangs together at most: its dense system is factored in every iteration.
const LARGEST: usize = 300;

/// The set of impulses of a solution and the storage to look for its centre.
#[derive(Clone, Debug, Default)]
pub(crate) struct Interior {
    /// For every degree of freedom its place among those at hand.
    place: Vec<Option<usize>>,
    size: usize,
    /// Edges of cones, then bilateral rows, in units of the momentum; over the degrees of freedom at hand.
    edges: Rows,
    /// The contact of each edge and the edge, or the bilateral row; what a unit of it is in N·s.
    owners: Vec<(Owner, f64)>,
    target: Vec<f64>,
    x: Vec<f64>,
    multiplier: Vec<f64>,
    system: Vec<f64>,
    right: Vec<f64>,
    cones: Cones,
}

#[derive(Clone, Copy, Debug)]
enum Owner {
    Contact(usize, [f64; 3]),
    Bilateral(usize),
}

impl Interior {
    /// Replaces the impulses of a solution where contacts of what hangs together with `ties` may have others. The velocity stays.
    ///
    /// - `ties`: contacts that are at an edge of what they may do
    pub fn choose(
        &mut self,
        problem: &ContactProblem,
        scales: Scales,
        ties: &[usize],
        solution: &mut ContactSolution,
    ) -> bool {
        // The bound of spinning and rolling friction moves with the normal impulse; this set is not described here.
        let moves = |bound: &signorini_contact::FrictionBound| bound.normal().is_some();
        if problem.friction_groups.bound.iter().any(moves) {
            return false;
        }
        self.find_island(problem, ties);
        if self.size == 0 || self.size > LARGEST {
            return false;
        }
        let contacts: Vec<usize> = (0..problem.contact_count()).filter(|&i| self.holds(problem, i)).collect();
        let rows = 0..problem.bilateral_violation.len();
        let bilateral: Vec<usize> = rows.filter(|&k| self.has(problem.bilateral_jacobian.group(k).0)).collect();
        self.take_edges(problem, scales, (&contacts, &bilateral), solution);
        if !(self.edges.len() > 0 && self.scale_by_momentum(problem) && self.centre(problem)) {
            return false;
        }
        for &i in &contacts {
            solution.impulse[i] = [0.0; 3];
        }
        for ((owner, unit), x) in self.owners.iter().zip(&self.x) {
            match *owner {
                Owner::Contact(i, edge) => (0..3).for_each(|a| solution.impulse[i][a] += edge[a] * unit * x),
                Owner::Bilateral(k) => solution.bilateral[k] = unit * x,
            }
        }
        self.cones.prepare(problem);
        recover_into(problem, &self.cones, problem.velocity_scale(), solution);
        true
    }

    /// The degrees of freedom that contacts, constraints and the mass matrix tie to the contacts given.
    fn find_island(&mut self, problem: &ContactProblem, ties: &[usize]) {
        self.place.clear();
        self.place.resize(problem.nv(), None);
        let mut members = vec![false; problem.nv()];
        let mark = |columns: &[u32], members: &mut [bool]| columns.iter().for_each(|&c| members[c as usize] = true);
        ties.iter().for_each(|&i| mark(problem.jacobian.group(i).0, &mut members));
        loop {
            let before = members.iter().filter(|m| **m).count();
            for block in problem.mass.blocks() {
                if block.range().any(|k| members[k]) {
                    block.range().for_each(|k| members[k] = true);
                }
            }
            let contacts = (0..problem.contact_count()).map(|i| problem.jacobian.group(i).0);
            let bilateral = (0..problem.bilateral_violation.len()).map(|k| problem.bilateral_jacobian.group(k).0);
            for columns in contacts.chain(bilateral) {
                if columns.iter().any(|&c| members[c as usize]) {
                    mark(columns, &mut members);
                }
            }
            if members.iter().filter(|m| **m).count() == before {
                break;
            }
        }
        self.size = 0;
        for (place, _) in self.place.iter_mut().zip(&members).filter(|(_, member)| **member) {
            *place = Some(self.size);
            self.size += 1;
        }
    }

    fn has(&self, columns: &[u32]) -> bool {
        columns.first().is_some_and(|&c| self.place[c as usize].is_some())
    }

    fn holds(&self, problem: &ContactProblem, i: usize) -> bool {
        self.has(problem.jacobian.group(i).0)
    }

    /// The edges of the cones that the velocity admits, and the momentum that the impulses at hand give.
    fn take_edges(
        &mut self,
        problem: &ContactProblem,
        scales: Scales,
        (contacts, bilateral): (&[usize], &[usize]),
        solution: &ContactSolution,
    ) {
        self.edges.clear(self.size);
        self.owners.clear();
        self.target.clear();
        self.target.resize(self.size, 0.0);
        let still = STILL.max(10.0 * solution.certificate.worst());
        for &i in contacts {
            let (columns, entries) = problem.jacobian.group(i);
            let [c_n, c_1, c_2] = problem.contact_velocity(i, &solution.velocity);
            let of = |edge: [f64; 3], entry: &[f64; 3]| (0..3).map(|a| edge[a] * entry[a]).sum::<f64>();
            for (&c, entry) in columns.iter().zip(entries) {
                let Some(at) = self.place[c as usize] else { continue };
                self.target[at] += of(solution.impulse[i], entry);
            }
            if scales.velocity(problem.gap[i] / problem.timestep + c_n) > still {
                continue;
            }
            let (directions, friction) = (problem.directions_of(i), problem.friction[i]);
            let along = |d: &[f64; 2]| -(d[0] * c_1 + d[1] * c_2);
            let speed = directions.iter().map(along).fold(0.0, f64::max);
            let sticks = scales.velocity(speed) <= still;
            let mut add = |edge: [f64; 3]| {
                let row = self.edges.push();
                for (&c, entry) in columns.iter().zip(entries) {
                    if let Some(at) = self.place[c as usize] {
                        row[at] = of(edge, entry);
                    }
                }
                self.owners.push((Owner::Contact(i, edge), 1.0));
            };
            if directions.is_empty() || friction == 0.0 {
                add([1.0, 0.0, 0.0]);
            }
            for d in
                directions.iter().filter(|d| friction > 0.0 && (sticks || scales.velocity(speed - along(d)) <= still))
            {
                add([1.0, friction * d[0], friction * d[1]]);
            }
        }
        for &k in bilateral {
            let (columns, entries) = problem.bilateral_jacobian.group(k);
            let row = self.edges.push();
            for (&c, entry) in columns.iter().zip(entries) {
                if let Some(at) = self.place[c as usize] {
                    row[at] = entry[0];
                    self.target[at] += entry[0] * solution.bilateral[k];
                }
            }
            self.owners.push((Owner::Bilateral(k), 1.0));
        }
    }

    /// Brings momenta to units of the whole; `false` where there is none.
    fn scale_by_momentum(&mut self, problem: &ContactProblem) -> bool {
        let mut whole = vec![0.0; problem.nv()];
        let mut norm = |x: &[f64], place: &[Option<usize>]| {
            for (to, at) in whole.iter_mut().zip(place) {
                *to = at.map_or(0.0, |at| x[at]);
            }
            problem.mass_factor.solve_in_place(&mut whole);
            whole.iter().zip(place).filter_map(|(w, at)| at.map(|at| w * x[at])).sum::<f64>().sqrt()
        };
        let momentum = norm(&self.target, &self.place);
        if momentum <= 0.0 {
            return false;
        }
        self.target.iter_mut().for_each(|x| *x /= momentum);
        for (k, (_, unit)) in self.owners.iter_mut().enumerate() {
            let size = norm(self.edges.row(k), &self.place);
            if size <= 0.0 {
                return false;
            }
            *unit = momentum / size;
            self.edges.row_mut(k).iter_mut().for_each(|x| *x /= size);
        }
        true
    }

    /// The primal–dual method; whether it ended with the balance.
    fn centre(&mut self, problem: &ContactProblem) -> bool {
        let (n, count) = (self.size, self.edges.len());
        let bounded: Vec<bool> = self.owners.iter().map(|(o, _)| matches!(o, Owner::Contact(..))).collect();
        self.x.clear();
        self.x.extend(bounded.iter().map(|b| f64::from(u8::from(*b))));
        self.multiplier.clear();
        self.multiplier.extend(bounded.iter().map(|b| f64::from(u8::from(*b))));
        let (mut weight, mut pull, mut change) = (vec![0.0; count], vec![0.0; count], vec![0.0; count]);
        for _ in 0..ITERATIONS {
            for k in 0..count {
                let (x, s) = (self.x[k], self.multiplier[k]);
                (weight[k], pull[k]) = if bounded[k] { (1.0 / (1.0 + s / x), 1.0 / x - x) } else { (1.0, -x) };
            }
            self.miss();
            for (k, (w, p)) in weight.iter().zip(&pull).enumerate() {
                add_scaled(&mut self.right, -w * p, self.edges.row(k));
            }
            if !self.factor(problem, &weight) {
                return false;
            }
            cholesky_solve(&self.system, n, &mut self.right);
            let (mut by_x, mut by_s) = (1.0_f64, 1.0_f64);
            for k in 0..count {
                change[k] = weight[k] * (dot(self.edges.row(k), &self.right) + pull[k]);
                if bounded[k] {
                    let (x, s) = (self.x[k], self.multiplier[k]);
                    let change_s = (1.0 - s * change[k]) / x - s;
                    by_x = by_x.min(if change[k] < 0.0 { -0.99 * x / change[k] } else { 1.0 });
                    by_s = by_s.min(if change_s < 0.0 { -0.99 * s / change_s } else { 1.0 });
                }
            }
            for k in 0..count {
                let (x, s) = (self.x[k], self.multiplier[k]);
                if bounded[k] {
                    self.multiplier[k] += by_s * ((1.0 - s * change[k]) / x - s);
                }
                self.x[k] += by_x * change[k];
            }
            let off = (0..count).filter(|&k| bounded[k]).map(|k| (self.x[k] * self.multiplier[k] - 1.0).abs());
            if by_x == 1.0 && off.fold(0.0, f64::max) < CENTRED {
                break;
            }
        }
        self.finish(problem, &mut weight)
    }

    /// Takes what is left of the balance from each impulse in proportion to its size.
    fn finish(&mut self, problem: &ContactProblem, weight: &mut [f64]) -> bool {
        for _ in 0..3 {
            weight.iter_mut().zip(&self.x).for_each(|(w, x)| *w = x * x);
            self.miss();
            if !self.factor(problem, weight) {
                return false;
            }
            cholesky_solve(&self.system, self.size, &mut self.right);
            for k in 0..weight.len() {
                self.x[k] += weight[k] * dot(self.edges.row(k), &self.right);
            }
        }
        self.miss();
        let is_inside = |(x, (owner, _)): (&f64, &(Owner, f64))| *x >= 0.0 || matches!(owner, Owner::Bilateral(_));
        largest(&self.right) <= BALANCED * largest(&self.target) && self.x.iter().zip(&self.owners).all(is_inside)
    }

    /// `right = p − G x`.
    fn miss(&mut self) {
        self.right.clear();
        self.right.extend_from_slice(&self.target);
        for (k, x) in self.x.iter().enumerate() {
            add_scaled(&mut self.right, -x, self.edges.row(k));
        }
    }

    /// Factors `ε M + G D Gᵀ`.
    fn factor(&mut self, problem: &ContactProblem, weight: &[f64]) -> bool {
        let n = self.size;
        self.system.clear();
        self.system.resize(n * n, 0.0);
        for (k, w) in weight.iter().enumerate() {
            let edge = self.edges.row(k);
            for (r, x) in edge.iter().enumerate().filter(|(_, x)| **x != 0.0) {
                add_scaled(&mut self.system[r * n..r * n + r + 1], w * x, &edge[..=r]);
            }
        }
        for block in problem.mass.blocks() {
            for (r, c) in block.range().flat_map(|r| block.range().map(move |c| (r, c))) {
                if let (Some(to_r), Some(to_c)) = (self.place[r], self.place[c]) {
                    self.system[to_r * n + to_c] += SLACK * problem.mass.get(r, c);
                }
            }
        }
        cholesky(&mut self.system, n)
    }
}
