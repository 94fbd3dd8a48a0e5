//! Overlapping pairs of axis-aligned boxes by sort and sweep (Baraff 1992).

use glamx::glam::DVec3;

/// An axis-aligned box, m.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Aabb {
    pub low: DVec3,
    pub high: DVec3,
}

impl Aabb {
    pub fn overlaps(&self, other: &Self) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }

    pub fn is_nan(&self) -> bool {
        self.low.is_nan() || self.high.is_nan()
    }
}

/// Buffers of the sweep.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sweep {
    order: Vec<(f64, u32)>,
}

impl Sweep {
    /// Calls `visit(i, j)` for every overlapping pair of the boxes that `take` accepts, in no particular order. Boxes
    /// that are not numbers overlap nothing.
    pub fn pairs(&mut self, boxes: &[Aabb], take: impl Fn(usize) -> bool, mut visit: impl FnMut(u32, u32)) {
        let axis = widest_axis(boxes, &take);
        self.order.clear();
        let taken = (0..boxes.len()).filter(|&i| take(i) && !boxes[i].is_nan());
        self.order.extend(taken.map(|i| (boxes[i].low[axis], i as u32)));
        self.order.sort_unstable_by(|p, q| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)));
        for (k, &(_, i)) in self.order.iter().enumerate() {
            let own = &boxes[i as usize];
            let end = own.high[axis];
            for &(start, j) in &self.order[k + 1..] {
                if start > end {
                    break;
                }
                if own.overlaps(&boxes[j as usize]) {
                    visit(i, j);
                }
            }
        }
    }
}

/// The axis along which the boxes' centres spread most, compared with the boxes' lengths.
fn widest_axis(boxes: &[Aabb], take: &impl Fn(usize) -> bool) -> usize {
    let (mut count, mut sum, mut squares, mut lengths) = (0.0, DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
    for b in boxes.iter().enumerate().filter(|(i, b)| take(*i) && b.low.is_finite() && b.high.is_finite()) {
        let center = 0.5 * (b.1.low + b.1.high);
        count += 1.0;
        sum += center;
        squares += center * center;
        lengths += b.1.high - b.1.low;
    }
    let spread = (squares * count - sum * sum).max(DVec3::ZERO) / (lengths * lengths).max(DVec3::splat(f64::MIN_POSITIVE));
    if spread.x >= spread.y && spread.x >= spread.z {
        0
    } else if spread.y >= spread.z {
        1
    } else {
        2
    }
}
