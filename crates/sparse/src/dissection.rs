//! Elimination orders by nested dissection.

use super::bisection::{Bisection, SEPARATOR};
use super::elimination::Elimination;
use super::graph::Graph;
use super::minimum_degree::MinimumDegree;
use super::random::Random;
use super::tuning::TUNING;

/// Nested dissection (George 1973, "Nested dissection of a regular finite element mesh"): a small set of nodes that cuts the graph
/// goes last, each part before it in the same way, so that no elimination in one part touches the other.
///
/// Parts that are small, or that no small set cuts, are ordered by minimum degree, where their neighbours outside count, too
/// (Pellegrini, Roman & Amestoy 2000, "Hybridizing nested dissection and halo approximate minimum degree for efficient sparse matrix
/// ordering").
#[derive(Clone, Debug, Default)]
pub(crate) struct Dissection {
    /// The order.
    pub nodes: Vec<u32>,
    /// Place of each node in `nodes`.
    pub position: Vec<u32>,
    /// Parts that are left to be ordered: places in `nodes`.
    parts: Vec<(usize, usize)>,
    bisection: Bisection,
    part: Graph,
    /// For each node of the part whether it was reached.
    reached: Vec<bool>,
    /// The part's nodes in their new order.
    sorted: Vec<u32>,
    /// Neighbours of the part.
    outside: Vec<u32>,
    edges: Vec<(u32, u32)>,
    minimum_degree: MinimumDegree,
    leaf: Elimination,
}

impl Dissection {
    /// Orders the nodes of a graph; `false` where no small set cuts it.
    pub fn find(&mut self, graph: &Graph) -> bool {
        let count = graph.count();
        self.position.clear();
        self.position.resize(count, 0);
        // Nodes that meet most of the others are in the way of every cut, and go last.
        let is_hub = |node: u32| 2 * graph.neighbours(node as usize).len() > count;
        self.nodes.clear();
        self.nodes.extend((0..count as u32).filter(|&node| !is_hub(node)));
        let inner = self.nodes.len();
        self.nodes.extend((0..count as u32).filter(|&node| is_hub(node)));
        self.renumber(0, count);
        let mut random = Random::new(0);
        self.parts.clear();
        self.parts.push((0, inner));
        while let Some((begin, end)) = self.parts.pop() {
            if end - begin <= TUNING.small_graph {
                self.order_leaf(graph, begin, end);
                continue;
            }
            self.take_part(graph, begin, end);
            if self.split_components(begin, end) || self.cut(begin, end, &mut random) {
                continue;
            }
            if end - begin == inner {
                return false;
            }
            self.order_leaf(graph, begin, end);
        }
        true
    }

    fn renumber(&mut self, begin: usize, end: usize) {
        for (place, &node) in self.nodes[begin..end].iter().enumerate() {
            self.position[node as usize] = (begin + place) as u32;
        }
    }

    /// Copies the graph of the nodes from `begin` to `end`.
    fn take_part(&mut self, graph: &Graph, begin: usize, end: usize) {
        let Self { part, nodes, position, .. } = self;
        let range = begin as u32..end as u32;
        part.clear();
        for &node in &nodes[begin..end] {
            let places = graph.neighbours(node as usize).iter().map(|&u| position[u as usize]);
            part.push(places.filter(|place| range.contains(place)).map(|place| place - range.start));
        }
    }

    /// Makes each component of the part at hand a part, unless there is one only.
    fn split_components(&mut self, begin: usize, end: usize) -> bool {
        let Self { part, reached, sorted, parts, .. } = self;
        let count = end - begin;
        reached.clear();
        reached.resize(count, false);
        sorted.clear();
        for start in 0..count {
            if reached[start] {
                continue;
            }
            let mut next = sorted.len();
            let first = next;
            reached[start] = true;
            sorted.push(start as u32);
            while let Some(&node) = sorted.get(next) {
                next += 1;
                for &u in part.neighbours(node as usize) {
                    if !std::mem::replace(&mut reached[u as usize], true) {
                        sorted.push(u);
                    }
                }
            }
            if first == 0 && next == count {
                return false;
            }
            parts.push((begin + first, begin + next));
        }
        self.sort(begin, end);
        true
    }

    /// Gives the nodes from `begin` to `end` the order of `sorted`.
    fn sort(&mut self, begin: usize, end: usize) {
        self.sorted.iter_mut().for_each(|k| *k = self.nodes[begin + *k as usize]);
        self.nodes[begin..end].copy_from_slice(&self.sorted);
        self.renumber(begin, end);
    }

    /// Makes the two sides of a cut of the part at hand parts; `false` where none is worth it.
    fn cut(&mut self, begin: usize, end: usize, random: &mut Random) -> bool {
        let sides = self.bisection.cut(&self.part, random);
        self.sorted.clear();
        let mut ends = [begin; 2];
        for side in [0, 1, SEPARATOR] {
            self.sorted.extend((0..end - begin).filter(|&k| sides[k] == side).map(|k| k as u32));
            if let Some(last) = ends.get_mut(side as usize) {
                *last = begin + self.sorted.len();
            }
        }
        let smaller = (ends[0] - begin).min(ends[1] - ends[0]);
        if smaller <= end - ends[1] {
            return false;
        }
        self.sort(begin, end);
        self.parts.extend([(begin, ends[0]), (ends[0], ends[1])]);
        true
    }

    fn order_leaf(&mut self, graph: &Graph, begin: usize, end: usize) {
        let Self { nodes, position, outside, edges, .. } = self;
        let count = end - begin;
        outside.clear();
        for &node in &nodes[begin..end] {
            outside.extend(graph.neighbours(node as usize).iter().filter(|&&u| position[u as usize] as usize >= end));
        }
        outside.sort_unstable();
        outside.dedup();
        edges.clear();
        for (k, &node) in nodes[begin..end].iter().enumerate() {
            for &u in graph.neighbours(node as usize) {
                let place = position[u as usize] as usize;
                let other = if place < end { place - begin } else { count + outside.partition_point(|&x| x < u) };
                edges.push((k as u32, other as u32));
            }
        }
        self.minimum_degree.read(count + outside.len(), count, edges.iter().copied());
        self.leaf.clear();
        self.minimum_degree.eliminate_within(u64::MAX, &mut self.leaf);
        std::mem::swap(&mut self.sorted, &mut self.leaf.order);
        self.sort(begin, end);
    }
}
