//! What a step tells of itself.

use signorini_contact::{Certificate, ConeCertificate, SolveReport, SolveStatus};
use signorini_laws::LeastNormOutcome;

use crate::solver::CertifiedLaw;

/// How a step went.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct StepReport {
    /// How the contact problem ended. The state was advanced unless this is a ray or infeasible.
    pub status: SolveStatus,
    /// The friction law that the certificate speaks of.
    pub law: CertifiedLaw,
    /// Residuals of the laws of this step.
    pub certificate: Certificate,
    /// Residuals of the circular cone's laws, where the settings ask for them: with [`FrictionLaw::Circular`](crate::FrictionLaw)
    /// the same numbers, with `Refined` beside those of the polygon that the directions of the step's problem make.
    pub cone_certificate: Option<ConeCertificate>,
    /// What became of the impulses of least norm, where the settings ask for them.
    pub least_norm: Option<LeastNormOutcome>,
    /// What the solver did, summed over the solves of the step.
    pub solver: SolveReport,
    /// Contacts in the problem, joint limits included.
    pub contacts: usize,
    /// Whether the worst residual exceeds the tolerance, or that of the circular cone's laws exceeds its own.
    pub missed_tolerance: bool,
    /// Whether negative gaps were taken as zero ([`InfeasiblePolicy::ClipGaps`](crate::InfeasiblePolicy::ClipGaps)).
    pub clipped_gaps: bool,
    /// Contacts that restore velocity in this step.
    pub impacts: usize,
    /// Largest |Θ| of the equality constraints at the beginning of the step, m or rad.
    pub constraint_error: f64,
    /// How often contacts were found anew because a body moved farther than expected.
    pub enlargements: u32,
    /// Bodies that turn too fast for Δt for their gyroscopic torque to be integrated; it was left out
    /// ([`unresolved_rotations`](signorini_multibody::FreeMotion::unresolved_rotations)).
    pub unresolved_rotations: usize,
}

impl StepReport {
    /// Whether the state was advanced.
    pub fn advanced(&self) -> bool {
        !matches!(self.status, SolveStatus::Ray { .. } | SolveStatus::Infeasible { .. })
    }
}
