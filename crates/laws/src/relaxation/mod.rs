//! Anitescu's convex relaxation of contact with friction: another model, solved exactly, under its own name.
//!
//! Its answers are **not** solutions of the contact laws (formulation §2): the type [`RelaxedSolution`] keeps them apart, and
//! [`RelaxedSolution::contact_laws`] says how far off they are.

mod certificate;
mod residuals;
mod solution;
mod solve;

pub use certificate::certify_relaxation;
pub use residuals::RelaxationCertificate;
pub use solution::{RelaxationReport, RelaxationStatus, RelaxedSolution};
pub use solve::ConvexRelaxation;
