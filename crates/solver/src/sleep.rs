//! Islands at rest: the impulses of the last step still hold them, so there is nothing to solve.

use super::SolverSettings;
use super::island::Island;
use super::island_solver::{IslandSolver, law_residual};
use signorini_contact::ContactProblem;
use signorini_contact::projection::Cones;

/// Part of the momenta that meet in a degree of freedom by which their sum may differ from zero.
const BALANCED: f64 = 1e-11;

impl IslandSolver {
    /// Whether the impulses of the warm start hold the island still: then its velocity is zero, and the residual of the contact
    /// laws comes out. Nothing is remembered from step to step, so that any change wakes the island: a new contact, an input, a
    /// body that moves.
    ///
    /// In every degree of freedom `(M v^f + Jᵀλ)_k = 0` up to rounding of its terms, and the laws hold both at rest and at the
    /// velocity that the impulses give.
    pub fn rest(
        &mut self,
        problem: &ContactProblem,
        cones: &Cones,
        island: &Island,
        settings: &SolverSettings,
    ) -> Option<f64> {
        if !self.is_balanced(problem, island) {
            return None;
        }
        let at_rest = self.residual_at_rest(cones, island);
        self.set_weights(island, settings.proximal_weight);
        let residual = self.evaluate_centre(problem, cones, island).max(at_rest);
        self.velocity.fill(0.0);
        (residual <= settings.accept).then_some(residual)
    }

    /// Whether `M v^f` and the impulses cancel.
    fn is_balanced(&mut self, problem: &ContactProblem, island: &Island) -> bool {
        self.work.fill(0.0);
        island.multiply_mass(&problem.mass, &self.free_velocity, &mut self.work);
        self.load.clear();
        self.load.extend(self.work.iter().map(|p| p.abs()));
        for (c, &p) in self.impulse.iter().enumerate() {
            let p = island.pushing(c, p);
            // An impulse is one vector: friction that should be zero is rounding of the normal part.
            let largest = p[0].abs().max(p[1].abs()).max(p[2].abs());
            let (columns, entries) = island.jacobian.group(c);
            for (&k, e) in columns.iter().zip(entries) {
                self.work[k as usize] += e[0] * p[0] + e[1] * p[1] + e[2] * p[2];
                self.load[k as usize] += largest * (e[0].abs() + e[1].abs() + e[2].abs());
            }
        }
        for (k, &p) in self.bilateral_impulse.iter().enumerate() {
            let (columns, entries) = island.bilateral_jacobian.group(k);
            for (&k, [e]) in columns.iter().zip(entries) {
                self.work[k as usize] += e * p;
                self.load[k as usize] += (e * p).abs();
            }
        }
        self.work.iter().zip(&self.load).all(|(sum, load)| sum.abs() <= BALANCED * load)
    }

    /// Residual of the contact laws at velocity zero, relative to the island's velocity scale.
    fn residual_at_rest(&self, cones: &Cones, island: &Island) -> f64 {
        let law = |(c, &i): (usize, &u32)| {
            let u = island.pushing(c, island.offset[c]);
            law_residual(cones, i as usize, self.impulse[c], u, island.residual_scale)
        };
        let contacts = island.units.iter().enumerate().map(law);
        let worst = contacts.chain(island.bilateral_offset.iter().map(|u| u.abs())).fold(0.0, f64::max);
        if self.velocity_scale > 0.0 { worst / self.velocity_scale } else { 0.0 }
    }
}
