//! A tree of axis-aligned boxes over the triangles of a mesh.

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

    /// Distance from another box, m; 0 where they overlap.
    pub fn distance(&self, other: &Self) -> f64 {
        (self.low - other.high).max(other.low - self.high).max(DVec3::ZERO).length()
    }

    /// Where a ray enters the box, m from its origin; 0 from inside.
    pub fn entry(&self, origin: DVec3, direction: DVec3) -> Option<f64> {
        let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
        for k in 0..3 {
            let (low, high) = (self.low[k] - origin[k], self.high[k] - origin[k]);
            if direction[k] == 0.0 {
                if low > 0.0 || high < 0.0 {
                    return None;
                }
                continue;
            }
            let (a, b) = (low / direction[k], high / direction[k]);
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
        // The quotients are rounded; a flat box must not be missed by that.
        (enter <= leave + 1e-12 * leave.abs().max(enter.abs())).then_some(enter)
    }

    pub fn is_nan(&self) -> bool {
        self.low.is_nan() || self.high.is_nan()
    }
}

/// Items per leaf.
const LEAF: usize = 4;

#[derive(Clone, Debug)]
struct Node {
    bounds: Aabb,
    /// First of the items of a leaf, or the second child of an inner node (the first child follows its parent).
    first: u32,
    /// Number of items of a leaf; 0 for an inner node.
    count: u32,
}

/// A balanced tree split at the median of the widest axis.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bvh {
    nodes: Vec<Node>,
    items: Vec<u32>,
}

impl Bvh {
    /// Makes the tree over the boxes named by `items`; none may be NaN.
    pub fn build(&mut self, boxes: &[Aabb], items: impl Iterator<Item = u32>) {
        self.nodes.clear();
        self.items.clear();
        self.items.extend(items);
        if !self.items.is_empty() {
            self.split(boxes, 0, self.items.len());
        }
    }

    fn split(&mut self, boxes: &[Aabb], start: usize, end: usize) {
        let items = &mut self.items[start..end];
        let bounds = items.iter().skip(1).fold(boxes[items[0] as usize], |all, &i| {
            let own = &boxes[i as usize];
            Aabb { low: all.low.min(own.low), high: all.high.max(own.high) }
        });
        let node = self.nodes.len();
        self.nodes.push(Node { bounds, first: start as u32, count: (end - start) as u32 });
        if end - start <= LEAF {
            return;
        }
        let extent = bounds.high - bounds.low;
        let axis = if extent.x >= extent.y && extent.x >= extent.z {
            0
        } else if extent.y >= extent.z {
            1
        } else {
            2
        };
        let center = |i: u32| boxes[i as usize].low[axis] + boxes[i as usize].high[axis];
        let middle = items.len() / 2;
        items.select_nth_unstable_by(middle, |&i, &j| center(i).total_cmp(&center(j)).then(i.cmp(&j)));
        self.split(boxes, start, start + middle);
        let second = self.nodes.len() as u32;
        self.split(boxes, start + middle, end);
        self.nodes[node].first = second;
        self.nodes[node].count = 0;
    }

    /// Calls `visit` for every item of the leaves that overlap `query`, in the order of the tree.
    pub fn overlapping(&self, query: &Aabb, mut visit: impl FnMut(u32)) {
        let mut stack = [0_u32; 64];
        let mut depth = usize::from(!self.nodes.is_empty());
        while depth > 0 {
            depth -= 1;
            let index = stack[depth];
            let node = &self.nodes[index as usize];
            if !node.bounds.overlaps(query) {
                continue;
            }
            if node.count > 0 {
                self.items[node.first as usize..(node.first + node.count) as usize].iter().for_each(|&i| visit(i));
            } else {
                // Balanced: the depth is at most log2 of the number of items, far below the stack's 64.
                stack[depth] = index + 1;
                stack[depth + 1] = node.first;
                depth += 2;
            }
        }
    }

    /// Calls `visit` for the items of leaves that a ray meets before `limit` (m), those of nearer nodes first; `visit` gives the new limit.
    pub fn along(&self, origin: DVec3, direction: DVec3, mut limit: f64, mut visit: impl FnMut(u32) -> f64) {
        let entry = |node: u32| self.nodes[node as usize].bounds.entry(origin, direction).unwrap_or(f64::INFINITY);
        self.descend(entry, |bound| bound < f64::INFINITY, &mut limit, &mut visit);
    }

    /// Calls `visit` for the items of leaves whose box is nearer to `query` than `bound` (m), those of nearer nodes first; `visit` gives the
    /// new bound.
    pub fn nearest(&self, query: &Aabb, bound: f64, mut visit: impl FnMut(u32) -> f64) {
        let distance = |node: u32| self.nodes[node as usize].bounds.distance(query);
        // Overlapping boxes are at distance 0, and what is in them can be deeper than what is known.
        self.descend(distance, |_| true, &mut bound.max(0.0), &mut |i| visit(i).max(0.0));
    }

    /// Depth first, the child with the smaller key first; nodes with a key beyond `limit` or that are not `met` are left out.
    fn descend(
        &self,
        key: impl Fn(u32) -> f64,
        met: impl Fn(f64) -> bool,
        limit: &mut f64,
        visit: &mut impl FnMut(u32) -> f64,
    ) {
        let mut stack = [(0_u32, 0.0); 64];
        let mut depth = usize::from(!self.nodes.is_empty());
        stack[0].1 = if depth > 0 { key(0) } else { 0.0 };
        while depth > 0 {
            depth -= 1;
            let (index, own) = stack[depth];
            if own > *limit || !met(own) {
                continue;
            }
            let node = &self.nodes[index as usize];
            if node.count > 0 {
                for &i in &self.items[node.first as usize..(node.first + node.count) as usize] {
                    *limit = visit(i);
                }
                continue;
            }
            let (first, second) = ((index + 1, key(index + 1)), (node.first, key(node.first)));
            let (near, far) = if second.1 < first.1 { (second, first) } else { (first, second) };
            (stack[depth], stack[depth + 1]) = (far, near);
            depth += 2;
        }
    }

    /// The box around everything; a point at the origin if there is nothing.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        self.nodes.first().map_or((DVec3::ZERO, DVec3::ZERO), |n| (n.bounds.low, n.bounds.high))
    }
}
