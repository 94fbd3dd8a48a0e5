//! The circular friction cone: formulation §9 on the same [`ContactProblem`](signorini_contact::ContactProblem).
//!
//! - [`CircularConeSolver`] solves the nonlinear complementarity problem itself;
//! - [`DirectionRefiner`] reaches it by linear ones, whose directions it turns into the slip;
//! - [`certify_cone`] judges either, from the data alone;
//! - [`cone_gaps`] says what a polygon's solution misses of the cone's laws, contact by contact.

mod impulse_system;
mod newton;
mod refine;
mod settings;
mod solver;
mod sweeps;
mod system;
mod velocity_system;

pub use refine::{DirectionRefiner, RefinementReport, align_directions};
pub use settings::ConeSettings;
pub use solver::CircularConeSolver;
