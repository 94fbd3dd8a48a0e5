//! The choice of an elimination order.

use super::dissection::Dissection;
use super::elimination::{Elimination, GivenOrder};
use super::graph::Graph;
use super::minimum_degree::MinimumDegree;
use super::tuning::TUNING;

/// The order of elimination of a graph's nodes: by [minimum degree](MinimumDegree), or by [nested dissection](Dissection) where the
/// former is costly and the latter cheaper. It is a function of the graph alone.
#[derive(Clone, Debug, Default)]
pub(crate) struct Ordering {
    /// The order and what it touches.
    pub elimination: Elimination,
    minimum_degree: MinimumDegree,
    dissection: Dissection,
    given_order: GivenOrder,
    graph: Graph,
    other: Elimination,
}

impl Ordering {
    /// Orders a graph of `count` nodes with these edges (pairs of different nodes, duplicates allowed).
    pub fn find(&mut self, count: usize, edges: &[(u32, u32)]) {
        self.elimination.clear();
        self.minimum_degree.read(count, count, edges.iter().copied());
        if self.minimum_degree.eliminate_within(TUNING.costly_order, &mut self.elimination) {
            return;
        }
        self.graph.read(count, edges);
        let Self { dissection, other, .. } = self;
        let limit = if dissection.find(&self.graph) {
            self.given_order.eliminate(&self.graph, &dissection.nodes, &dissection.position, other);
            other.cost
        } else {
            u64::MAX
        };
        if !self.minimum_degree.eliminate_within(limit, &mut self.elimination) {
            std::mem::swap(&mut self.elimination, other);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::random::Random;
    use super::super::{BlockLu, Symbolic};
    use super::*;

    type Edges = Vec<(u32, u32)>;

    /// Nodes of a box of points, each coupled with those of the given distances.
    fn lattice(size: [usize; 3], distances: &[[usize; 3]]) -> (usize, Edges) {
        let node = |p: [usize; 3]| ((p[0] * size[1] + p[1]) * size[2] + p[2]) as u32;
        let count = size.iter().product();
        let mut edges = Vec::new();
        for k in 0..count {
            let p = [k / size[2] / size[1], k / size[2] % size[1], k % size[2]];
            for d in distances {
                let q = [p[0] + d[0], p[1] + d[1], p[2] + d[2]];
                if (0..3).all(|axis| q[axis] < size[axis]) {
                    edges.push((node(p), node(q)));
                }
            }
        }
        (count, edges)
    }

    fn cubes(size: usize) -> (usize, Edges) {
        lattice([size; 3], &[[1, 0, 0], [0, 1, 0], [0, 0, 1]])
    }

    /// Each couples with four in the layer above, as bricks do that are laid in bond.
    fn bricks(size: usize) -> (usize, Edges) {
        lattice([size; 3], &[[0, 0, 1], [0, 1, 1], [1, 0, 1], [1, 1, 1]])
    }

    fn random(count: usize, edges: usize, sequence: &mut Random) -> (usize, Edges) {
        let mut pair = || (sequence.below(count) as u32, sequence.below(count) as u32);
        let edges = std::iter::repeat_with(&mut pair).filter(|(a, b)| a != b).take(edges).collect();
        (count, edges)
    }

    fn by_minimum_degree((count, edges): &(usize, Edges)) -> Elimination {
        let (mut method, mut found) = (MinimumDegree::default(), Elimination::default());
        found.clear();
        method.read(*count, *count, edges.iter().copied());
        assert!(method.eliminate_within(u64::MAX, &mut found));
        found
    }

    fn by_dissection((count, edges): &(usize, Edges)) -> Elimination {
        let mut graph = Graph::default();
        graph.read(*count, edges);
        let (mut method, mut found) = (Dissection::default(), Elimination::default());
        assert!(method.find(&graph));
        GivenOrder::default().eliminate(&graph, &method.nodes, &method.position, &mut found);
        found
    }

    /// Compares with an elimination of a dense table of couplings.
    fn check((count, edges): &(usize, Edges), found: &Elimination) {
        let mut sorted = found.order.clone();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..*count as u32), "not a permutation");
        assert_eq!(found.offsets.len(), count + 1);
        let mut coupled = vec![vec![false; *count]; *count];
        for &(a, b) in edges {
            coupled[a as usize][b as usize] = true;
            coupled[b as usize][a as usize] = true;
        }
        let mut done = vec![false; *count];
        let mut cost = 0;
        for (k, &node) in found.order.iter().enumerate() {
            done[node as usize] = true;
            let wanted: Vec<u32> =
                (0..*count as u32).filter(|&u| coupled[node as usize][u as usize] && !done[u as usize]).collect();
            let mut neighbours = found.neighbours[found.offsets[k]..found.offsets[k + 1]].to_vec();
            neighbours.sort_unstable();
            assert_eq!(neighbours, wanted, "position {k}");
            cost += wanted.len() as u64 * wanted.len() as u64;
            for &a in &wanted {
                for &b in &wanted {
                    coupled[a as usize][b as usize] |= a != b;
                }
            }
        }
        assert_eq!(found.cost, cost);
    }

