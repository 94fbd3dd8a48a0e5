//! Contacts of robots whose Delassus scales are known from the problem before.
//!
//! A scale costs half a solve with each block of the mass matrix that a contact touches: in the block of a robot more than the
//! rest of a solve from a start that holds. Where a robot rests, its block and the rows of its contacts have the bits of the step before.

use super::island::Island;
use signorini_contact::ContactProblem;
use signorini_contact::lists::same_bits;
use signorini_contact::scales::FREE_ROWS;

/// Numbers that are compared at a time: rows that differ mostly do so at once.
const COMPARED: usize = 32;

/// What the scales of an island's contacts were computed with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Factor {
    /// Blocks of free bodies, where a comparison saves nothing.
    Free,
    /// Another one than now.
    Other,
    /// That of now.
    Same,
}

/// The factor of the mass matrix and the Jacobian that the scales were computed with, as far as islands of robots are concerned.
#[derive(Clone, Debug, Default)]
pub(super) struct KnownRows {
    /// Whether there is any.
    robots: bool,
    islands: Vec<Factor>,
    factor: Vec<f64>,
    entries: Vec<[f64; 3]>,
}

impl KnownRows {
    /// Forgets everything, for a problem of another structure.
    pub fn forget(&mut self, problem: &ContactProblem) {
        self.robots = problem.mass.blocks().iter().any(|block| block.size > FREE_ROWS);
        self.factor.clear();
        self.factor.resize(problem.mass.data().len(), f64::NAN);
        self.entries.clear();
        self.entries.resize(problem.jacobian.pattern().1.len(), [f64::NAN; 3]);
    }

    /// Compares the factor with that of the problem before.
    pub fn begin(&mut self, problem: &ContactProblem, islands: &[Island]) {
        self.islands.clear();
        if !self.robots {
            return;
        }
        for island in islands {
            let blocks = || island.blocks.iter().map(|&b| b as usize);
            let mut known = Factor::Free;
            if blocks().any(|b| problem.mass.blocks()[b].size > FREE_ROWS) {
                known = Factor::Same;
                for block in blocks() {
                    let now = problem.mass_factor.block_data(block);
                    let own = &mut self.factor[problem.mass.blocks()[block].offset..][..now.len()];
                    if !are_same(own, now) {
                        own.copy_from_slice(now);
                        known = Factor::Other;
                    }
                }
            }
            self.islands.push(known);
        }
    }

    /// Whether contact `i` of an island has the scale that it had; its rows are taken over where they differ.
    #[inline]
    pub fn has(&mut self, problem: &ContactProblem, island: usize, i: usize) -> bool {
        self.robots && self.islands[island] != Factor::Free && self.compare(problem, island, i)
    }

    fn compare(&mut self, problem: &ContactProblem, island: usize, i: usize) -> bool {
        let now = problem.jacobian.group(i).1;
        let own = &mut self.entries[problem.jacobian.pattern().0[i]..][..now.len()];
        if are_same(own.as_flattened(), now.as_flattened()) {
            return self.islands[island] == Factor::Same;
        }
        own.copy_from_slice(now);
        false
    }
}

fn are_same(a: &[f64], b: &[f64]) -> bool {
    a.chunks(COMPARED).zip(b.chunks(COMPARED)).all(|(a, b)| same_bits(a, b))
}
