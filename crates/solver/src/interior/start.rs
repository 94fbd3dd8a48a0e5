//! A start for the exact iterations of a large island: an interior-point method on the laws themselves.
//!
//! Every law is a pair of complementary numbers: of a contact its impulse `λ_N` and its slack `s = u_N`, and of every edge of its
//! polygon, with outward unit normal `n` at the distance `h` for radius 1, the distance `w = μ h λ_N − n·λ_T` and its multiplier
//! `γ` in the conditions of maximum dissipation, `u_T + Σ γ n = 0` (formulation §3). Newton's method on the equations with all
//! products equal to a target that goes to zero keeps all of these numbers positive; predictor and corrector are Mehrotra's
//! (1992), with one factorisation for both. Eliminating all but the velocity leaves `M + Σ Jᵀ S J`, which has the blocks of the
//! proximal system, and the number of steps hardly grows with that of the contacts.
//!
//! Coulomb's law is not monotone: the central path may turn back before it arrives, and then the steps become short. Where that is late,
//! the modes are read off there. Where it is early, the path is followed [around its folds](super::path) instead, from the
//! associated law.
//!
//! Near the end a contact that slides is so close to an edge, and one that sticks so stiff, that rates found as differences of
//! velocities or of impulses would be rounding. The units' [systems](super::unit) have the multipliers of close edges as
//! unknowns beside the impulse, slacks follow from the products, and on the [central path](super::path), which goes
//! on to much smaller products, the momentum balance is [refined](InteriorPoint::find_rates): its equations hold to a small part of
//! the velocity scale all the way.
//!
//! Where the path ends, most contacts are in the modes of a solution. Its impulses are never an answer: the exact iterations begin there.

use super::parts::{Edge, Unit};
use super::path::PathSteps;
use super::point::{Ground, INTERIOR, InteriorPoint};
use crate::islands::Island;
use crate::residual::RESIDUALS;

/// Memory of the interior start.
#[derive(Clone, Debug, Default)]
pub(crate) struct InteriorStart {
    pub(super) point: InteriorPoint,
    path: PathSteps,
}

impl InteriorStart {
    /// Moves the impulses near a solution and reads the modes off there. `false` if the path did not arrive, or a system is singular.
    pub fn run(&mut self, ground: &mut Ground) -> bool {
        self.point.start(ground, &mut self.path)
    }
}

impl InteriorPoint {
    fn start(&mut self, ground: &mut Ground, path: &mut PathSteps) -> bool {
        self.begin(ground);
        let Some(fold) = self.go_on(ground) else { return false };
        let follows = fold > INTERIOR.folded && is_contacts_alone(ground.task.island) && !ground.task.is_warm;
        if follows && !self.come_along_path(ground, path) {
            return false;
        }
        self.leave(ground);
        true
    }

    /// Goes along the [central path](super::path) from a point of the associated law's; whether its products become as small as those of a
    /// path that does not fold early.
    pub(super) fn come_along_path(&mut self, ground: &mut Ground, path: &mut PathSteps) -> bool {
        self.begin(ground);
        let square = ground.map.velocity_scale.powi(2);
        self.share = 0.0;
        for _ in 0..INTERIOR.steps {
            let (product, missing) = self.find_residuals(ground);
            if product <= square && missing <= RESIDUALS.far * ground.map.velocity_scale {
                break;
            }
            if !self.find_direction(ground, product) {
                return false;
            }
            let step = self.longest_step(INTERIOR.fraction);
            self.advance(ground, step);
        }
        self.follow(ground, (square, INTERIOR.path_target * square), path);
        self.share >= 1.0 && self.find_residuals(ground).0 <= INTERIOR.folded * square
    }

