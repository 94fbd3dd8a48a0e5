//! Where a solve begins: impulses and modes of an earlier one.

use crate::ContactSolution;
use crate::projection::Mode;

/// Impulses and modes of an earlier solve, one entry per contact and per friction group of the next problem.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct WarmStart {
    /// Impulse (normal, tangent 1, tangent 2; N·s) and mode of each contact; nothing for a new one.
    pub contacts: Vec<Option<([f64; 3], Mode)>>,
    /// The same of each friction group; the first component of its impulse is not read.
    pub groups: Vec<Option<([f64; 3], Mode)>>,
    /// Impulses of the bilateral rows, N·s or N·m·s; missing ones are zero.
    pub bilateral: Vec<f64>,
    /// Whether they solve the problem at hand but for what has no entry and for corrections, as in the further solves of a time step: few modes are
    /// wrong then.
    pub nearly_solves: bool,
}

impl WarmStart {
    /// Forgets everything and keeps the memory.
    pub fn clear(&mut self) {
        self.contacts.clear();
        self.groups.clear();
        self.bilateral.clear();
        self.nearly_solves = false;
    }

    /// Adds the entry for the next contact: the earlier solution's contact `from`, or nothing for a new contact.
    pub fn push(&mut self, earlier: &ContactSolution, from: Option<usize>) {
        self.contacts.push(from.and_then(|i| Some((*earlier.impulse.get(i)?, *earlier.solver_modes.get(i)?))));
    }

    /// Adds the entry for the next friction group: the earlier solution's group `from`, or nothing for a new one.
    pub fn push_group(&mut self, earlier: &ContactSolution, from: Option<usize>) {
        let entry = |j: usize| {
            let [a, b] = *earlier.group_impulse.get(j)?;
            Some(([0.0, a, b], *earlier.solver_modes.get(earlier.impulse.len() + j)?))
        };
        self.groups.push(from.and_then(entry));
    }

    /// The whole of an earlier solution of the same problem, or of one with the same contacts, groups and rows.
    pub fn from_solution(earlier: &ContactSolution) -> Self {
        let mut start = Self::default();
        (0..earlier.impulse.len()).for_each(|i| start.push(earlier, Some(i)));
        (0..earlier.group_impulse.len()).for_each(|j| start.push_group(earlier, Some(j)));
        start.set_bilateral(&earlier.bilateral);
        start
    }

    /// The same with its impulses multiplied by a number.
    pub fn scaled(earlier: &ContactSolution, factor: f64) -> Self {
        let mut start = Self::from_solution(earlier);
        for (impulse, _) in start.contacts.iter_mut().chain(&mut start.groups).flatten() {
            impulse.iter_mut().for_each(|p| *p *= factor);
        }
        start.bilateral.iter_mut().for_each(|p| *p *= factor);
        start
    }

    /// The impulse of contact `i`, if it had one.
    pub fn impulse(&self, i: usize) -> Option<[f64; 3]> {
        self.contacts.get(i).copied().flatten().map(|(impulse, _)| impulse)
    }

    /// That of bilateral row `k`; zero if there was none.
    pub fn bilateral_impulse(&self, k: usize) -> f64 {
        self.bilateral.get(k).copied().unwrap_or(0.0)
    }

    /// Carries the bilateral impulses over.
    pub fn set_bilateral(&mut self, impulses: &[f64]) {
        self.bilateral.clear();
        self.bilateral.extend_from_slice(impulses);
    }
}
