//! Graphs with weights, and smaller ones that resemble them.

use super::random::Random;

/// An undirected graph: for each node its neighbours, with weights of nodes and edges.
#[derive(Clone, Debug, Default)]
pub(crate) struct Graph {
    /// Where each node's neighbours begin in `targets`, and the total.
    offsets: Vec<usize>,
    targets: Vec<u32>,
    /// How many edges of the finest graph each entry of `targets` stands for.
    edge_weights: Vec<u32>,
    /// How many nodes of the finest graph each node stands for.
    weights: Vec<u32>,
}

impl Graph {
    /// Number of nodes.
    pub fn count(&self) -> usize {
        self.weights.len()
    }

    /// Neighbours of a node.
    pub fn neighbours(&self, node: usize) -> &[u32] {
        &self.targets[self.offsets[node]..self.offsets[node + 1]]
    }

    /// Weight of a node.
    pub fn weight(&self, node: usize) -> u32 {
        self.weights[node]
    }

    /// Sum of the nodes' weights.
    pub fn total_weight(&self) -> u32 {
        self.weights.iter().sum()
    }

    /// Makes it a graph without nodes.
    pub fn clear(&mut self) {
        self.offsets.clear();
        self.offsets.push(0);
        self.targets.clear();
        self.edge_weights.clear();
        self.weights.clear();
    }

    /// Appends a node of weight one with these neighbours, each by an edge of weight one.
    pub fn push(&mut self, neighbours: impl Iterator<Item = u32>) {
        self.targets.extend(neighbours);
        self.edge_weights.resize(self.targets.len(), 1);
        self.offsets.push(self.targets.len());
        self.weights.push(1);
    }

    /// Makes it the graph of `count` nodes with these edges (pairs of different nodes, duplicates allowed), all weights one.
    pub fn read(&mut self, count: usize, edges: &[(u32, u32)]) {
        self.offsets.clear();
        self.offsets.resize(count + 2, 0);
        for &(a, b) in edges {
            self.offsets[a as usize + 2] += 1;
            self.offsets[b as usize + 2] += 1;
        }
        for k in 2..self.offsets.len() {
            self.offsets[k] += self.offsets[k - 1];
        }
        self.targets.clear();
        self.targets.resize(2 * edges.len(), 0);
        for &(a, b) in edges {
            for (from, to) in [(a, b), (b, a)] {
                let cursor = &mut self.offsets[from as usize + 1];
                self.targets[*cursor] = to;
                *cursor += 1;
            }
        }
        self.offsets.pop();
        let mut end = 0;
        for node in 0..count {
            let range = self.offsets[node]..self.offsets[node + 1];
            self.targets[range.clone()].sort_unstable();
            self.offsets[node] = end;
            for entry in range {
                let target = self.targets[entry];
                if end == self.offsets[node] || self.targets[end - 1] != target {
                    self.targets[end] = target;
                    end += 1;
                }
            }
        }
        self.offsets[count] = end;
        self.targets.truncate(end);
        self.edge_weights.clear();
        self.edge_weights.resize(end, 1);
        self.weights.clear();
        self.weights.resize(count, 1);
    }
}

const NONE: u32 = u32::MAX;

/// Joins pairs of nodes along heavy edges (Karypis & Kumar 1998, "A fast and high quality multilevel scheme for partitioning
/// irregular graphs", heavy-edge matching): a node's partner has the highest square of the edge's weight by the partner's own,
/// which keeps the coarse nodes alike (Holtgrewe, Sanders & Schulz 2010, "Engineering a scalable high quality graph partitioner").
#[derive(Clone, Debug, Default)]
pub(crate) struct Coarsening {
    /// Nodes in the order of their visits: by the number of their edges, then by chance.
    visits: Vec<(usize, usize, u32)>,
    partner: Vec<u32>,
    /// Where the coarse node at hand has the edge to each coarse node.
    entry: Vec<usize>,
}

impl Coarsening {
    /// Makes `coarse` a graph whose nodes are pairs of neighbours in `fine`, and nodes that were left alone; no pair is heavier than
    /// `limit`. `coarse_of` becomes the coarse node of each node.
    pub fn coarsen(
        &mut self,
        fine: &Graph,
        limit: u32,
        random: &mut Random,
        coarse: &mut Graph,
        coarse_of: &mut Vec<u32>,
    ) {
        self.pair(fine, limit, random);
        coarse_of.clear();
        coarse_of.resize(fine.count(), NONE);
        let mut count = 0;
        for node in 0..fine.count() {
            if coarse_of[node] == NONE {
                coarse_of[node] = count;
                coarse_of[self.partner[node] as usize] = count;
                count += 1;
            }
        }
        coarse.clear();
        self.entry.clear();
        self.entry.resize(count as usize, usize::MAX);
        for node in 0..fine.count() {
            let partner = self.partner[node] as usize;
            if partner < node {
                continue;
            }
            let begin = coarse.targets.len();
            self.add_edges(fine, node, coarse_of, begin, coarse);
            let mut weight = fine.weights[node];
            if partner != node {
                self.add_edges(fine, partner, coarse_of, begin, coarse);
                weight += fine.weights[partner];
            }
            coarse.offsets.push(coarse.targets.len());
            coarse.weights.push(weight);
        }
    }

    fn pair(&mut self, fine: &Graph, limit: u32, random: &mut Random) {
        let count = fine.count();
        self.visits.clear();
        // Nodes with few edges first: they would be left alone.
        let by_chance = |node| (fine.neighbours(node).len(), random.below(1 << 31), node as u32);
        self.visits.extend((0..count).map(by_chance));
        self.visits.sort_unstable();
        self.partner.clear();
        self.partner.resize(count, NONE);
        for &(_, _, node) in &self.visits {
            if self.partner[node as usize] != NONE {
                continue;
            }
            let (mut best, mut highest) = (node, (0, 1));
            // Edges are often alike: which one is the first must not depend on how the nodes are numbered.
            let (begin, count) = (fine.offsets[node as usize], fine.neighbours(node as usize).len());
            let first = begin + random.below(count.max(1));
            for entry in (first..begin + count).chain(begin..first) {
                let (other, edge) = (fine.targets[entry], fine.edge_weights[entry]);
                let fits = fine.weights[node as usize] + fine.weights[other as usize] <= limit;
                let rating = (u64::from(edge).pow(2), u64::from(fine.weights[other as usize]));
                let is_higher = rating.0 * highest.1 > highest.0 * rating.1;
                if is_higher && fits && self.partner[other as usize] == NONE {
                    (best, highest) = (other, rating);
                }
            }
            self.partner[node as usize] = best;
            self.partner[best as usize] = node;
        }
    }

    /// Adds a node's edges to those of the last coarse node, which begin at `begin`.
    fn add_edges(&mut self, fine: &Graph, node: usize, coarse_of: &[u32], begin: usize, coarse: &mut Graph) {
        for entry in fine.offsets[node]..fine.offsets[node + 1] {
            let target = coarse_of[fine.targets[entry] as usize];
            if target == coarse_of[node] {
                continue;
            }
            let place = self.entry[target as usize];
            if place >= begin && place < coarse.targets.len() && coarse.targets[place] == target {
                coarse.edge_weights[place] += fine.edge_weights[entry];
            } else {
                self.entry[target as usize] = coarse.targets.len();
                coarse.targets.push(target);
                coarse.edge_weights.push(fine.edge_weights[entry]);
            }
        }
    }
}
