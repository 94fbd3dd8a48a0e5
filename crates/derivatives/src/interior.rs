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
//! Momenta are taken in coordinates in which `M⁻¹` is 1, and where contacts are few, in an orthonormal basis of what they can give: two
//! feet give twelve numbers, however many points they have and joints are above them.
//!
//! # Source
//! The primal–dual method for convex quadratic programs; S. Wright, *Primal-Dual Interior-Point Methods* (1997), chapters 1 and 8. That the
//! derivative exists where one solution of the impulses is strictly complementary: Pang, Stewart (2009), theorem 3.

use signorini_contact::projection::Cones;
use signorini_contact::recovery::recover_into;
use signorini_contact::{ContactProblem, ContactSolution};

use crate::matrix::{Rows, Work, add_scaled, cholesky, cholesky_solve, dot, largest, wide};
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
/// A row of which this part is left by those before is the rounding of a dependent one.
const DEPENDENT: f64 = 1e-12;

/// The set of impulses of a solution and the storage to look for its centre.
#[derive(Clone, Debug, Default)]
pub(crate) struct Interior {
    /// For every degree of freedom its place among those at hand.
    place: Vec<Option<usize>>,
    members: Vec<bool>,
    contacts: Vec<usize>,
    bilateral: Vec<usize>,
    /// What contacts (three rows each) and bilateral rows give per unit, an orthonormal basis of that, and what they give in it.
    given: Rows,
    basis: Rows,
    coordinates: Rows,
    whole: Vec<f64>,
    size: usize,
    /// Edges of cones, then bilateral rows, in units of the momentum.
    edges: Rows,
    /// The contact of each edge and the edge, or the bilateral row; what a unit of it is in N·s.
    owners: Vec<(Owner, f64)>,
    target: Vec<f64>,
    x: Vec<f64>,
    multiplier: Vec<f64>,
    bounded: Vec<bool>,
    weight: Vec<f64>,
    pull: Vec<f64>,
    change: Vec<f64>,
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
        if ties.is_empty() || problem.friction_groups.bound.iter().any(moves) {
            return false;
        }
        self.find_island(problem, ties);
        if self.size == 0 || self.size > LARGEST {
            return false;
        }
        self.take_given(problem);
        wide(Coordinates(self));
        self.take_edges(problem, scales, solution);
        if !(self.edges.len() > 0 && self.scale_by_momentum() && wide(Centre(self))) {
            return false;
        }
        let contacts = &self.contacts;
        for &i in contacts {
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

    /// The degrees of freedom that contacts, constraints and the mass matrix tie to the contacts given, and what acts on them.
    fn find_island(&mut self, problem: &ContactProblem, ties: &[usize]) {
        let Self { place, members, contacts, bilateral, .. } = self;
        members.clear();
        members.resize(problem.nv(), false);
        let mark = |columns: &[u32], members: &mut [bool]| columns.iter().for_each(|&c| members[c as usize] = true);
        ties.iter().for_each(|&i| mark(problem.jacobian.group(i).0, members));
        loop {
            let before = members.iter().filter(|m| **m).count();
            for block in problem.mass.blocks() {
                if block.range().any(|k| members[k]) {
                    block.range().for_each(|k| members[k] = true);
                }
            }
            let of_contacts = (0..problem.contact_count()).map(|i| problem.jacobian.group(i).0);
            let of_rows = (0..problem.bilateral_violation.len()).map(|k| problem.bilateral_jacobian.group(k).0);
            for columns in of_contacts.chain(of_rows) {
                if columns.iter().any(|&c| members[c as usize]) {
                    mark(columns, members);
                }
            }
            if members.iter().filter(|m| **m).count() == before {
                break;
            }
        }
        self.size = 0;
        place.clear();
        place.extend(members.iter().map(|&is_member| {
            self.size += usize::from(is_member);
            is_member.then(|| self.size - 1)
        }));
        let has = |columns: &[u32]| columns.first().is_some_and(|&c| members[c as usize]);
        contacts.clear();
        contacts.extend((0..problem.contact_count()).filter(|&i| has(problem.jacobian.group(i).0)));
        bilateral.clear();
        let rows = 0..problem.bilateral_violation.len();
        bilateral.extend(rows.filter(|&k| has(problem.bilateral_jacobian.group(k).0)));
    }

    /// What contacts and bilateral rows give, in coordinates in which `M⁻¹` is 1.
    fn take_given(&mut self, problem: &ContactProblem) {
        self.given.clear(self.size);
        for i in 0..self.contacts.len() {
            let (columns, entries) = problem.jacobian.group(self.contacts[i]);
            (0..3).for_each(|a| self.push_given(problem, columns, entries.iter().map(|entry| entry[a])));
        }
        for k in 0..self.bilateral.len() {
            let (columns, entries) = problem.bilateral_jacobian.group(self.bilateral[k]);
            self.push_given(problem, columns, entries.iter().map(|entry| entry[0]));
        }
    }

    /// The same in a basis of it where that is smaller; sets `size` to the number of coordinates.
    #[inline(always)]
    fn take_coordinates(&mut self) {
        let Self { given, basis, coordinates, .. } = self;
        if given.len() >= self.size {
            coordinates.width = given.width;
            coordinates.data.clone_from(&given.data);
            return;
        }
        basis.clear(self.size);
        for row in given.data.chunks_exact(self.size) {
            let before = dot(row, row);
            basis.push().copy_from_slice(row);
            let last = basis.len() - 1;
            // Twice is enough.
            for j in (0..last).chain(0..last) {
                let (own, other) = basis.pair(last, j);
                let along = dot(own, other);
                own.iter_mut().zip(other).for_each(|(x, y)| *x -= along * y);
            }
            let own = basis.row_mut(last);
            let left = dot(own, own);
            if left > DEPENDENT * DEPENDENT * before {
                own.iter_mut().for_each(|x| *x /= left.sqrt());
            } else {
                basis.data.truncate(last * self.size);
            }
        }
        coordinates.clear(basis.len());
        for row in given.data.chunks_exact(self.size) {
            let own = coordinates.push();
            own.iter_mut().enumerate().for_each(|(j, x)| *x = dot(row, basis.row(j)));
        }
        self.size = basis.len();
    }

    fn push_given(&mut self, problem: &ContactProblem, columns: &[u32], entries: impl Iterator<Item = f64>) {
        let Self { whole, place, given, .. } = self;
        whole.clear();
        whole.resize(problem.nv(), 0.0);
        columns.iter().zip(entries).for_each(|(&c, x)| whole[c as usize] = x);
        for (b, block) in problem.mass_factor.blocks().iter().enumerate() {
            let own = &mut whole[block.range()];
            if own.iter().any(|x| *x != 0.0) {
                problem.mass_factor.half_solve_block_in_place(b, own);
            }
        }
        let row = given.push();
        for (x, at) in whole.iter().zip(place) {
            if let Some(at) = at {
                row[*at] = *x;
            }
        }
    }

    /// The edges of the cones that the velocity admits, and the momentum that the impulses at hand give.
    fn take_edges(&mut self, problem: &ContactProblem, scales: Scales, solution: &ContactSolution) {
        let Self { edges, owners, target, coordinates, contacts, bilateral, size, .. } = self;
        edges.clear(*size);
        owners.clear();
        target.clear();
        target.resize(*size, 0.0);
        let still = STILL.max(10.0 * solution.certificate.worst());
        for (first, &i) in contacts.iter().enumerate().map(|(at, i)| (3 * at, i)) {
            let [c_n, c_1, c_2] = problem.contact_velocity(i, &solution.velocity);
            (0..3).for_each(|a| add_scaled(target, solution.impulse[i][a], coordinates.row(first + a)));
            if scales.velocity(problem.gap[i] / problem.timestep + c_n) > still {
                continue;
            }
            let (directions, friction) = (problem.directions_of(i), problem.friction[i]);
            let along = |d: &[f64; 2]| -(d[0] * c_1 + d[1] * c_2);
            let speed = directions.iter().map(along).fold(0.0, f64::max);
            let sticks = scales.velocity(speed) <= still;
            let mut add = |edge: [f64; 3]| {
                let row = edges.push();
                (0..3).for_each(|a| add_scaled(row, edge[a], coordinates.row(first + a)));
                owners.push((Owner::Contact(i, edge), 1.0));
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
        for (at, &k) in bilateral.iter().enumerate() {
            let own = coordinates.row(3 * contacts.len() + at);
            edges.push().copy_from_slice(own);
            add_scaled(target, solution.bilateral[k], own);
            owners.push((Owner::Bilateral(k), 1.0));
        }
    }

    /// Brings momenta to units of the whole; `false` where there is none.
    fn scale_by_momentum(&mut self) -> bool {
        let norm = |x: &[f64]| dot(x, x).sqrt();
        let momentum = norm(&self.target);
        if momentum <= 0.0 {
            return false;
        }
        self.target.iter_mut().for_each(|x| *x /= momentum);
        for (k, (_, unit)) in self.owners.iter_mut().enumerate() {
            let size = norm(self.edges.row(k));
            if size <= 0.0 {
                return false;
            }
            *unit = momentum / size;
            self.edges.row_mut(k).iter_mut().for_each(|x| *x /= size);
        }
        true
    }

    /// The primal–dual method; whether it ended with the balance.
    #[inline(always)]
    fn centre(&mut self) -> bool {
        let count = self.edges.len();
        self.bounded.clear();
        self.bounded.extend(self.owners.iter().map(|(o, _)| matches!(o, Owner::Contact(..))));
        for values in [&mut self.x, &mut self.multiplier] {
            values.clear();
            values.extend(self.bounded.iter().map(|b| f64::from(u8::from(*b))));
        }
        for values in [&mut self.weight, &mut self.pull, &mut self.change] {
            values.clear();
            values.resize(count, 0.0);
        }
        for _ in 0..ITERATIONS {
            for k in 0..count {
                let (x, s) = (self.x[k], self.multiplier[k]);
                (self.weight[k], self.pull[k]) =
                    if self.bounded[k] { (1.0 / (1.0 + s / x), 1.0 / x - x) } else { (1.0, -x) };
            }
            self.miss();
            for (k, (w, p)) in self.weight.iter().zip(&self.pull).enumerate() {
                add_scaled(&mut self.right, -w * p, self.edges.row(k));
            }
            if !self.factor() {
                return false;
            }
            cholesky_solve(&self.system, self.size, &mut self.right);
            let by_x = self.advance();
            let off = (0..count).filter(|&k| self.bounded[k]).map(|k| (self.x[k] * self.multiplier[k] - 1.0).abs());
            if by_x == 1.0 && off.fold(0.0, f64::max) < CENTRED {
                break;
            }
        }
        self.finish()
    }

    /// A step along the change that the system's solution gives, short enough to stay inside; returns its length.
    #[inline(always)]
    fn advance(&mut self) -> f64 {
        let (mut by_x, mut by_s) = (1.0_f64, 1.0_f64);
        for k in 0..self.edges.len() {
            let change = self.weight[k] * (dot(self.edges.row(k), &self.right) + self.pull[k]);
            self.change[k] = change;
            if self.bounded[k] {
                let (x, s) = (self.x[k], self.multiplier[k]);
                let change_s = (1.0 - s * change) / x - s;
                by_x = by_x.min(if change < 0.0 { -0.99 * x / change } else { 1.0 });
                by_s = by_s.min(if change_s < 0.0 { -0.99 * s / change_s } else { 1.0 });
            }
        }
        for (k, change) in self.change.iter().enumerate() {
            let (x, s) = (self.x[k], self.multiplier[k]);
            if self.bounded[k] {
                self.multiplier[k] += by_s * ((1.0 - s * change) / x - s);
            }
            self.x[k] += by_x * change;
        }
        by_x
    }

    /// Takes what is left of the balance from each impulse in proportion to its size.
    #[inline(always)]
    fn finish(&mut self) -> bool {
        for _ in 0..3 {
            self.weight.iter_mut().zip(&self.x).for_each(|(w, x)| *w = x * x);
            self.miss();
            if !self.factor() {
                return false;
            }
            cholesky_solve(&self.system, self.size, &mut self.right);
            for k in 0..self.weight.len() {
                self.x[k] += self.weight[k] * dot(self.edges.row(k), &self.right);
            }
        }
        self.miss();
        let is_inside = |(x, (owner, _)): (&f64, &(Owner, f64))| *x >= 0.0 || matches!(owner, Owner::Bilateral(_));
        largest(&self.right) <= BALANCED * largest(&self.target) && self.x.iter().zip(&self.owners).all(is_inside)
    }

    /// `right = p − G x`.
    #[inline(always)]
    fn miss(&mut self) {
        self.right.clear();
        self.right.extend_from_slice(&self.target);
        for (k, x) in self.x.iter().enumerate() {
            add_scaled(&mut self.right, -x, self.edges.row(k));
        }
    }

    /// Factors `ε + G D Gᵀ`.
    #[inline(always)]
    fn factor(&mut self) -> bool {
        let n = self.size;
        self.system.clear();
        self.system.resize(n * n, 0.0);
        for (k, w) in self.weight.iter().enumerate() {
            let edge = self.edges.row(k);
            for (r, x) in edge.iter().enumerate().filter(|(_, x)| **x != 0.0) {
                add_scaled(&mut self.system[r * n..r * n + r + 1], w * x, &edge[..=r]);
            }
        }
        (0..n).for_each(|r| self.system[r * (n + 1)] += SLACK);
        cholesky(&mut self.system, n)
    }
}

struct Coordinates<'a>(&'a mut Interior);

impl Work for Coordinates<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.0.take_coordinates();
    }
}

struct Centre<'a>(&'a mut Interior);

impl Work for Centre<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(self) -> bool {
        self.0.centre()
    }
}
