//! Columns along the axis of a sweep: boxes are compared with those in the columns that they are in, so that the work grows with their number
//! and not with how many are level with each other.

use glamx::glam::DVec3;

use crate::bvh::Aabb;

/// Boxes to a column, where there is more than one: 1,000 boxes in a cube are compared in a fifth and 10,000 in an eighth of the time that one
/// column takes, as soon with 4 or 16, and as soon with half the width below (27 November 2026).
const BOXES: usize = 8;

/// How wide a column is, in mean widths of boxes: wider ones hold boxes that are far apart, narrower ones the same box many times.
const WIDTH: f64 = 2.0;

/// A box. The axes of the bounds are those after the sweep's, with the sweep's own first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub low: [f64; 3],
    pub high: [f64; 3],
    pub item: u32,
}

impl Entry {
    pub fn new(&Aabb { low, high }: &Aabb, item: u32, axis: usize) -> Self {
        let turned = |x: DVec3| std::array::from_fn(|k| x[(axis + k) % 3]);
        Self { low: turned(low), high: turned(high), item }
    }
}

/// Boxes in the columns of a grid.
#[derive(Clone, Debug, Default)]
pub(super) struct Columns {
    /// Number of columns along both axes.
    count: [usize; 2],
    /// First and last column of every box along both axes.
    ranges: Vec<[[u32; 2]; 2]>,
    /// Where the members of every column begin, and the total.
    starts: Vec<u32>,
    /// Boxes of one column after another, in the order of the sweep.
    members: Vec<u32>,
}

impl Columns {
    /// Puts boxes into columns.
    pub fn fill(&mut self, sorted: &[Entry]) {
        self.ranges.clear();
        let most = (sorted.len() / BOXES).isqrt();
        if most < 2 {
            self.count = [1, 1];
            self.ranges.resize(sorted.len(), [[0, 0]; 2]);
            self.starts.clear();
            self.starts.extend([0, sorted.len() as u32]);
            self.members.clear();
            self.members.extend(0..sorted.len() as u32);
            return;
        }
        let axes = [1, 2].map(|axis| Grid::along(axis, sorted, most));
        self.count = axes.each_ref().map(|axis| axis.count);
        self.ranges.extend(sorted.iter().map(|entry| axes.each_ref().map(|axis| axis.range(entry))));
        self.sort_in();
    }

    fn sort_in(&mut self) {
        let Self { count, ranges, starts, members } = self;
        starts.clear();
        starts.resize(count[0] * count[1] + 1, 0);
        let columns = |range: [[u32; 2]; 2]| {
            let [rows, places] = range;
            let width = count[1] as u32;
            (rows[0]..=rows[1])
                .flat_map(move |row| (places[0]..=places[1]).map(move |place| (row * width + place) as usize))
        };
        for column in ranges.iter().flat_map(|range| columns(*range)) {
            starts[column] += 1;
        }
        let mut end = 0;
        for start in starts.iter_mut() {
            end += *start;
            *start = end;
        }
        members.clear();
        members.resize(end as usize, 0);
        // From the last box on every column is filled from its end.
        for (k, range) in ranges.iter().enumerate().rev() {
            for column in columns(*range) {
                starts[column] -= 1;
                members[starts[column] as usize] = k as u32;
            }
        }
    }

    /// Calls `visit` once for every two boxes that overlap.
    pub fn overlapping(&self, sorted: &[Entry], mut visit: impl FnMut(&Entry, &Entry)) {
        for (column, ends) in self.starts.windows(2).enumerate() {
            let members = &self.members[ends[0] as usize..ends[1] as usize];
            for (k, &i) in members.iter().enumerate() {
                let a = &sorted[i as usize];
                for &j in &members[k + 1..] {
                    let b = &sorted[j as usize];
                    if b.low[0] > a.high[0] {
                        break;
                    }
                    if overlap_beside(a, b) && self.is_first(i, j, column) {
                        visit(a, b);
                    }
                }
            }
        }
    }

    /// Whether two boxes have no earlier column in common.
    fn is_first(&self, i: u32, j: u32, column: usize) -> bool {
        let (a, b) = (&self.ranges[i as usize], &self.ranges[j as usize]);
        let [row, place] = [0, 1].map(|k| a[k][0].max(b[k][0]) as usize);
        row * self.count[1] + place == column
    }
}

/// Whether boxes that are level with each other overlap along the other axes.
fn overlap_beside(a: &Entry, b: &Entry) -> bool {
    (1..3).all(|r| a.low[r] <= b.high[r] && b.low[r] <= a.high[r])
}

/// How columns lie along an axis.
struct Grid {
    axis: usize,
    low: f64,
    /// How wide a column is, and how many there are.
    width: f64,
    count: usize,
}

impl Grid {
    fn along(axis: usize, sorted: &[Entry], most: usize) -> Self {
        let (mut low, mut high, mut widths) = (f64::INFINITY, f64::NEG_INFINITY, 0.0);
        for entry in sorted {
            low = low.min(entry.low[axis]);
            high = high.max(entry.high[axis]);
            widths += entry.high[axis] - entry.low[axis];
        }
        let (span, narrowest) = (high - low, WIDTH * widths / sorted.len() as f64);
        // What is not a number makes one column.
        let count = ((span / narrowest) as usize).clamp(1, most);
        Self { axis, low, width: narrowest.max(span / count as f64), count }
    }

    /// First and last column of a box.
    fn range(&self, entry: &Entry) -> [u32; 2] {
        let place = |x: f64| (((x - self.low) / self.width) as usize).min(self.count - 1) as u32;
        let first = place(entry.low[self.axis]);
        // Rounding may turn a box around that has no width.
        [first, place(entry.high[self.axis]).max(first)]
    }
}

#[cfg(test)]
mod tests;
