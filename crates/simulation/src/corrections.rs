//! The part θ of overlaps and violations that a step removes: as much as the laws permit.
//!
//! With every negative gap taken as zero and every constraint at the rate zero, a step's problem has a solution (formulation §4: a
//! direction of impulses along which Lemke's method could leave has no effect on any velocity, and no gap then speaks against
//! it). With gaps `φ_θ = max(φ, θφ)` and violations `θΘ` that is the case θ = 0, and θ = 1 is all that is asked for. Where θ = 1 has no
//! solution that is found soon, the largest θ is looked for, in the islands that lack one alone.

use signorini_contact::{ContactProblem, ContactSolution};

use crate::build::{Impact, is_impact};
use crate::report::{Kept, KeptRow};

/// What a step is asked to correct, and the part of it that the problem at hand has.
#[derive(Clone, Debug, Default)]
pub(crate) struct Corrections {
    /// Gaps, m, and violations of constraints, m or rad, as they are asked for.
    gap: Vec<f64>,
    violation: Vec<f64>,
    pub theta: f64,
    /// Contacts, then constraints' rows, that θ applies to; the others are asked for in full.
    is_limited: Vec<bool>,
    /// Whether it applies to all of them because their energy is bounded.
    by_energy: bool,
    /// Rows of constraints that no degree of freedom moves, and whether nothing of them is asked for.
    immovable: Vec<usize>,
    leaves_immovable: bool,
}

impl Corrections {
    /// Takes over what a problem asks for that was built anew.
    ///
    /// - `constraints`: number of its bilateral rows that are the model's; those after them are no violations
    pub fn ask(&mut self, problem: &ContactProblem, constraints: usize) {
        self.theta = 1.0;
        self.limit_nothing();
        self.gap.clone_from(&problem.gap);
        self.violation.clear();
        self.violation.extend_from_slice(&problem.bilateral_violation[..constraints]);
        let is_immovable = |k: &usize| problem.bilateral_jacobian.group(*k).0.is_empty();
        self.immovable.clear();
        self.immovable.extend((0..self.violation.len()).filter(|k| self.violation[*k] != 0.0).filter(is_immovable));
        self.leaves_immovable = false;
    }

    /// Asks for nothing of the rows that no degree of freedom moves.
    pub fn leave_immovable(&mut self, problem: &mut ContactProblem) {
        self.leaves_immovable = true;
        self.immovable.iter().for_each(|&k| problem.bilateral_violation[k] = 0.0);
    }

    /// The same where contacts were added since: those that were there are asked for in full again.
    pub fn ask_again(&mut self, problem: &mut ContactProblem) {
        self.set(1.0, problem);
        self.limit_nothing();
        self.gap.extend_from_slice(&problem.gap[self.gap.len()..]);
    }

    /// Whether there is anything to correct.
    pub fn any(&self) -> bool {
        self.gap.iter().any(|phi| *phi < 0.0) || self.violation.iter().any(|theta| *theta != 0.0)
    }

    /// Limits contact `i` where `contacts(i)`, and row `k` of the constraints where `rows(k)`, beside those that are limited already; whether
    /// that limits any correction.
    pub fn limit(&mut self, contacts: impl Fn(usize) -> bool, rows: impl Fn(usize) -> bool) -> bool {
        self.is_limited.resize(self.gap.len() + self.violation.len(), false);
        let (of_contacts, of_rows) = self.is_limited.split_at_mut(self.gap.len());
        of_contacts.iter_mut().enumerate().for_each(|(i, limited)| *limited |= contacts(i));
        of_rows.iter_mut().enumerate().for_each(|(k, limited)| *limited |= rows(k));
        self.limited().next().is_some()
    }

    /// Limits all, because their energy is bounded; the rebound of an impact is no correction.
    pub fn limit_all(&mut self, impacts: &[Impact]) {
        self.limit(|i| !is_impact(impacts, i), |_| true);
        self.by_energy = true;
    }

    /// Whether all are limited because their energy is bounded.
    pub fn limits_all(&self) -> bool {
        self.by_energy
    }

    /// Limits nothing.
    pub fn limit_nothing(&mut self) {
        self.is_limited.clear();
        self.by_energy = false;
    }

    /// Gives the problem this part of the limited corrections, and the others in full.
    pub fn set(&mut self, theta: f64, problem: &mut ContactProblem) {
        self.theta = theta;
        problem.gap.iter_mut().zip(&self.gap).for_each(|(phi, asked)| *phi = *asked);
        problem.bilateral_violation.iter_mut().zip(&self.violation).for_each(|(out, asked)| *out = *asked);
        for (row, _) in self.limited() {
            match row {
                KeptRow::Contact(i) => problem.gap[i] *= theta,
                KeptRow::Bilateral(k) => problem.bilateral_violation[k] *= theta,
            }
        }
        if self.leaves_immovable {
            self.leave_immovable(problem);
        }
    }

