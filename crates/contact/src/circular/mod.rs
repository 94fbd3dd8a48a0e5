//! The circular friction cone: Coulomb's law of formulation §9, solutions with it, and their certificate.

mod certificate;
mod gap;
mod law;
mod solution;

pub use certificate::{certify_cone, certify_cone_with, cone_velocity_scale};
pub use gap::{ConeGap, cone_gaps, half_widest_angle, velocity_error_bound};
pub use law::CoulombLaw;
pub use solution::{ConeReport, ConeSolution, ConeStart, ConeStatus, ConeWarmStart};
