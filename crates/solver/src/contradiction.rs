//! Contradictions between gaps, found while iterating.
//!
//! Where contacts demand what no velocity can give, every proximal iteration adds the same self-balanced impulses. If their normal
//! and bilateral parts `d ≥ 0` balance alone, they are a Farkas vector: with `J_Nᵀ d_N + ∇Θᵀ d_B = 0` the sum `d_N · (J_N v + φ/Δt) +
//! d_B · (∇Θ v + Θ/Δt)` is the same for every `v`, and where it is negative no `v` satisfies the rows (formulation §4).

use super::island::Island;
use super::island_solver::IslandSolver;

/// Sums of numbers that cancel to this part of their sizes are zero.
const ROUNDING: f64 = 1e-9;

/// A sum, and that of the sizes of its terms.
#[derive(Clone, Copy, Default)]
struct Sum {
    value: f64,
    terms: f64,
}

impl Sum {
    fn add(&mut self, term: f64) {
        self.value += term;
        self.terms += term.abs();
    }

    fn is_negative(&self) -> bool {
        self.value < -ROUNDING * self.terms
    }
}

impl IslandSolver {
    /// Whether the last change of the impulses proves that the rows contradict each other by more than `tolerance`, relative to
    /// the velocity scale; the units that do are then in `contradiction`. Rows that contradict each other by less have points
    /// that count as solutions.
    pub(super) fn is_contradiction(&mut self, island: &Island, tolerance: f64) -> bool {
        let Some(size) = self.size_of_growth(island) else { return false };
        if !self.is_self_balanced(island, tolerance * self.velocity_scale) {
            return false;
        }
        let contacts = (0..island.contact_count).filter(|&c| self.change[c][0] > ROUNDING * size);
        self.contradiction.extend(contacts.map(|c| island.units[c]));
        true
    }

    /// The largest growth of a normal impulse, if none shrinks.
    fn size_of_growth(&self, island: &Island) -> Option<f64> {
        let normals = || self.change.iter().take(island.contact_count).map(|p| p[0]);
        let size = normals().fold(0.0, f64::max);
        (size > 0.0 && normals().all(|d| d >= -ROUNDING * size)).then_some(size)
    }

    /// Whether the changes of the normal impulses and of the bilateral rows balance each other while they work against the
    /// gaps: for every velocity some row is then violated by at least their mean, the gain by the sum of the changes, which
    /// has to exceed `least`.
    fn is_self_balanced(&mut self, island: &Island, least: f64) -> bool {
        let (mut gain, mut weights) = (Sum::default(), 0.0);
        self.work.fill(0.0);
        self.magnitude.clear();
        self.magnitude.resize(island.nv(), 0.0);
        for c in 0..island.contact_count {
            let d = self.change[c][0].max(0.0);
            gain.add(d * island.offset[c][0]);
            weights += d;
            let (columns, entries) = island.jacobian.group(c);
            for (&k, e) in columns.iter().zip(entries) {
                self.work[k as usize] += d * e[0];
                self.magnitude[k as usize] += (d * e[0]).abs();
            }
        }
        for (k, (&d, offset)) in self.bilateral_change.iter().zip(&island.bilateral_offset).enumerate() {
            gain.add(d * offset);
            weights += d.abs();
            let (columns, entries) = island.bilateral_jacobian.group(k);
            for (&k, e) in columns.iter().zip(entries) {
                self.work[k as usize] += d * e[0];
                self.magnitude[k as usize] += (d * e[0]).abs();
            }
        }
        gain.is_negative()
            && gain.value < -least * weights
            && self.work.iter().zip(&self.magnitude).all(|(sum, size)| sum.abs() <= ROUNDING * size)
    }
}
