//! The interior point, and what it stands on.

use super::parts::{Edge, Unit};
use super::unit::{ROWS, UnitSystem};
use crate::iterate::Iterate;
use crate::proximal::ProximalMap;
use crate::task::Task;

/// What the interior point stands on: its velocity and bilateral impulses in an iterate, the system of the proximal map, and the island.
pub(crate) struct Ground<'a> {
    pub map: &'a mut ProximalMap,
    pub iterate: &'a mut Iterate,
    pub task: &'a Task<'a>,
}

/// The interior point with its rates.
#[derive(Clone, Debug, Default)]
pub(super) struct InteriorPoint {
    pub units: Vec<Unit>,
    pub edges: Vec<Edge>,
    /// Of each unit, for the step at hand.
    pub systems: Vec<UnitSystem>,
    /// What each unit's equations lack at a constant velocity, then the rates that its system gives for it.
    pub rates: Vec<[f64; ROWS]>,
    /// What is solved for in a refinement.
    pub work: Vec<f64>,
    /// `M (v − v^f) − Jᵀ λ`.
    pub momentum_residual: Vec<f64>,
    pub bilateral_residual: Vec<f64>,
    pub velocity_rate: Vec<f64>,
    /// How much of the law is Coulomb's: 1, but on the way there from the associated law.
    pub share: f64,
    /// What the normal velocities are larger by, in the part of the law that is not Coulomb's; where this is not zero, that part is
    /// Coulomb's as well.
    pub opening: f64,
}
