//! Pairs of boxes that overlap, from a list that serves many searches (Verlet 1967, §2): it has the pairs that overlap when every box is
//! larger by a skin, and while each stays within its larger one there are no others.
//!
//! Boxes are followed about the mean of their centres, so that what falls together stays where it is. What is found does not depend on the
//! list: its pairs are compared by the boxes at hand.

use glamx::glam::DVec3;

use crate::bvh::Aabb;
use crate::partners::{geoms_of, pair_of};
use crate::sweep::Sweep;

/// How thick a skin is, as a share of a geom's size. Seven robots, planks, dominoes and 1,000 particles take as long with 0.1 to 0.4 (1.01 of the time
/// with this), and so do a drum, a bin and a pile of 300 boxes; of what is small and quick a list serves more searches (28 November 2026).
const SKIN: f64 = 0.5;

/// Skins are larger by this share of all coordinates when the list is made: more than rounding when boxes are followed.
const DOUBT: f64 = 1e-12;

/// A list with the boxes for which it holds.
#[derive(Clone, Debug, Default)]
pub(crate) struct Neighbours {
    /// Both items of each pair, ascending.
    pairs: Vec<u64>,
    /// The larger boxes about the mean of centres, in the order of the items; empty where there is no list.
    within: Vec<Aabb>,
    /// The boxes at hand, by item.
    boxes: Vec<Aabb>,
    /// The larger boxes of the list where they were, and larger by rounding, by item.
    larger: Vec<Aabb>,
    sweep: Sweep,
}

impl Neighbours {
    /// Forgets the list: other pairs are allowed, or the items are others.
    pub fn forget(&mut self) {
        self.sweep.forget();
        self.within.clear();
        self.pairs.clear();
    }

    /// Calls `visit` for every two of `items` that are allowed and whose boxes overlap, those with the smaller items first. Boxes that are not
    /// numbers overlap nothing.
    ///
    /// - `boxes`: around all that the items can reach, and by how much smaller they are on all sides for what shares a common motion, m; nothing where
    ///   nothing is known of one
    /// - `size`: of an item, m
    /// - `allowed`: the same answers as when it was asked last, or the list is to be [forgotten](Self::forget)
    pub fn overlapping(
        &mut self,
        boxes: (&[Aabb], &[f64]),
        items: &[u32],
        size: impl Fn(u32) -> f64,
        allowed: impl Fn(u32, u32) -> bool,
        mut visit: impl FnMut(u32, u32),
    ) {
        let middle = self.take(boxes, items);
        if !self.holds(items, middle) {
            self.renew(items, middle, size, allowed);
        }
        for (i, j) in self.pairs.iter().map(|pair| geoms_of(*pair)) {
            if self.boxes[i].overlaps(&self.boxes[j]) {
                visit(i as u32, j as u32);
            }
        }
    }

    /// Takes over the boxes; the mean of their centres, if all are numbers.
    fn take(&mut self, (whole, less): (&[Aabb], &[f64]), items: &[u32]) -> DVec3 {
        self.boxes.resize(whole.len(), Aabb { low: DVec3::NAN, high: DVec3::NAN });
        let mut sum = DVec3::ZERO;
        for &i in items {
            let Aabb { low, high } = whole[i as usize];
            let less = DVec3::splat(less.get(i as usize).copied().unwrap_or(0.0));
            sum += low + high;
            self.boxes[i as usize] = Aabb { low: low + less, high: high - less };
        }
        let middle = sum * (0.5 / items.len() as f64);
        if middle.is_finite() { middle } else { DVec3::ZERO }
    }

    /// Whether all boxes are within those of the list.
    fn holds(&self, items: &[u32], middle: DVec3) -> bool {
        let is_within = |(i, outer): (&u32, &Aabb)| {
            let Aabb { low, high } = self.boxes[*i as usize];
            (low - middle).cmpge(outer.low).all() && (high - middle).cmple(outer.high).all()
        };
        self.within.len() == items.len() && items.iter().zip(&self.within).all(is_within)
    }

    /// Makes the list anew.
    fn renew(&mut self, items: &[u32], middle: DVec3, size: impl Fn(u32) -> f64, allowed: impl Fn(u32, u32) -> bool) {
        let Self { pairs, within, boxes: at_hand, larger, sweep } = self;
        within.clear();
        larger.clone_from(at_hand);
        for &i in items {
            let k = i as usize;
            let skin = SKIN * size(i);
            let Aabb { low, high } = at_hand[k];
            within.push(Aabb { low: low - middle - skin, high: high - middle + skin });
            let more = skin + DOUBT * low.abs().max(high.abs()).max(middle.abs()).max_element();
            larger[k] = Aabb { low: low - more, high: high + more };
        }
        pairs.clear();
        sweep.overlapping(larger, items, |i, j| {
            if allowed(i, j) {
                pairs.push(pair_of(i, j));
            }
        });
        pairs.sort_unstable();
    }
}

#[cfg(test)]
mod tests;
