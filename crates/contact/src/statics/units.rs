//! Every friction of a problem in one form: the tangents of contacts, and friction groups.

use crate::ContactProblem;

/// Directions this close to the farthest one, relative to the target, are on its face.
const FACE: f64 = 1e-12;

/// Where a friction unit belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnitSource {
    /// The tangents of a contact.
    Contact(usize),
    /// A friction group.
    Group(usize),
}

/// One friction: two generalized directions, and the impulses that its law admits while nothing moves,
/// `{D α : α ≥ 0, eᵀα ≤ r₀ + c λ_N}`, or where the surface itself moves (`target ≠ 0`) the face of that set that pulls most along.
#[derive(Clone, Copy, Debug)]
pub struct FrictionUnit<'a> {
    /// What it is.
    pub source: UnitSource,
    /// Its directions `D`.
    pub directions: &'a [[f64; 2]],
    /// Where its directions begin among those of all contacts, or of all groups.
    pub first_direction: usize,
    /// Constant part `r₀` of the bound, N·s or N·m·s.
    pub constant: f64,
    /// The contact whose normal impulse bounds it, and the coefficient.
    pub normal: Option<(usize, f64)>,
    /// Velocity that it pulls towards, m/s or rad/s.
    pub target: [f64; 2],
}

impl FrictionUnit<'_> {
    /// Whether a direction may have an impulse while nothing moves.
    pub fn admits(&self, direction: [f64; 2]) -> bool {
        if !self.is_driven() {
            return true;
        }
        let along = |d: &[f64; 2]| d[0] * self.target[0] + d[1] * self.target[1];
        let farthest = self.directions.iter().map(along).fold(f64::NEG_INFINITY, f64::max);
        along(&direction) >= farthest - FACE * farthest.abs()
    }

    /// Whether its surface moves, so that it slides at rest and its bound is used up.
    pub fn is_driven(&self) -> bool {
        self.target != [0.0; 2]
    }

    /// The largest power that its impulses can take from a motion with this slip, for a bound of 1.
    pub fn resistance(&self, slip: [f64; 2]) -> f64 {
        let least = if self.is_driven() { f64::NEG_INFINITY } else { 0.0 };
        let admitted = self.directions.iter().filter(|d| self.admits(**d));
        admitted.map(|d| -(d[0] * slip[0] + d[1] * slip[1])).fold(least, f64::max)
    }

    /// The velocity of its two directions without its target, and a bound on what rounding makes of it.
    pub fn slip(&self, problem: &ContactProblem, motion: &[f64]) -> ([f64; 2], f64) {
        match self.source {
            UnitSource::Contact(i) => {
                let ([_, a, b], terms) = problem.jacobian.multiply_with_terms(i, motion);
                ([a, b], rounding(problem.jacobian.group(i).0.len(), terms))
            }
            UnitSource::Group(j) => {
                let rows = &problem.friction_groups.jacobian;
                let (slip, terms) = rows.multiply_with_terms(j, motion);
                (slip, rounding(rows.group(j).0.len(), terms))
            }
        }
    }

    /// Columns and entries of its two directions.
    pub fn columns(&self, problem: &ContactProblem) -> Vec<(usize, [f64; 2])> {
        match self.source {
            UnitSource::Contact(i) => {
                let (columns, entries) = problem.jacobian.group(i);
                columns.iter().zip(entries).map(|(&c, e)| (c as usize, [e[1], e[2]])).collect()
            }
            UnitSource::Group(j) => {
                let (columns, entries) = problem.friction_groups.jacobian.group(j);
                columns.iter().zip(entries).map(|(&c, e)| (c as usize, *e)).collect()
            }
        }
    }
}

/// A bound on the rounding of a sum of so many products whose sizes add up to `terms`, with some operations after it.
pub(super) fn rounding(count: usize, terms: f64) -> f64 {
    (count as f64 + 8.0) * f64::EPSILON * terms
}

/// All frictions of a problem: those of contacts that have directions, then the groups.
pub fn friction_units(problem: &ContactProblem) -> impl Iterator<Item = FrictionUnit<'_>> {
    let contacts = (0..problem.contact_count()).filter(|&i| !problem.directions_of(i).is_empty());
    let of_contacts = contacts.map(|i| FrictionUnit {
        source: UnitSource::Contact(i),
        directions: problem.directions_of(i),
        first_direction: problem.direction_offsets[i],
        constant: 0.0,
        normal: Some((i, problem.friction[i])),
        target: [0.0; 2],
    });
    let groups = &problem.friction_groups;
    let of_groups = (0..groups.len()).map(|j| FrictionUnit {
        source: UnitSource::Group(j),
        directions: groups.directions_of(j),
        first_direction: groups.direction_offsets[j],
        constant: groups.bound[j].constant(),
        normal: groups.bound[j].normal(),
        target: groups.target[j],
    });
    of_contacts.chain(of_groups)
}
