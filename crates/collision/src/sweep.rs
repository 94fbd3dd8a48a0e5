//! Pairs of boxes that overlap, by sorting them along an axis and sweeping (Baraff 1992), many of them in columns along that axis.
//!
//! The order is kept from search to search, because bodies move little in a step; what is found does not depend on it.

mod columns;

use crate::bvh::Aabb;
use columns::{Columns, Entry};

/// The axis is chosen anew after so many searches.
const CHOICE: u32 = 64;

/// Insertions may move this many items per item; beyond that a sort from scratch is quicker.
const SHIFTS: usize = 8;

/// Buffers of the sweep.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sweep {
    /// Items with their boxes, in the order of the lower ends along the axis.
    sorted: Vec<Entry>,
    axis: usize,
    age: u32,
    columns: Columns,
}

impl Sweep {
    /// Forgets the order: the next items are others.
    pub fn forget(&mut self) {
        self.sorted.clear();
    }

    /// Calls `visit` for every two of `items` whose boxes overlap, in no particular order. Boxes that are not numbers overlap
    /// nothing.
    pub fn overlapping(&mut self, boxes: &[Aabb], items: &[u32], mut visit: impl FnMut(u32, u32)) {
        self.take(boxes, items);
        self.sort();
        self.columns.fill(&self.sorted);
        self.columns.overlapping(&self.sorted, |a, b| visit(a.item, b.item));
    }

    /// Takes over the boxes, in the order of the last search if that had the same items.
    fn take(&mut self, boxes: &[Aabb], items: &[u32]) {
        let known = |i: &u32| !boxes[*i as usize].is_nan();
        let complete = self.sorted.len() == items.len() && items.iter().all(known);
        if !complete || self.age >= CHOICE {
            let axis = widest_axis(boxes, items.iter().copied().filter(known));
            if !complete || axis != self.axis {
                self.sorted.clear();
                self.sorted.extend(items.iter().filter(|i| known(i)).map(|&i| Entry::new(&boxes[i as usize], i, axis)));
            }
            (self.axis, self.age) = (axis, 0);
        }
        self.age += 1;
        let axis = self.axis;
        self.sorted.iter_mut().for_each(|entry| *entry = Entry::new(&boxes[entry.item as usize], entry.item, axis));
    }

    /// Sorts by insertion, from scratch where that moves too much.
    fn sort(&mut self) {
        let mut shifts = SHIFTS * self.sorted.len();
        for k in 1..self.sorted.len() {
            let entry = self.sorted[k];
            let mut place = k;
            while place > 0 && self.sorted[place - 1].low[0] > entry.low[0] {
                self.sorted[place] = self.sorted[place - 1];
                place -= 1;
            }
            self.sorted[place] = entry;
            if k - place > shifts {
                return self.sorted.sort_unstable_by(|a, b| a.low[0].total_cmp(&b.low[0]));
            }
            shifts -= k - place;
        }
    }
}

/// The axis along which the boxes' centres are spread most.
fn widest_axis(boxes: &[Aabb], items: impl Iterator<Item = u32>) -> usize {
    let (mut count, mut sum, mut squares) = (0.0, [0.0; 3], [0.0; 3]);
    for i in items {
        let center = (boxes[i as usize].low + boxes[i as usize].high).to_array();
        count += 1.0;
        for r in 0..3 {
            sum[r] += center[r];
            squares[r] += center[r] * center[r];
        }
    }
    let spread = |r: usize| count * squares[r] - sum[r] * sum[r];
    (0..3).fold(0, |best, r| if spread(r) > spread(best) { r } else { best })
}
