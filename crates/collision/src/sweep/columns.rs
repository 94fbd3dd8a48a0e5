//! Columns along the axis of a sweep: boxes are compared with those in the columns that they are in, so that the work grows with their number
//! and not with how many are level with each other.

use glamx::glam::DVec3;

use crate::bvh::Aabb;

/// Boxes to a column, where there is more than one.
const BOXES: usize = 8;

/// How wide a column is, in mean widths of boxes: wider ones hold boxes that are far apart, narrower ones the same box many times.
const WIDTH: f64 = 2.0;

/// Boxes are in so many columns at most on average, or columns become wider.
const MOST: usize = 6;

/// A box. The axes of the bounds are those after the sweep's, with the sweep's own first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub low: [f64; 3],
    pub high: [f64; 3],
    pub item: u32,
}

impl Entry {
    /// - `boxes`: with how much smaller each is on all sides, m; nothing for what they are
    pub fn new((boxes, less): (&[Aabb], &[f64]), item: u32, axis: usize) -> Self {
        let Aabb { low, high } = boxes[item as usize];
        let less = DVec3::splat(less.get(item as usize).copied().unwrap_or(0.0));
        let turned = |x: DVec3| std::array::from_fn(|k| x[(axis + k) % 3]);
        Self { low: turned(low + less), high: turned(high - less), item }
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
        self.count = [1, 1];
        let most = (sorted.len() / BOXES).isqrt();
        if most < 2 {
            return;
        }
        let axes = [1, 2].map(|axis| Grid::along(axis, sorted, most));
        let mut scale = 1.0;
        while !self.place(sorted, &axes, scale) {
            scale *= 2.0;
        }
        self.sort_in();
    }

    /// Finds the columns of every box; whether these are not too many.
    ///
    /// - `scale`: of the columns' widths
    fn place(&mut self, sorted: &[Entry], axes: &[Grid; 2], scale: f64) -> bool {
        self.count = [0, 1].map(|k| axes[k].count(scale));
        let mut total = 0;
        self.ranges.clear();
        self.ranges.extend(sorted.iter().map(|entry| {
            let range = [0, 1].map(|k| axes[k].range(entry, self.count[k], scale));
            total += range.iter().map(|[from, to]| (to - from + 1) as usize).product::<usize>();
            range
        }));
        total <= MOST * sorted.len() || self.count == [1, 1]
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
        if self.count == [1, 1] {
            for (k, a) in sorted.iter().enumerate() {
                sorted[k + 1..].iter().take_while(|b| b.low[0] <= a.high[0]).for_each(|b| {
                    if overlap_beside(a, b) {
                        visit(a, b);
                    }
                });
            }
            return;
        }
        for row in 0..self.count[0] {
            for place in 0..self.count[1] {
                let column = row * self.count[1] + place;
                let members = &self.members[self.starts[column] as usize..self.starts[column + 1] as usize];
                for (k, &i) in members.iter().enumerate() {
                    let a = &sorted[i as usize];
                    for &j in &members[k + 1..] {
                        let b = &sorted[j as usize];
                        if b.low[0] > a.high[0] {
                            break;
                        }
                        if overlap_beside(a, b) && self.is_first(i, j, [row, place]) {
                            visit(a, b);
                        }
                    }
                }
            }
        }
    }

    /// Whether two boxes have no earlier column in common.
    fn is_first(&self, i: u32, j: u32, column: [usize; 2]) -> bool {
        let (a, b) = (&self.ranges[i as usize], &self.ranges[j as usize]);
        (0..2).all(|k| a[k][0].max(b[k][0]) as usize == column[k])
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
    /// What all boxes span, and the width of a column.
    span: f64,
    width: f64,
    most: usize,
}

impl Grid {
    fn along(axis: usize, sorted: &[Entry], most: usize) -> Self {
        let (mut low, mut high, mut widths) = (f64::INFINITY, f64::NEG_INFINITY, 0.0);
        for entry in sorted {
            low = low.min(entry.low[axis]);
            high = high.max(entry.high[axis]);
            widths += entry.high[axis] - entry.low[axis];
        }
        Self { axis, low, span: high - low, width: WIDTH * widths / sorted.len() as f64, most }
    }

    fn count(&self, scale: f64) -> usize {
        // What is not a number makes one column.
        let wanted = self.span / (self.width * scale);
        (wanted as usize).min((self.most as f64 / scale) as usize).max(1)
    }

    /// First and last column of a box among so many.
    fn range(&self, entry: &Entry, count: usize, scale: f64) -> [u32; 2] {
        let width = (self.width * scale).max(self.span / count as f64);
        let place = |x: f64| (((x - self.low) / width) as usize).min(count - 1) as u32;
        let first = place(entry.low[self.axis]);
        // Rounding may turn a box around that has no width.
        [first, place(entry.high[self.axis]).max(first)]
    }
}

#[cfg(test)]
mod tests;
