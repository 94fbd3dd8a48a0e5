//! A bounding-volume hierarchy, split by the surface-area heuristic in bins (Wald 2007).

use signorini_multibody::glam::Vec3;

/// An axis-aligned box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    pub low: Vec3,
    pub high: Vec3,
}

impl Bounds {
    pub const EMPTY: Self = Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY };

    pub fn around(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Self { low: b.low.min(p), high: b.high.max(p) })
    }

    pub fn union(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    pub fn center(&self) -> Vec3 {
        0.5 * (self.low + self.high)
    }

    fn area(&self) -> f32 {
        let d = (self.high - self.low).max(Vec3::ZERO);
        d.x * d.y + d.y * d.z + d.z * d.x
    }
}

/// A node: with `count` leaves from `first` on, or, where it is 0, the children `first` and `first + 1`.
#[derive(Clone, Copy, Debug)]
struct Node {
    low: Vec3,
    first: u32,
    high: Vec3,
    count: u32,
}

/// Boxes in a tree.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tree {
    nodes: Vec<Node>,
    /// The boxes in the order of the leaves.
    pub order: Vec<u32>,
}

/// Most boxes in a leaf, and the number of bins: from Wald's measurements.
const LEAF: usize = 4;
const BINS: usize = 16;
/// Deepest tree; where halving by cost goes on longer, halving by number ends it.
const DEEPEST: usize = 60;

/// A ray in single precision with what its tests against boxes share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BoxRay {
    pub origin: Vec3,
    pub inverse: Vec3,
}

impl BoxRay {
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        Self { origin, inverse: direction.recip() }
    }

    /// Where the ray enters a box, if it does before `limit`. A ray in the plane of a face divides 0 by 0, which min and max pass over.
    fn enter(&self, low: Vec3, high: Vec3, limit: f32) -> Option<f32> {
        let (a, b) = ((low - self.origin) * self.inverse, (high - self.origin) * self.inverse);
        let near = a.x.min(b.x).max(a.y.min(b.y)).max(a.z.min(b.z)).max(0.0);
        let far = a.x.max(b.x).min(a.y.max(b.y)).min(a.z.max(b.z)).min(limit);
        // Roundings of the three quotients must not open a gap between two boxes.
        (near <= far * (1.0 + 4.0 * f32::EPSILON)).then_some(near)
    }
}

impl Tree {
    pub fn new(boxes: &[Bounds]) -> Self {
        let mut tree = Self { nodes: Vec::new(), order: (0..boxes.len() as u32).collect() };
        if boxes.is_empty() {
            return tree;
        }
        let mut order = std::mem::take(&mut tree.order);
        tree.nodes.push(Node { low: Vec3::ZERO, high: Vec3::ZERO, first: 0, count: boxes.len() as u32 });
        let mut open = vec![(0_usize, 0)];
        while let Some((index, depth)) = open.pop() {
            let node = tree.nodes[index];
            let (first, count) = (node.first as usize, node.count as usize);
            let own = &mut order[first..first + count];
            let bounds = own.iter().fold(Bounds::EMPTY, |b, &i| b.union(boxes[i as usize]));
            (tree.nodes[index].low, tree.nodes[index].high) = (bounds.low, bounds.high);
            let Some(left) = split(own, boxes, &bounds, depth) else { continue };
            let children = tree.nodes.len();
            (tree.nodes[index].first, tree.nodes[index].count) = (children as u32, 0);
            for (first, count) in [(first, left), (first + left, count - left)] {
                open.push((tree.nodes.len(), depth + 1));
                tree.nodes.push(Node { low: Vec3::ZERO, high: Vec3::ZERO, first: first as u32, count: count as u32 });
            }
        }
        tree.order = order;
        tree
    }

