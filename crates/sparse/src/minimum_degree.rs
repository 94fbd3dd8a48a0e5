//! Elimination orders by minimum degree.

use std::collections::BinaryHeap;

use super::elimination::Elimination;

/// Minimum degree with explicit fill (Rose 1972): the node with the fewest neighbours goes first and leaves its neighbours
/// connected to each other. Ties go to the node with the smaller index, so that the order is a function of the graph alone.
#[derive(Clone, Debug, Default)]
pub(crate) struct MinimumDegree {
    /// Nodes that are to be eliminated: the first ones. The others only add to the degrees.
    inner: usize,
    /// Nodes that are not yet eliminated.
    left: usize,
    /// Neighbours of each node among the nodes that are left.
    adjacent: Vec<Vec<u32>>,
    done: Vec<bool>,
    /// (inverted degree, inverted node): the largest is the next candidate. Stale entries are skipped.
    queue: BinaryHeap<(u32, u32)>,
    /// Number of lists that were extended, and for each node the last one in which it was.
    extended: u32,
    seen: Vec<u32>,
}

impl MinimumDegree {
    /// Reads a graph of `count` nodes with these edges (pairs of different nodes, duplicates allowed), the first `inner` of which
    /// are to be eliminated.
    pub fn read(&mut self, count: usize, inner: usize, edges: impl IntoIterator<Item = (u32, u32)>) {
        self.inner = inner;
        self.left = count;
        self.adjacent.iter_mut().for_each(Vec::clear);
        if self.adjacent.len() < count {
            self.adjacent.resize_with(count, Vec::new);
        }
        for (a, b) in edges {
            self.adjacent[a as usize].push(b);
            self.adjacent[b as usize].push(a);
        }
        self.done.clear();
        self.done.resize(count, false);
        self.queue.clear();
        self.extended = 0;
        self.seen.clear();
        self.seen.resize(count, 0);
        for (node, list) in self.adjacent[..count].iter_mut().enumerate() {
            list.sort_unstable();
            list.dedup();
            if node < inner {
                self.queue.push((u32::MAX - list.len() as u32, u32::MAX - node as u32));
            }
        }
    }

    /// Appends eliminations until all is done (`true`), or until it is certain that they will cost more than `limit`; a later call
    /// with a higher limit goes on from there.
    pub fn eliminate_within(&mut self, limit: u64, out: &mut Elimination) -> bool {
        while let Some((inverted_degree, inverted_node)) = self.queue.pop() {
            let (degree, node) = (u32::MAX - inverted_degree, u32::MAX - inverted_node);
            if self.done[node as usize] || self.adjacent[node as usize].len() != degree as usize {
                continue;
            }
            let is_clique = degree as usize + 1 == self.left;
            // The neighbours become a clique, which has its own cost.
            let own = u64::from(degree);
            if out.cost + own * (own + 1) * (2 * own + 1) / 6 > limit {
                self.queue.push((inverted_degree, inverted_node));
                return false;
            }
            if is_clique {
                self.take_clique(out);
                break;
            }
            self.eliminate(node, out);
        }
        true
    }

    fn eliminate(&mut self, node: u32, out: &mut Elimination) {
        let own = std::mem::take(&mut self.adjacent[node as usize]);
        self.done[node as usize] = true;
        self.left -= 1;
        out.push(node, own.iter().copied());
        for &u in &own {
            self.connect(u, &own, node);
            if (u as usize) < self.inner {
                let degree = self.adjacent[u as usize].len() as u32;
                self.queue.push((u32::MAX - degree, u32::MAX - u));
            }
        }
        self.adjacent[node as usize] = own;
    }

    /// Makes `own` neighbours of `u`, and `gone` none.
    fn connect(&mut self, u: u32, own: &[u32], gone: u32) {
        let list = &mut self.adjacent[u as usize];
        self.extended += 1;
        self.seen[u as usize] = self.extended;
        let mut place = 0;
        for (k, &x) in list.iter().enumerate() {
            self.seen[x as usize] = self.extended;
            if x == gone {
                place = k;
            }
        }
        list.swap_remove(place);
        let known = list.len();
        list.resize(known + own.len(), 0);
        let mut end = known;
        // Without branches, which would go either way.
        for &x in own {
            list[end] = x;
            end += usize::from(self.seen[x as usize] != self.extended);
        }
        list.truncate(end);
    }

    /// All nodes that are left are neighbours of each other: any order is as good.
    fn take_clique(&mut self, out: &mut Elimination) {
        let count = self.inner as u32;
        for node in 0..count {
            if !self.done[node as usize] {
                self.done[node as usize] = true;
                let done = &self.done;
                out.push(node, (node + 1..count).filter(|&u| !done[u as usize]));
            }
        }
    }
}
