//! The numbers of the sweeps.

/// How sweeps and exact solutions of parts take turns.
pub(super) struct Tuning {
    /// Sweeps between two looks at what is left: at first twice as many and all forward, which opens contacts quickest, then in pairs forward
    /// and backward, since forward alone one or two contacts may go round in circles. So many before iterations in the smallest large island.
    pub sweeps_a_round: u32,
    /// The largest part of a change that is extrapolated. Without a limit the extrapolation oscillates.
    pub momentum: f64,
    /// Rows that lack more than this part of what the worst one lacks are solved exactly, with their neighbours.
    pub lagging: f64,
    /// Parts with more rows are left to the sweeps: their solution would cost as much as that of the island.
    pub largest_part: usize,
    /// Rounds in which the residual has to fall as that of two looks has to; what falls slower is near rest, where modes are decided in the
    /// last digits.
    pub slow_rounds: usize,
    /// What is left beyond which the sweeps' modes are worth nothing to the iterations that go on from there.
    pub worthless: f64,
}

/// Chosen by: `moving_piles` on recorded steps of piles of 300 and 1000 that fall, strike and settle, and `sim S4_pile1000 S5_spheres1000`, 23
/// November 2026.
pub(super) const TUNING: Tuning =
    Tuning { sweeps_a_round: 30, momentum: 0.9, lagging: 0.1, largest_part: 400, slow_rounds: 3, worthless: 2e-3 };