    /// Goes to smaller products until they are small enough, or until the path ends. Returns the product where the path of Coulomb's law
    /// folds, relative to the squared velocity scale, or zero; nothing if a system is singular.
    pub(super) fn go_on(&mut self, ground: &mut Ground) -> Option<f64> {
        let scale = ground.map.velocity_scale;
        let (mut steps, mut short) = (0, 0);
        loop {
            let (product, missing) = self.find_residuals(ground);
            if product <= INTERIOR.target * scale * scale && missing <= RESIDUALS.far * scale {
                return Some(0.0);
            }
            if !self.find_direction(ground, product) {
                return None;
            }
            let step = self.longest_step(INTERIOR.fraction);
            self.advance(ground, step);
            steps += 1;
            short = if step < RESIDUALS.slow { short + 1 } else { 0 };
            if short == 2 || steps == INTERIOR.steps {
                return Some(product / (scale * scale));
            }
        }
    }

    /// The direction of the next step; `false` if its system is singular.
    fn find_direction(&mut self, ground: &mut Ground, product: f64) -> bool {
        let island = ground.task.island;
        self.find_slopes(island);
        ground.map.effort.factorizations += 1;
        if !ground.map.system.factor_slopes(island, |c| Some(self.units[c].slope)) {
            return false;
        }
        self.find_rates(ground, 0.0, false);
        let affine = self.longest_step(1.0);
        let centring = (self.product_after(island, affine) / product).powi(3).min(1.0);
        self.correct(affine);
        self.find_rates(ground, centring * product, false);
        true
    }

    /// The start: at the free velocity, with every product equal to the squared velocity scale over the Delassus scale.
    pub(super) fn begin(&mut self, ground: &mut Ground) {
        let (cones, island) = (ground.task.cones, ground.task.island);
        ground.map.set_weights(island, INTERIOR.bilateral_weight);
        ground.map.prepare(ground.task);
        ground.iterate.velocity.clone_from(&ground.map.free_velocity);
        ground.iterate.bilateral.fill(0.0);
        self.share = 1.0;
        self.units.clear();
        self.edges.clear();
        for c in 0..island.units.len() {
            let (i, g) = (island.units[c] as usize, island.scale[c]);
            let has_normal = c < island.contact_count;
            let bounded_by = match c.checked_sub(island.contact_count).map(|k| island.bounded_by[k] as usize) {
                None => Some(c),
                Some(by) => (by != c).then_some(by),
            };
            let typical = ground.map.velocity_scale / g;
            let bound = match bounded_by {
                Some(by) => ground.map.velocity_scale / island.scale[by],
                None => ground.iterate.impulse[c][0],
            };
            let first = self.edges.len();
            if bound > 0.0 {
                cones.interior_edges(i, |normal, reach| {
                    let distance = reach * bound;
                    let multiplier = ground.map.velocity_scale * typical / distance;
                    let (distance_rate, multiplier_rate, correction) = (0.0, 0.0, 0.0);
                    self.edges.push(Edge {
                        normal,
                        reach,
                        distance,
                        multiplier,
                        distance_rate,
                        multiplier_rate,
                        correction,
                        place: None,
                    });
                });
            }
            self.units.push(Unit {
                edges: (first, self.edges.len()),
                bounded_by,
                row_factor: bounded_by.map_or(1.0, |by| g / island.scale[by]),
                has_normal,
                compliance: INTERIOR.compliance * g,
                impulse: [bound, 0.0, 0.0],
                slack: ground.map.velocity_scale,
                ..Unit::default()
            });
        }
    }

    /// Reads the modes off and puts the centre on their cones.
    fn leave(&self, ground: &mut Ground) {
        let Ground { map, iterate, task } = ground;
        iterate.impulse.clear();
        iterate.impulse.extend(self.units.iter().map(|unit| unit.impulse));
        iterate.set_bounds(task.problem, task.island);
        iterate.velocity.clear();
        // This weight compares impulses with slacks as the natural map does.
        map.set_weights(task.island, 1.0);
        map.evaluate_centre(task, iterate);
        map.guess_modes(task, &mut iterate.modes);
        for (c, &i) in task.island.units.iter().enumerate() {
            iterate.impulse[c] = task.cones.project(i as usize, iterate.modes[c], iterate.impulse[c]);
        }
        iterate.set_bounds(task.problem, task.island);
        iterate.velocity.clear();
    }
}

/// Whether friction is that of contacts alone: only theirs has an associated law.
fn is_contacts_alone(island: &Island) -> bool {
    island.contact_count == island.units.len()
}

#[cfg(test)]
mod tests;
