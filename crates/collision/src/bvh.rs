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

    /// The box around everything; a point at the origin if there is nothing.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        self.nodes.first().map_or((DVec3::ZERO, DVec3::ZERO), |n| (n.bounds.low, n.bounds.high))
    }
}
