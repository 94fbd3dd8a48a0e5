//! Pairs that were apart in the last search, with a direction that showed it.
//!
//! What separated two shapes a step ago mostly does so again (Baraff 1992, §3): two supports then tell as much as a search. The direction
//! is a hint and no more. It is asked for somewhat more than the margin, so that whatever it lets skip a search would not have found.

use glamx::glam::DVec3;

use crate::convex::{Placed, separation_along};

/// Beyond the margin by this share of the sizes, no search takes the shapes for nearer.
const DOUBT: f64 = 1e-6;

/// Directions of pairs, looked up and renewed in the order of the pairs.
#[derive(Clone, Debug, Default)]
pub(crate) struct Apart {
    known: Vec<(u64, DVec3)>,
    renewed: Vec<(u64, DVec3)>,
    next: usize,
}

impl Apart {
    /// Begins a search.
    pub fn begin(&mut self) {
        std::mem::swap(&mut self.known, &mut self.renewed);
        self.renewed.clear();
        self.next = 0;
    }

    /// The direction of a pair that comes after those asked for in this search.
    pub fn direction(&mut self, pair: u64) -> Option<DVec3> {
        while self.known.get(self.next).is_some_and(|known| known.0 < pair) {
            self.next += 1;
        }
        self.known.get(self.next).filter(|known| known.0 == pair).map(|known| known.1)
    }

    /// Keeps a direction for the next search.
    pub fn keep(&mut self, pair: u64, direction: DVec3) {
        self.renewed.push((pair, direction));
    }
}

/// Whether a direction shows that two shapes are farther apart than `margin` (m).
pub(crate) fn shows_apart(direction: DVec3, a: &Placed, b: &Placed, margin: f64) -> bool {
    separation_along(a, b, direction) > margin + DOUBT * (a.size + b.size)
}
