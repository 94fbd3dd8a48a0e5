//! Whether what is at rest stays: verdicts on a [`ContactProblem`](crate::ContactProblem) at rest, and what proves them.
//!
//! A problem is *at rest* where the velocity before the step is zero and every contact touches: all gaps and violations are 0, and
//! `p = M v^f` is the impulse of the loads during Δt. With `K` the impulses that the laws of friction admit at `v⁺ = 0`,
//!
//! - **balance**: a solution with `v⁺ = 0`, judged by [`certify`](crate::certify) as any other; loads and contact impulses add up to zero;
//! - **mechanism**: a virtual motion `ν` along which every impulse of `K` has less power than the loads ([`certify_mechanism`]). By
//!   Farkas' lemma there is one if and only if there is no balance. It need not be the motion that follows;
//! - **moving solution**: a solution with `v⁺ ≠ 0`.
//!
//! Coulomb's friction is not associated: a balance alone does not exclude a moving solution, and both are found in one problem where
//! friction could carry a preload that nothing provides. That nothing moves is proved in two ways ([`StaysProof`]).

mod mechanism;
mod modes;
mod proof;
mod units;

pub use mechanism::{MechanismCertificate, certify_mechanism};
pub use modes::{ModeBounds, ModeTree, certify_modes};
pub use proof::{
    StabilityProof, StaysProof, Verdict, beside_motion, certify_stability, check_at_rest, energy_part,
    friction_only_resists, without_contact_friction,
};
pub use units::{FrictionUnit, UnitSource, friction_units};