    /// Gives the problem no corrections; the rebound of an impact is none. What θ applies to stays what it is.
    pub fn ask_nothing(&self, impacts: &[Impact], problem: &mut ContactProblem) {
        for (_, phi) in problem.gap.iter_mut().enumerate().filter(|(i, _)| !is_impact(impacts, *i)) {
            *phi = phi.max(0.0);
        }
        problem.bilateral_violation[..self.violation.len()].fill(0.0);
    }

    /// The part of what is asked for that the problem at hand has: 1 where θ applies to nothing.
    pub fn part(&self) -> f64 {
        if self.limited().next().is_some() { self.theta } else { 1.0 }
    }

    /// What is asked for of a row, m or rad.
    pub fn asked(&self, row: KeptRow) -> f64 {
        match row {
            KeptRow::Contact(i) => self.gap[i],
            KeptRow::Bilateral(k) => self.violation[k],
        }
    }

    /// Whether θ applies to a row, where that has something to correct.
    pub fn limits(&self, row: KeptRow) -> bool {
        self.is_limited.get(self.place(row)) == Some(&true)
    }

    fn place(&self, row: KeptRow) -> usize {
        match row {
            KeptRow::Contact(i) => i,
            KeptRow::Bilateral(k) => self.gap.len() + k,
        }
    }

    /// Asks for all of a row again, or not.
    pub fn release(&mut self, row: KeptRow, is_released: bool) {
        let at = self.place(row);
        self.is_limited[at] = !is_released;
    }

    /// The limited rows that have something to correct, with its size.
    fn limited(&self) -> impl Iterator<Item = (KeptRow, f64)> + '_ {
        let contacts = self.gap.iter().enumerate().filter(|(_, asked)| **asked < 0.0);
        let contacts = contacts.map(|(i, asked)| (i, KeptRow::Contact(i), -asked));
        let rows = self.violation.iter().enumerate().filter(|(_, asked)| **asked != 0.0);
        let rows = rows.map(|(k, asked)| (self.gap.len() + k, KeptRow::Bilateral(k), asked.abs()));
        let is_limited = |at: usize| self.is_limited.get(at) == Some(&true);
        contacts.chain(rows).filter(move |(at, ..)| is_limited(*at)).map(|(_, row, size)| (row, size))
    }

    /// Asks for nothing of the listed rows that no degree of freedom moves, as a step did.
    pub fn leave_listed(&mut self, is_listed: impl Fn(usize) -> bool, problem: &mut ContactProblem) {
        if self.immovable.iter().any(|&k| is_listed(k)) {
            self.leave_immovable(problem);
        }
    }

    /// The rows that θ applies to.
    #[cfg(test)]
    pub fn limited_rows(&self) -> impl Iterator<Item = KeptRow> + '_ {
        self.limited().map(|(row, _)| row)
    }

    /// The rows that are not asked for in full, with what is left of them.
    pub fn kept(&self) -> impl Iterator<Item = Kept> + '_ {
        let left = 1.0 - self.theta;
        let limited =
            self.limited().filter(move |_| left > 0.0).map(move |(row, size)| Kept { row, size: left * size });
        let immovable = self.immovable.iter().filter(|_| self.leaves_immovable);
        limited.chain(immovable.map(|&k| Kept { row: KeptRow::Bilateral(k), size: self.violation[k].abs() }))
    }
}

/// Work of the impulses along the corrections, `Σ λ_N (−φ)/Δt + Σ λ_B (−Θ)/Δt`, J: the kinetic energy after a step is at most that of the
/// free motion and this, as friction and contacts without overlap take energy or none, and what it lifts is in it.
///
/// - `constraints`: number of bilateral rows that are the model's
pub(crate) fn energy(
    problem: &ContactProblem,
    solution: &ContactSolution,
    impacts: &[Impact],
    constraints: usize,
) -> f64 {
    let mut sum = 0.0;
    for (i, (phi, lambda)) in problem.gap.iter().zip(&solution.lambda_n).enumerate() {
        if *phi < 0.0 && *lambda > 0.0 && !is_impact(impacts, i) {
            sum -= lambda * phi;
        }
    }
    for (theta, lambda) in problem.bilateral_violation[..constraints].iter().zip(&solution.bilateral) {
        sum -= lambda * theta;
    }
    sum / problem.timestep
}
