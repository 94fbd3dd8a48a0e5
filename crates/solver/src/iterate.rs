//! What goes from stage to stage.

use signorini_contact::ContactProblem;
use signorini_contact::projection::Mode;

use crate::islands::Island;
use crate::residual::RESIDUALS;

/// Impulses of an island, and what is known of them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Iterate {
    /// Of each unit, N·s or N·m·s; the first component of a friction group's is what bounds it.
    pub impulse: Vec<[f64; 3]>,
    /// Of each bilateral row.
    pub bilateral: Vec<f64>,
    /// Of each unit; none where nothing is known of them.
    pub modes: Vec<Mode>,
    /// The velocity that goes with the impulses; none where it is not computed. With a residual it is the one that was measured, which
    /// may be refined beyond what the impulses express.
    pub velocity: Vec<f64>,
    /// What the laws lack, relative to the island's velocity scale; infinite where that is not measured.
    pub residual: f64,
}

impl Iterate {
    /// No impulses, nothing known.
    pub fn clear(&mut self, problem: &ContactProblem, island: &Island) {
        self.impulse.clear();
        self.impulse.resize(island.units.len(), [0.0; 3]);
        self.set_bounds(problem, island);
        self.bilateral.clear();
        self.bilateral.resize(island.bilateral.len(), 0.0);
        self.modes.clear();
        self.velocity.clear();
        self.residual = f64::INFINITY;
    }

    /// Sets the first component of the friction groups' impulses to what bounds them.
    pub fn set_bounds(&mut self, problem: &ContactProblem, island: &Island) {
        for c in island.contact_count..island.units.len() {
            let j = island.units[c] as usize - problem.contact_count();
            self.impulse[c][0] = problem.friction_groups.bound[j].constant();
        }
        island.bind(&mut self.impulse);
    }

    /// Takes over impulses, modes and residual of another one.
    pub fn copy_impulses(&mut self, other: &Self) {
        self.impulse.clone_from(&other.impulse);
        self.bilateral.clone_from(&other.bilateral);
        self.modes.clone_from(&other.modes);
        self.residual = other.residual;
    }

    /// Whether all that the laws lack is what the last digits of any impulses that give this velocity make in it, more than the tolerance allows.
    pub fn is_out_of_digits(&self, problem: &ContactProblem, island: &Island, tolerance: f64) -> bool {
        if self.residual > RESIDUALS.far || self.velocity.len() != island.nv() {
            return false;
        }
        let digits = self.least_rounding(problem, island);
        digits > RESIDUALS.rounded * tolerance && self.residual <= RESIDUALS.rounded * digits
    }

    /// What rounding of the impulses makes at least in the velocity of a contact, relative to the velocity scale, whichever impulses give this
    /// velocity.
    ///
    /// On the change `Δv` from the free velocity they do the work `Δvᵀ M Δv = Σ λ·JΔv`, however they balance each other: for some of them
    /// `g λ` is at least this work over `Σ |JΔv|/g`, with `g` of the contact's own bodies.
    fn least_rounding(&self, problem: &ContactProblem, island: &Island) -> f64 {
        let (mut change, mut momentum) = (Vec::new(), vec![0.0; island.nv()]);
        island.gather(&problem.free_velocity, &mut change);
        change.iter_mut().zip(&self.velocity).for_each(|(free, v)| *free = v - *free);
        island.multiply_mass(&problem.mass, &change, &mut momentum);
        let work: f64 = change.iter().zip(momentum).map(|(v, p)| v * p).sum();
        let unit =
            |c: usize| island.pushing(c, island.jacobian.multiply(c, &change)).iter().map(|u| u.abs()).sum::<f64>();
        let row = |k: usize| island.bilateral_jacobian.multiply(k, &change)[0].abs();
        let units: f64 = island.scale.iter().enumerate().map(|(c, g)| unit(c) / g).sum();
        let rows: f64 = island.bilateral_scale.iter().enumerate().map(|(k, g)| row(k) / g).sum();
        let size = (units + rows) * island.velocity_scale.value();
        if size > 0.0 { f64::EPSILON * work / size } else { 0.0 }
    }

    /// The largest impulse in units of the one that changes the lightest contact's velocity by the velocity scale.
    pub fn largest_impulse(&self, island: &Island) -> f64 {
        relative_impulse(&self.impulse, island)
    }
}

/// The largest of some impulses of an island's units, in units of the one that changes the lightest contact's velocity by the velocity scale.
pub(crate) fn relative_impulse(impulses: &[[f64; 3]], island: &Island) -> f64 {
    let size = impulses.iter().flatten().fold(0.0, |most: f64, p| most.max(p.abs()));
    let scale = island.scale.iter().copied().fold(0.0, f64::max);
    let velocity = island.velocity_scale.value();
    if velocity > 0.0 { size * scale / velocity } else { 0.0 }
}

/// Counters of one island's solve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Effort {
    pub factorizations: u32,
    pub mode_changes: u32,
    pub proximal_iterations: u32,
    pub pivots: u32,
    pub sweeps: u32,
}

impl Effort {
    /// Adds another one.
    pub fn add(&mut self, other: Self) {
        self.factorizations += other.factorizations;
        self.mode_changes += other.mode_changes;
        self.proximal_iterations += other.proximal_iterations;
        self.pivots += other.pivots;
        self.sweeps += other.sweeps;
    }
}
