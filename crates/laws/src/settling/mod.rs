//! Steps of what is to come to rest: convex contact problems around the impulses of the last step.
//!
//! Coulomb's law bounds the friction of a step by the normal impulses of the same step, which makes the steps of a settling pile
//! hard. Here a contact's friction is bounded by the normal impulse that it had in the step before; one that is new has the
//! associated law (Anitescu's). Both have projections that are gradients of convex functions ([`law`]), so that a step
//!
//! ```text
//! v⁺ = argmin ½ (v − v^f)ᵀ M (v − v^f) + Σ_c 1/(2ρ_c) ‖P_c(λ̄_c − ρ_c u_c)‖²,     u = J v + (φ/Δt, 0, 0),     λ = P(λ̄ − ρ u),
//! ```
//!
//! with `ρ_c = 1/(ε g_c)` as in the proximal iterations of the exact solver, is found by Newton's method with a line search
//! ([`descent`]) from anywhere, and from the last step's velocity in a few factorisations. One such problem is one iteration of
//! the augmented Lagrangian: around other impulses than its own its contacts give way by `ε g |λ − λ̄|`.
//!
//! What such steps lead to is exact nevertheless. Where they end with `v = 0` and the impulses of the step before, every
//! friction is bounded by its own normal impulse and nothing gives way: Coulomb's laws hold. On the way there the motion is none
//! of Coulomb's.

mod descent;
mod effort;
mod law;

pub use effort::SettlingEffort;

use crate::polyhedral::ImpulseCones;
use descent::Descent;
use signorini_contact::WarmStart;
use signorini_contact::projection::Cones;
use signorini_contact::{ContactProblem, ContactSolution, UnsupportedFriction};
use signorini_solver::{Island, Islands, ProximalSystem};

/// A step towards rest. No solution of the contact laws, unless it rests.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct SettlingStep {
    /// Next velocity, `[nv]`, m/s or rad/s.
    pub velocity: Vec<f64>,
    /// The impulses, as a start of the next step or of an exact solve: of the rest of this solution nothing is set.
    pub impulses: ContactSolution,
    /// By how much contacts and bilateral rows give way because the impulses were others in the step before, m/s.
    pub slack: f64,
    /// Factorisations of all islands, and the most that one of them took.
    pub factorizations: u32,
    /// See `factorizations`.
    pub most_factorizations: u32,
}

/// Solves the problems of steps towards rest; memory is reused.
#[derive(Clone, Debug, Default)]
pub struct SettlingSolver {
    cones: Cones,
    associated: ImpulseCones,
    islands: Islands,
    system: ProximalSystem,
    descent: Descent,
}

impl SettlingSolver {
    /// Makes a step.
    ///
    /// - `earlier`: impulses of the step before; what they leave out is new
    /// - `start`: where the search for the velocity begins, `[nv]`
    ///
    /// # Errors
    /// [`UnsupportedFriction::Groups`] for friction that is no contact's sliding.
    ///
    /// # Panics
    /// If `start` has another length.
    pub fn step_into(
        &mut self,
        problem: &ContactProblem,
        earlier: &WarmStart,
        start: &[f64],
        effort: SettlingEffort,
        step: &mut SettlingStep,
    ) -> Result<(), UnsupportedFriction> {
        assert_eq!(start.len(), problem.nv(), "the start belongs to another problem");
        problem.check_without_groups()?;
        self.cones.prepare(problem);
        self.associated.prepare(problem, |_| Some(|_| true));
        self.islands.find(problem);
        self.islands.assemble(problem, |_| true);
        step.velocity.clone_from(&problem.free_velocity);
        step.impulses.drop_impulses(problem);
        (step.slack, step.factorizations, step.most_factorizations) = (0.0, 0, 0);
        let islands = std::mem::take(&mut self.islands);
        for island in islands.all() {
            self.move_island(problem, island, earlier, start, effort, step);
        }
        self.islands = islands;
        Ok(())
    }

    fn move_island(
        &mut self,
        problem: &ContactProblem,
        island: &Island,
        earlier: &WarmStart,
        start: &[f64],
        effort: SettlingEffort,
        step: &mut SettlingStep,
    ) {
        let Self { cones, associated, system, descent, .. } = self;
        descent.begin(problem, island, earlier, start, effort);
        system.analyse(problem, island);
        system.prepare(problem, island, &descent.bilateral_weight);
        let factorizations = descent.run((problem, island), (cones, associated), system, effort.newton_steps);
        step.factorizations += factorizations;
        step.most_factorizations = step.most_factorizations.max(factorizations);
        step.slack = step.slack.max(descent.slack());
        island.scatter(&descent.velocity, &mut step.velocity);
        for (&i, &impulse) in island.units.iter().zip(&descent.impulse) {
            step.impulses.take_unit(i as usize, impulse, cones.mode_at(i as usize, impulse));
        }
        for (&k, &impulse) in island.bilateral.iter().zip(&descent.bilateral_impulse) {
            step.impulses.bilateral[k as usize] = impulse;
        }
    }
}
