//! Small sets of nodes that cut a graph in two.

use std::collections::BinaryHeap;

use super::graph::{Coarsening, Graph};
use super::random::Random;
use super::tuning::TUNING;

/// Where a node lies: on one of the two sides, `0` and `1`, or in the separator.
pub(crate) const SEPARATOR: u8 = 2;

/// Finds vertex separators by the multilevel scheme of Karypis & Kumar (1998): the graph is made coarser and coarser, the coarsest
/// is cut, and the cut is improved on each graph on the way back.
///
/// A cut is improved by moves of a node from the separator to one side, which pull its neighbours on the other side into the
/// separator; the best move goes first, also when it makes the cut worse, and the best state on the way is kept (Fiduccia &
/// Mattheyses 1982, for separators as Ashcraft & Liu 1998, "Applications of the Dulmage–Mendelsohn decomposition and network flow to
/// graph bisection improvement").
#[derive(Clone, Debug, Default)]
pub(crate) struct Bisection {
    coarsening: Coarsening,
    /// Coarser and coarser graphs, and the node of each that each node of the graph before belongs to.
    coarser: Vec<(Graph, Vec<u32>)>,
    cut: Cut,
    /// The best sides, of the graph and of the coarsest one.
    best: Vec<u8>,
    begun: Vec<u8>,
    projected: Vec<u8>,
}

impl Bisection {
    /// Cuts a connected graph: where each of its nodes lies, by the best of several cuts.
    pub fn cut(&mut self, graph: &Graph, random: &mut Random) -> &[u8] {
        let mut smallest = None;
        for _ in 0..TUNING.cuts {
            let levels = self.coarsen(graph, random);
            self.begin(graph, levels, random);
            self.refine(graph, levels);
            keep_best(&mut self.cut, &mut self.best, &mut smallest);
        }
        &self.best
    }

    /// Makes coarser and coarser graphs: their number.
    fn coarsen(&mut self, graph: &Graph, random: &mut Random) -> usize {
        let limit = (3 * graph.total_weight() / (2 * TUNING.small_graph as u32)).max(2);
        let mut levels = 0;
        loop {
            if self.coarser.len() == levels {
                self.coarser.push(Default::default());
            }
            let (done, left) = self.coarser.split_at_mut(levels);
            let fine = done.last().map_or(graph, |(graph, _)| graph);
            if fine.count() <= TUNING.small_graph {
                return levels;
            }
            let (coarse, coarse_of) = &mut left[0];
            self.coarsening.coarsen(fine, limit, random, coarse, coarse_of);
            // Less than half of the nodes found a partner.
            if 4 * coarse.count() > 3 * fine.count() {
                return levels;
            }
            levels += 1;
        }
    }

    /// Cuts the coarsest graph: the best of several beginnings.
    fn begin(&mut self, graph: &Graph, levels: usize, random: &mut Random) {
        let Self { coarser, cut, begun, .. } = self;
        let coarsest = levels.checked_sub(1).map_or(graph, |level| &coarser[level].0);
        let mut smallest = None;
        for _ in 0..TUNING.cuts {
            cut.grow(coarsest, random.below(coarsest.count()));
            cut.improve(coarsest);
            keep_best(cut, begun, &mut smallest);
        }
        std::mem::swap(begun, &mut cut.side);
        // Its weights, too, are to be those of the best.
        cut.begin_round(coarsest);
    }

    /// Carries the cut back to the graph itself, and improves it on every graph on the way.
    fn refine(&mut self, graph: &Graph, levels: usize) {
        let Self { coarser, cut, projected, .. } = self;
        for level in (0..levels).rev() {
            projected.clear();
            projected.extend(coarser[level].1.iter().map(|&node| cut.side[node as usize]));
            std::mem::swap(projected, &mut cut.side);
            cut.improve(level.checked_sub(1).map_or(graph, |level| &coarser[level].0));
        }
    }
}

/// Takes the sides of a cut over if it is better than all before.
fn keep_best(cut: &mut Cut, best: &mut Vec<u8>, smallest: &mut Option<Badness>) {
    let badness = cut.badness();
    if smallest.is_none_or(|smallest| badness < smallest) {
        *smallest = Some(badness);
        std::mem::swap(best, &mut cut.side);
    }
}

/// How bad a cut is: first the excess of the larger side, then the separator, then the larger side.
type Badness = (u64, u64, u64);

/// The most of a total weight that a side should have.
fn most_on_side(total: u64) -> u64 {
    (TUNING.largest_side * total as f64) as u64
}

/// A cut of a graph, and how it is improved.
#[derive(Clone, Debug, Default)]
struct Cut {
    side: Vec<u8>,
    /// Weight of the two sides and of the separator.
    weight: [u64; 3],
    /// For nodes of the separator: weight of their neighbours on each side.
    reach: Vec<[i64; 2]>,
    /// Nodes that have moved out of the separator in this round.
    moved: Vec<bool>,
    /// Moves to each side: (by how much the separator shrinks, inverted node). Stale entries are skipped.
    queues: [BinaryHeap<(i64, u32)>; 2],
    /// Nodes that changed, and where they were.
    log: Vec<(u32, u8)>,
}

impl Cut {
    fn badness(&self) -> Badness {
        let larger = self.weight[0].max(self.weight[1]);
        let total: u64 = self.weight.iter().sum();
        (larger.saturating_sub(most_on_side(total)), self.weight[2], larger)
    }

