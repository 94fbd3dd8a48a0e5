//! Elimination orders by minimum degree.

use std::collections::BinaryHeap;

/// The order of elimination of a graph's nodes, and what each elimination touches.
///
/// Minimum degree with explicit fill (Rose 1972): the node with the fewest neighbours goes first and leaves its neighbours
/// connected to each other. Ties go to the node with the smaller index, so that the order is a function of the graph alone.
#[derive(Clone, Debug, Default)]
pub(crate) struct Ordering {
    /// Neighbours of each node among the nodes that are left, ascending.
    adjacent: Vec<Vec<u32>>,
    done: Vec<bool>,
    /// (inverted degree, inverted node): the largest is the next candidate. Stale entries are skipped.
    queue: BinaryHeap<(u32, u32)>,
    merged: Vec<u32>,
    /// Nodes in the order of their elimination.
    pub order: Vec<u32>,
    /// Where each eliminated node's neighbours begin in `neighbours`, by position in the order.
    pub offsets: Vec<usize>,
    /// The neighbours each node has when it is eliminated, as nodes.
    pub neighbours: Vec<u32>,
}

impl Ordering {
    /// Orders a graph of `count` nodes with these edges (pairs of different nodes, duplicates allowed).
    pub fn find(&mut self, count: usize, edges: &[(u32, u32)]) {
        self.read(count, edges);
        self.order.clear();
        self.neighbours.clear();
        self.offsets.clear();
        self.offsets.push(0);
        while let Some((degree, node)) = self.queue.pop() {
            let (degree, node) = (u32::MAX - degree, u32::MAX - node);
            if self.done[node as usize] || self.adjacent[node as usize].len() != degree as usize {
                continue;
            }
            if degree as usize + 1 == count - self.order.len() {
                self.take_clique(count);
                break;
            }
            self.eliminate(node);
        }
    }

    fn read(&mut self, count: usize, edges: &[(u32, u32)]) {
        self.adjacent.iter_mut().for_each(Vec::clear);
        if self.adjacent.len() < count {
            self.adjacent.resize_with(count, Vec::new);
        }
        for &(a, b) in edges {
            self.adjacent[a as usize].push(b);
            self.adjacent[b as usize].push(a);
        }
        self.done.clear();
        self.done.resize(count, false);
        self.queue.clear();
        for (node, list) in self.adjacent[..count].iter_mut().enumerate() {
            list.sort_unstable();
            list.dedup();
            self.queue.push((u32::MAX - list.len() as u32, u32::MAX - node as u32));
        }
    }

    fn eliminate(&mut self, node: u32) {
        let own = std::mem::take(&mut self.adjacent[node as usize]);
        self.record(node, &own);
        for &u in &own {
            merge_into(&self.adjacent[u as usize], &own, u, node, &mut self.merged);
            std::mem::swap(&mut self.adjacent[u as usize], &mut self.merged);
            let degree = self.adjacent[u as usize].len() as u32;
            self.queue.push((u32::MAX - degree, u32::MAX - u));
        }
        self.adjacent[node as usize] = own;
    }

    /// All nodes that are left are neighbours of each other: any order is as good.
    fn take_clique(&mut self, count: usize) {
        for node in 0..count as u32 {
            if !self.done[node as usize] {
                self.done[node as usize] = true;
                self.order.push(node);
                let done = &self.done;
                self.neighbours.extend((node + 1..count as u32).filter(|&u| !done[u as usize]));
                self.offsets.push(self.neighbours.len());
            }
        }
    }

    fn record(&mut self, node: u32, neighbours: &[u32]) {
        self.done[node as usize] = true;
        self.order.push(node);
        self.neighbours.extend_from_slice(neighbours);
        self.offsets.push(self.neighbours.len());
    }
}

/// `(a ∪ b) \ {own, gone}` of two ascending lists.
fn merge_into(a: &[u32], b: &[u32], own: u32, gone: u32, out: &mut Vec<u32>) {
    out.clear();
    let (mut i, mut j) = (0, 0);
    while i < a.len() || j < b.len() {
        let next = match (a.get(i), b.get(j)) {
            (Some(&x), Some(&y)) => x.min(y),
            (Some(&x), None) => x,
            (None, Some(&y)) => y,
            (None, None) => break,
        };
        i += usize::from(a.get(i) == Some(&next));
        j += usize::from(b.get(j) == Some(&next));
        if next != own && next != gone {
            out.push(next);
        }
    }
}
