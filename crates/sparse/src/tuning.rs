//! What is tuned in the choice of an order.

/// Numbers of the orders by nested dissection.
pub(crate) struct Tuning {
    /// From this cost by minimum degree on, nested dissection is tried: a factorisation then takes about as long as the dissection.
    pub costly_order: u64,
    /// Graphs with no more nodes are ordered by minimum degree, and cut without coarser ones.
    pub small_graph: usize,
    /// Cuts made of each graph, each by other coarse graphs; and beginnings of each cut.
    pub cuts: usize,
    /// The share of the weight that a side should not exceed.
    pub largest_side: f64,
    /// Moves after the best state before a round of improvement is given up.
    pub patience: usize,
}

/// Chosen by: the cost of lattices of 2,744 to 10,000 nodes (cubes, bricks, walls), 23 November 2026; `costly_order` and `cuts` from
/// the commit that brought dissection, 22 November 2026.
pub(crate) const TUNING: Tuning =
    Tuning { costly_order: 1_000_000, small_graph: 80, cuts: 4, largest_side: 0.6, patience: 200 };