    /// Grows side 0 from a node, the nearest nodes first, until the sides are equal.
    fn grow(&mut self, graph: &Graph, start: usize) {
        self.side.clear();
        self.side.resize(graph.count(), 1);
        self.side[start] = SEPARATOR;
        self.begin_round(graph);
        self.move_to(graph, start as u32, 0);
        let mut next = 0;
        while self.weight[0] < self.weight[1]
            && let Some(&(node, _)) = self.log.get(next)
        {
            next += 1;
            if self.side[node as usize] == SEPARATOR {
                self.move_to(graph, node, 0);
            }
        }
    }

    fn improve(&mut self, graph: &Graph) {
        while self.improve_once(graph) {}
    }

    fn improve_once(&mut self, graph: &Graph) -> bool {
        self.begin_round(graph);
        let before = self.badness();
        let (mut best, mut best_length, mut moves) = (before, 0, 0);
        while moves < TUNING.patience {
            let Some((node, side)) = self.choose(graph) else { break };
            self.move_to(graph, node, side);
            moves += 1;
            if self.badness() < best {
                (best, best_length, moves) = (self.badness(), self.log.len(), 0);
            }
        }
        while self.log.len() > best_length {
            let Some((node, side)) = self.log.pop() else { break };
            let (node, weight) = (node as usize, u64::from(graph.weight(node as usize)));
            self.weight[self.side[node] as usize] -= weight;
            self.weight[side as usize] += weight;
            self.side[node] = side;
        }
        best < before
    }

    /// The better of the best moves to the two sides; one that makes a side too heavy only if it was the lighter one.
    fn choose(&mut self, graph: &Graph) -> Option<(u32, usize)> {
        let total: u64 = self.weight.iter().sum();
        let lighter = usize::from(self.weight[1] < self.weight[0]);
        let mut best: Option<(i64, u32, usize)> = None;
        for side in [lighter, 1 - lighter] {
            let Some((gain, node)) = self.next_move(graph, side) else { continue };
            let weight = self.weight[side] + u64::from(graph.weight(node as usize));
            let fits = side == lighter || weight <= most_on_side(total);
            if fits && best.is_none_or(|(best, ..)| gain > best) {
                best = Some((gain, node, side));
            }
        }
        best.map(|(_, node, side)| (node, side))
    }

    fn begin_round(&mut self, graph: &Graph) {
        self.weight = [0; 3];
        self.log.clear();
        self.moved.clear();
        self.moved.resize(graph.count(), false);
        self.reach.clear();
        self.reach.resize(graph.count(), [0; 2]);
        self.queues.iter_mut().for_each(BinaryHeap::clear);
        for node in 0..graph.count() {
            self.weight[self.side[node] as usize] += u64::from(graph.weight(node));
            if self.side[node] == SEPARATOR {
                self.enter(graph, node);
            }
        }
    }

    /// Computes what a node of the separator reaches, and offers its moves.
    fn enter(&mut self, graph: &Graph, node: usize) {
        let mut reach = [0; 2];
        for &u in graph.neighbours(node) {
            if let Some(reach) = reach.get_mut(self.side[u as usize] as usize) {
                *reach += i64::from(graph.weight(u as usize));
            }
        }
        self.reach[node] = reach;
        self.offer(graph, node, 0);
        self.offer(graph, node, 1);
    }

    /// How much smaller the separator is after a move of one of its nodes.
    fn gain(&self, graph: &Graph, node: usize, side: usize) -> i64 {
        i64::from(graph.weight(node)) - self.reach[node][1 - side]
    }

    fn offer(&mut self, graph: &Graph, node: usize, side: usize) {
        if !self.moved[node] {
            self.queues[side].push((self.gain(graph, node, side), u32::MAX - node as u32));
        }
    }

    /// The best move to a side that is possible: gain and node. It stays in the queue.
    fn next_move(&mut self, graph: &Graph, side: usize) -> Option<(i64, u32)> {
        while let Some(&(gain, inverted)) = self.queues[side].peek() {
            let node = u32::MAX - inverted;
            let k = node as usize;
            if self.side[k] == SEPARATOR && !self.moved[k] && self.gain(graph, k, side) == gain {
                return Some((gain, node));
            }
            self.queues[side].pop();
        }
        None
    }

    /// Moves a node from the separator to a side and its neighbours on the other side into the separator.
    fn move_to(&mut self, graph: &Graph, node: u32, side: usize) {
        let own = graph.weight(node as usize);
        self.place(graph, node, side as u8);
        self.moved[node as usize] = true;
        for &u in graph.neighbours(node as usize) {
            let k = u as usize;
            if self.side[k] == SEPARATOR {
                self.reach[k][side] += i64::from(own);
                self.offer(graph, k, 1 - side);
            } else if self.side[k] as usize == 1 - side {
                self.place(graph, u, SEPARATOR);
                for &x in graph.neighbours(k) {
                    if self.side[x as usize] == SEPARATOR {
                        self.reach[x as usize][1 - side] -= i64::from(graph.weight(k));
                        self.offer(graph, x as usize, side);
                    }
                }
                self.enter(graph, k);
            }
        }
    }

    fn place(&mut self, graph: &Graph, node: u32, side: u8) {
        let (k, weight) = (node as usize, u64::from(graph.weight(node as usize)));
        self.log.push((node, self.side[k]));
        self.weight[self.side[k] as usize] -= weight;
        self.weight[side as usize] += weight;
        self.side[k] = side;
    }
}
