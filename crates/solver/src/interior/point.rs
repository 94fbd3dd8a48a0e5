//! The interior point, and what it stands on.

use super::parts::{Edge, Unit};
use super::unit::{ROWS, UnitSystem};
use crate::iterate::Iterate;
use crate::proximal::ProximalMap;
use crate::task::Task;

/// What is tuned in interior starts.
pub(super) struct Tuning {
    /// Steps at most.
    pub steps: u32,
    /// The mean product at which the steps end, relative to the first one. Further steps would save changes of modes that take less
    /// time than they.
    pub target: f64,
    /// The same of a path around folds.
    pub path_target: f64,
    /// Part of the way to the boundary that a step goes at most.
    pub fraction: f64,
    /// The mean product, relative to the first one, above which a path that folds is followed around its folds, as far as to this one.
    pub folded: f64,
    /// Compliance of every contact around its present impulse, relative to its Delassus block: redundant contacts have a regular
    /// system with it, and at the end nothing depends on it. What the equations lack falls with it, and what rounding leaves in the
    /// momentum balance grows: one refinement leaves about a thousandth of that, at 1e-10 a tenth.
    pub compliance: f64,
    /// ε of the bilateral rows.
    pub bilateral_weight: f64,
}

/// Chosen by: `contact_lcp --seeds 74..76 --directions 4,8,16 --no-growth --no-shared`, 23 November 2026; `compliance` and
/// `bilateral_weight` by no command on record, since 22 November 2026.
pub(super) const INTERIOR: Tuning = Tuning {
    steps: 50,
    target: 1e-7,
    path_target: 1e-11,
    fraction: 0.99,
    folded: 1e-4,
    compliance: 1e-8,
    bilateral_weight: 1e-4,
};

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
}
