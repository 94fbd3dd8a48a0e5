//! What eliminating a graph's nodes one after the other touches.

use super::graph::Graph;

/// An order of elimination of a graph's nodes, the neighbours each has when it is eliminated, and the cost.
#[derive(Clone, Debug, Default)]
pub(crate) struct Elimination {
    /// Nodes in the order of their elimination.
    pub order: Vec<u32>,
    /// Where each eliminated node's neighbours begin in `neighbours`, by position in the order, and the total.
    pub offsets: Vec<usize>,
    /// The neighbours each node has when it is eliminated, as nodes.
    pub neighbours: Vec<u32>,
    /// Sum of the squares of the numbers of neighbours: products of two blocks in one triangle of the factorisation.
    pub cost: u64,
}

impl Elimination {
    /// Forgets everything.
    pub fn clear(&mut self) {
        self.order.clear();
        self.neighbours.clear();
        self.offsets.clear();
        self.offsets.push(0);
        self.cost = 0;
    }

    /// Appends the elimination of a node.
    pub fn push(&mut self, node: u32, neighbours: impl Iterator<Item = u32>) {
        let before = self.neighbours.len();
        self.order.push(node);
        self.neighbours.extend(neighbours);
        self.offsets.push(self.neighbours.len());
        self.cost += ((self.neighbours.len() - before) as u64).pow(2);
    }
}

const NONE: u32 = u32::MAX;

/// Finds the neighbours for a given order.
///
/// The neighbours of a node are those it has in the graph and those of its children in the elimination tree, without itself and
/// without those that went before (Liu 1990, "The role of elimination trees in sparse factorization"). A node's parent is the
/// first of its neighbours to be eliminated.
#[derive(Clone, Debug, Default)]
pub(crate) struct GivenOrder {
    /// The last of each position's children that is known, and for each position the child of the same parent known before.
    last_child: Vec<u32>,
    previous_sibling: Vec<u32>,
    /// The last position that has each position as a neighbour.
    seen_by: Vec<u32>,
}

impl GivenOrder {
    /// Eliminates the nodes of a graph in the order of `nodes`; `position` is its inverse.
    pub fn eliminate(&mut self, graph: &Graph, nodes: &[u32], position: &[u32], out: &mut Elimination) {
        for list in [&mut self.last_child, &mut self.previous_sibling, &mut self.seen_by] {
            list.clear();
            list.resize(nodes.len(), NONE);
        }
        out.clear();
        out.order.extend_from_slice(nodes);
        for (k, &node) in nodes.iter().enumerate() {
            let (k, begin) = (k as u32, out.neighbours.len());
            self.seen_by[k as usize] = k;
            for &u in graph.neighbours(node as usize) {
                self.see(position[u as usize], k, &mut out.neighbours);
            }
            let mut child = self.last_child[k as usize];
            while child != NONE {
                for entry in out.offsets[child as usize]..out.offsets[child as usize + 1] {
                    let row = out.neighbours[entry];
                    self.see(row, k, &mut out.neighbours);
                }
                child = self.previous_sibling[child as usize];
            }
            let own = &out.neighbours[begin..];
            out.cost += (own.len() as u64).pow(2);
            out.offsets.push(begin + own.len());
            if let Some(&parent) = own.iter().min() {
                self.previous_sibling[k as usize] = self.last_child[parent as usize];
                self.last_child[parent as usize] = k;
            }
        }
        out.neighbours.iter_mut().for_each(|u| *u = nodes[*u as usize]);
    }

    /// Adds a row to those of position `k` unless it is there or lies before.
    #[inline]
    fn see(&mut self, row: u32, k: u32, rows: &mut Vec<u32>) {
        if row > k && self.seen_by[row as usize] != k {
            self.seen_by[row as usize] = k;
            rows.push(row);
        }
    }
}
