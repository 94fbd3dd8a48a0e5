//! Contradictions between gaps, proved while iterating.
//!
//! Where contacts demand what no velocity can give, every proximal iteration adds the same self-balanced impulses. Their normal
//! and bilateral parts `d ≥ 0` are then a Farkas vector: with `J_Nᵀ d_N + ∇Θᵀ d_B = 0` the sum `d_N · (J_N v + φ/Δt) + d_B · (∇Θ v +
//! Θ/Δt)` is the same for every `v`, and where it is negative no `v` satisfies the rows (formulation §4).

use super::island::Island;
use super::island_solver::IslandSolver;

/// Sums of numbers that cancel to this part of their sizes are zero.
const ROUNDING: f64 = 1e-9;

impl IslandSolver {
    /// Whether the last change of the impulses proves that the rows contradict each other; the units that do are then in
    /// `contradiction`.
    pub(super) fn is_contradiction(&mut self, island: &Island) -> bool {
        let normal = |c: usize| self.change[c][0];
        let contacts = 0..island.contact_count;
        let size = contacts.clone().map(normal).fold(0.0, f64::max);
        if size <= 0.0 || contacts.clone().any(|c| normal(c) < -ROUNDING * size) {
            return false;
        }
        let (mut gain, mut terms) = (0.0, 0.0);
        self.work.fill(0.0);
        self.magnitude.clear();
        self.magnitude.resize(island.nv(), 0.0);
        for c in contacts.clone() {
            let d = normal(c).max(0.0);
            gain += d * island.offset[c][0];
            terms += (d * island.offset[c][0]).abs();
            let (columns, entries) = island.jacobian.group(c);
            for (&k, e) in columns.iter().zip(entries) {
                self.work[k as usize] += d * e[0];
                self.magnitude[k as usize] += (d * e[0]).abs();
            }
        }
        for (k, (&d, offset)) in self.bilateral_change.iter().zip(&island.bilateral_offset).enumerate() {
            gain += d * offset;
            terms += (d * offset).abs();
            let (columns, entries) = island.bilateral_jacobian.group(k);
            for (&k, e) in columns.iter().zip(entries) {
                self.work[k as usize] += d * e[0];
                self.magnitude[k as usize] += (d * e[0]).abs();
            }
        }
        let balanced = self.work.iter().zip(&self.magnitude).all(|(sum, size)| sum.abs() <= ROUNDING * size);
        if !balanced || gain >= -ROUNDING * terms {
            return false;
        }
        self.contradiction.extend(contacts.filter(|&c| normal(c) > ROUNDING * size).map(|c| island.units[c]));
        true
    }
}
