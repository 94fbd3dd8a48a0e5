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

mod centre;

use signorini_contact::projection::Cones;
use signorini_contact::recovery::recover_into;
use signorini_contact::{ContactProblem, ContactSolution};

use centre::{Centre, Edge, Group, Owner, Set};

use crate::matrix::{Rows, Work, add_scaled, dot, wide};
use crate::mode::Scales;

/// A velocity is zero up to this part of the scale, or ten times the residual of the solution.
const STILL: f64 = 1e-9;
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
    /// What contacts (three rows each) and bilateral rows give per unit, and an orthonormal basis of that.
    given: Rows,
    basis: Rows,
    whole: Vec<f64>,
    set: Set,
    cones: Cones,
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
        if self.set.size == 0 || self.set.size > LARGEST {
            return false;
        }
        self.take_given(problem);
        wide(Coordinates(self));
        self.take_edges(problem, scales, solution);
        if self.set.edges.is_empty() || !self.set.scale_by_momentum() || !wide(Centre(&mut self.set)) {
            return false;
        }
        let contacts = &self.contacts;
        for &i in contacts {
            solution.impulse[i] = [0.0; 3];
        }
        for (Edge { owner, unit, .. }, x) in self.set.edges.iter().zip(&self.set.x) {
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
        self.set.size = 0;
        place.clear();
        place.extend(members.iter().map(|&is_member| {
            self.set.size += usize::from(is_member);
            is_member.then(|| self.set.size - 1)
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
        self.given.clear(self.set.size);
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
        let Self { given, basis, set, .. } = self;
        let Set { size, coordinates, .. } = set;
        if given.len() >= *size {
            coordinates.width = given.width;
            coordinates.data.clone_from(&given.data);
            return;
        }
        basis.clear(*size);
        for row in given.data.chunks_exact(*size) {
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
                basis.data.truncate(last * *size);
            }
        }
        coordinates.clear(basis.len());
        for row in given.data.chunks_exact(*size) {
            let own = coordinates.push();
            own.iter_mut().enumerate().for_each(|(j, x)| *x = dot(row, basis.row(j)));
        }
        *size = basis.len();
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
        let Self { set, contacts, bilateral, .. } = self;
        set.clear();
        let Set { edges, groups, target, coordinates, .. } = set;
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
                edges.push(Edge { owner: Owner::Contact(i, edge), unit: 1.0, shares: edge });
            };
            if directions.is_empty() || friction == 0.0 {
                add([1.0, 0.0, 0.0]);
            }
            for d in
                directions.iter().filter(|d| friction > 0.0 && (sticks || scales.velocity(speed - along(d)) <= still))
            {
                add([1.0, friction * d[0], friction * d[1]]);
            }
            groups.push(Group { row: first, rows: 3, end: edges.len() });
        }
        for (at, &k) in bilateral.iter().enumerate() {
            let row = 3 * contacts.len() + at;
            add_scaled(target, solution.bilateral[k], coordinates.row(row));
            edges.push(Edge { owner: Owner::Bilateral(k), unit: 1.0, shares: [1.0, 0.0, 0.0] });
            groups.push(Group { row, rows: 1, end: edges.len() });
        }
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