    /// Visits the leaves along a ray, near ones first, until a visit says that it is enough.
    ///
    /// - `limit`: what is farther is passed over; visits may bring it nearer
    /// - `visit`: gets the place in [`order`](Self::order); true ends the walk
    pub fn along(&self, ray: &BoxRay, limit: &mut f32, mut visit: impl FnMut(usize, &mut f32) -> bool) {
        if self.nodes.is_empty() {
            return;
        }
        let mut stack = [(0_u32, 0.0_f32); DEEPEST + 4];
        let mut size = 1;
        while size > 0 {
            size -= 1;
            let (index, near) = stack[size];
            if near > *limit {
                continue;
            }
            let node = &self.nodes[index as usize];
            if index == 0 && ray.enter(node.low, node.high, *limit).is_none() {
                return;
            }
            if node.count > 0 {
                for place in node.first..node.first + node.count {
                    if visit(place as usize, limit) {
                        return;
                    }
                }
                continue;
            }
            let child = |k: u32| {
                let child = &self.nodes[(node.first + k) as usize];
                ray.enter(child.low, child.high, *limit).map(|near| (node.first + k, near))
            };
            let (mut a, mut b) = (child(0), child(1));
            if let (Some(x), Some(y)) = (a, b)
                && x.1 < y.1
            {
                (a, b) = (b, a);
            }
            for next in [a, b].into_iter().flatten() {
                stack[size] = next;
                size += 1;
            }
        }
    }
}

/// Sorts the boxes into two groups and gives the size of the first; nothing where they stay together.
fn split(own: &mut [u32], boxes: &[Bounds], bounds: &Bounds, depth: usize) -> Option<usize> {
    if own.len() <= LEAF {
        return None;
    }
    let centers = Bounds::around(own.iter().map(|&i| boxes[i as usize].center()));
    let extent = centers.high - centers.low;
    let half = own.len() / 2;
    // Everything in one place, or numbers that are none.
    let widest = extent.max_element();
    if !(widest.is_finite() && widest > 0.0) {
        return (own.len() > 16 * LEAF).then_some(half);
    }
    if depth + 1 + own.len().ilog2() as usize >= DEEPEST {
        let axis = if extent.x == widest { 0 } else { 1 + usize::from(extent.y != widest) };
        own.sort_unstable_by(|&a, &b| boxes[a as usize].center()[axis].total_cmp(&boxes[b as usize].center()[axis]));
        return Some(half);
    }
    let mut best = (f32::INFINITY, 0, 0);
    for axis in 0..3 {
        if extent[axis] > 0.0 {
            let (cost, bin) = best_bin(own, boxes, &centers, axis);
            if cost < best.0 {
                best = (cost, axis, bin);
            }
        }
    }
    let (cost, axis, bin) = best;
    if cost >= own.len() as f32 * bounds.area() && own.len() <= 2 * LEAF {
        return None;
    }
    let mut left = 0;
    for k in 0..own.len() {
        if bin_of(&boxes[own[k] as usize], &centers, axis) <= bin {
            own.swap(left, k);
            left += 1;
        }
    }
    Some(if left == 0 || left == own.len() { half } else { left })
}

fn bin_of(bounds: &Bounds, centers: &Bounds, axis: usize) -> usize {
    let place = (bounds.center()[axis] - centers.low[axis]) / (centers.high[axis] - centers.low[axis]);
    ((place * BINS as f32) as usize).min(BINS - 1)
}

/// The last bin on the left side of the cheapest split along an axis, with its cost.
fn best_bin(own: &[u32], boxes: &[Bounds], centers: &Bounds, axis: usize) -> (f32, usize) {
    let mut bins = [(Bounds::EMPTY, 0_usize); BINS];
    for &i in own {
        let bin = &mut bins[bin_of(&boxes[i as usize], centers, axis)];
        *bin = (bin.0.union(boxes[i as usize]), bin.1 + 1);
    }
    let mut right = [0.0; BINS];
    let (mut bounds, mut count) = (Bounds::EMPTY, 0);
    for k in (1..BINS).rev() {
        (bounds, count) = (bounds.union(bins[k].0), count + bins[k].1);
        right[k - 1] = if count > 0 { bounds.area() * count as f32 } else { 0.0 };
    }
    let (mut bounds, mut count, mut best) = (Bounds::EMPTY, 0, (f32::INFINITY, 0));
    for k in 0..BINS - 1 {
        (bounds, count) = (bounds.union(bins[k].0), count + bins[k].1);
        let cost = if count > 0 { bounds.area() * count as f32 } else { 0.0 } + right[k];
        if count > 0 && count < own.len() && cost < best.0 {
            best = (cost, k);
        }
    }
    best
}
