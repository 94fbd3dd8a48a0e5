//! Laws of contact beside the polygon's, and what a solution leaves open: clients of the structured solver.
//!
//! - [`CircularConeSolver`], [`DirectionRefiner`]: Coulomb's law with the circular cone (formulation §9)
//! - [`ConvexRelaxation`]: Anitescu's relaxation, another model with a result type of its own
//! - [`SettlingSolver`]: convex steps to rest
//! - [`force_distributions`], [`LeastNorm`]: all impulses that give the same velocity, and those of least norm

mod cone;
mod indeterminacy;
mod polyhedral;
mod relaxation;
mod settling;

pub use cone::{CircularConeSolver, ConeSettings, DirectionRefiner, RefinementReport, align_directions};
pub use indeterminacy::{
    ForceDistributions, ImpulseRange, LeastNorm, LeastNormOutcome, LeastNormReport, LinearProgramResidual, SelfStress,
    force_distributions, least_norm_impulses,
};
pub use relaxation::{
    ConvexRelaxation, RelaxationCertificate, RelaxationReport, RelaxationStatus, RelaxedSolution, certify_relaxation,
};
pub use settling::{SettlingEffort, SettlingSolver, SettlingStep};
