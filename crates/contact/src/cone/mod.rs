//! The circular friction cone: formulation §9 on the same [`ContactProblem`](crate::ContactProblem).
//!
//! - [`CircularConeSolver`] solves the nonlinear complementarity problem itself;
//! - [`DirectionRefiner`] reaches it by linear ones, whose directions it turns into the slip;
//! - [`certify_cone`] judges either, from the data alone;
//! - [`cone_gaps`] says what a polygon's solution misses of the cone's laws, contact by contact.

mod certificate;
mod gap;
mod impulse_system;
mod law;
mod newton;
mod refine;
mod settings;
mod solution;
mod solver;
mod sweeps;
mod system;
mod velocity_system;

pub use certificate::{ConeCertificate, certify_cone};
pub use gap::{ConeGap, cone_gaps, velocity_error_bound};
pub use refine::{DirectionRefiner, RefinementReport, align_directions};
pub use settings::ConeSettings;
pub use solution::{ConeReport, ConeSolution, ConeStart, ConeStatus, ConeWarmStart};
pub use solver::CircularConeSolver;