    #[test]
    fn structures_are_those_of_a_dense_elimination() {
        let mut sequence = Random::new(0);
        for count in [2, 3, 10, 40, 90, 300] {
            for density in [1, 2, 4] {
                let graph = random(count, density * count / 2, &mut sequence);
                check(&graph, &by_minimum_degree(&graph));
                let mut read = Graph::default();
                read.read(graph.0, &graph.1);
                let mut nodes: Vec<u32> = (0..count as u32).collect();
                (1..count).for_each(|k| nodes.swap(k, sequence.below(k + 1)));
                let mut position = vec![0; count];
                nodes.iter().enumerate().for_each(|(place, &node)| position[node as usize] = place as u32);
                let mut found = Elimination::default();
                GivenOrder::default().eliminate(&read, &nodes, &position, &mut found);
                assert_eq!(found.order, nodes);
                check(&graph, &found);
            }
        }
        for graph in [cubes(7), bricks(7)] {
            check(&graph, &by_dissection(&graph));
        }
    }

    #[test]
    fn dissection_pays_on_lattices() {
        for (graph, factor) in [(cubes(16), 1.3), (bricks(14), 2.0)] {
            let (minimum_degree, dissection) = (by_minimum_degree(&graph).cost, by_dissection(&graph).cost);
            let measured = minimum_degree as f64 / dissection as f64;
            assert!(measured > factor, "{} nodes: only {measured:.2} times fewer operations", graph.0);
            let mut ordering = Ordering::default();
            ordering.find(graph.0, &graph.1);
            assert_eq!(ordering.elimination.cost, dissection);
            // What was ordered before leaves no traces.
            ordering.find(3, &[(0, 1)]);
            ordering.find(graph.0, &graph.1);
            assert_eq!(ordering.elimination.order, by_dissection(&graph).order);
        }
    }

    #[test]
    fn graphs_without_small_cuts_are_ordered() {
        let mut sequence = Random::new(0);
        let star = (400, (1..400).map(|k| (0, k)).collect());
        let clique = (250, (0..250).flat_map(|b| (0..b).map(move |a| (a, b))).collect());
        let (part, edges) = cubes(5);
        let two = edges.iter().flat_map(|&(a, b)| [(a, b), (a + part as u32, b + part as u32)]).collect();
        let expander = random(400, 1600, &mut sequence);
        let mut hub = bricks(8);
        hub.1.extend((0..512).map(|k| (k, 512)));
        hub.0 = 513;
        let mut ordering = Ordering::default();
        for graph in [(0, vec![]), (1, vec![]), (300, vec![]), star, clique, (2 * part + 3, two), expander, hub] {
            ordering.find(graph.0, &graph.1);
            check(&graph, &ordering.elimination);
            assert!(ordering.elimination.cost <= by_minimum_degree(&graph).cost);
            let mut read = Graph::default();
            read.read(graph.0, &graph.1);
            let mut dissection = Dissection::default();
            if dissection.find(&read) {
                let mut found = Elimination::default();
                GivenOrder::default().eliminate(&read, &dissection.nodes, &dissection.position, &mut found);
                check(&graph, &found);
            }
        }
    }

    #[test]
    fn systems_in_a_dissected_order_are_solved() {
        let (count, edges) = bricks(14);
        let starts: Vec<usize> = (0..=count).map(|k| k + k / 3).collect();
        let mut sequence = Random::new(0);
        let mut noise = || sequence.below(2001) as f64 / 1000.0 - 1.0;
        let wanted: Vec<f64> = (0..starts[count]).map(|_| noise()).collect();
        let mut x = vec![0.0; starts[count]];
        let (mut symbolic, mut lu) = (Symbolic::default(), BlockLu::default());
        symbolic.analyse(&starts, &edges);
        lu.clear(&symbolic);
        for k in 0..count {
            let position = symbolic.position[k] as usize;
            let (place, stride) = (symbolic.upper_panel(position), symbolic.width(position));
            for (i, row) in (starts[k]..starts[k + 1]).enumerate() {
                for (j, column) in (starts[k]..starts[k + 1]).enumerate() {
                    let entry = noise() + if i == j { 12.0 } else { 0.0 };
                    lu.upper[place + i * stride + j] = entry;
                    x[row] += entry * wanted[column];
                }
            }
        }
        for &(a, b) in &edges {
            let (a, b) = (a as usize, b as usize);
            let (a, b) = if symbolic.position[a] < symbolic.position[b] { (a, b) } else { (b, a) };
            let place = symbolic.place(a, b);
            for (i, row) in (starts[b]..starts[b + 1]).enumerate() {
                for (j, column) in (starts[a]..starts[a + 1]).enumerate() {
                    let (below, above) = (noise(), noise());
                    lu.lower[place.lower + j * place.lower_stride + i] = below;
                    lu.upper[place.upper + j * place.upper_stride + i] = above;
                    x[row] += below * wanted[column];
                    x[column] += above * wanted[row];
                }
            }
        }
        assert!(lu.factor(&symbolic) > 0.0);
        lu.solve(&symbolic, &mut x);
        let error = x.iter().zip(&wanted).fold(0.0, |error: f64, (x, wanted)| error.max((x - wanted).abs()));
        assert!(error < 1e-9, "off by {error:e}");
    }
}
