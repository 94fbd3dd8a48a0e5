//! What a step tells of itself.

use signorini_contact::{Certificate, ResidualSpread, SolveReport, SolveStatus};
use signorini_laws::LeastNormOutcome;

use crate::solver::CertifiedLaw;

/// How a step went.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct StepReport {
    /// How the contact problem ended. The state was advanced unless this is a ray or infeasible.
    pub status: SolveStatus,
    /// The friction law that the certificate speaks of.
    pub law: CertifiedLaw,
    /// Residuals of the laws of this step.
    pub certificate: Certificate,
    /// Where the residual is of a step whose budget ([`Settings::budget`](crate::Settings::budget)) was used up.
    pub spread: Option<ResidualSpread>,
    /// Residuals of the circular cone's laws, where the settings ask for them: with [`FrictionLaw::Circular`](crate::FrictionLaw)
    /// the same numbers, with `Refined` beside those of the polygon that the directions of the step's problem make.
    pub cone_certificate: Option<Certificate>,
    /// What became of the impulses of least norm, where the settings ask for them.
    pub least_norm: Option<LeastNormOutcome>,
    /// What the solver did, summed over the solves of the step.
    pub solver: SolveReport,
    /// Contact problems that were solved, or tried: more than one where the corrections had to be limited, contacts were found anew, or
    /// an impact has a decompression.
    pub solves: u32,
    /// Contacts in the problem, joint limits included.
    pub contacts: usize,
    /// Whether the worst residual exceeds the tolerance, or that of the circular cone's laws exceeds its own.
    pub missed_tolerance: bool,
    /// Part θ of the overlaps and violations asked for that this step removes: 1 where it is all of them, less where the laws permit
    /// no more or their energy would exceed its bound. The certificate is that of the gaps `max(φ, θφ)` and violations `θΘ`.
    pub theta: f64,
    /// What was kept where `theta` is less than 1.
    pub kept: Vec<Kept>,
    /// Work of the impulses along the corrections, J: at least the kinetic energy that corrections put in, and what they lift.
    pub correction_energy: f64,
    /// Contact points that overlap and that no degree of freedom moves along their normal; they are not in the problem
    /// ([`Workspace::left_out`](crate::Workspace::left_out)).
    pub left_out: usize,
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

/// An overlap or violation that a step was not permitted to remove.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kept {
    /// The row it belongs to.
    pub row: KeptRow,
    /// What is left of it by this step's laws, m or rad (≥ 0).
    pub size: f64,
}

/// A row of a step's problem whose overlap or violation was kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeptRow {
    /// A contact or limit, by its index in the problem.
    Contact(usize),
    /// A bilateral row, by its index in the problem.
    Bilateral(usize),
}

impl Default for StepReport {
    fn default() -> Self {
        Self {
            status: SolveStatus::default(),
            law: CertifiedLaw::default(),
            certificate: Certificate::default(),
            spread: None,
            cone_certificate: None,
            least_norm: None,
            solver: SolveReport::default(),
            solves: 0,
            contacts: 0,
            missed_tolerance: false,
            theta: 1.0,
            kept: Vec::new(),
            correction_energy: 0.0,
            left_out: 0,
            clipped_gaps: false,
            impacts: 0,
            constraint_error: 0.0,
            enlargements: 0,
            unresolved_rotations: 0,
        }
    }
}

impl StepReport {
    /// Whether the state was advanced.
    pub fn advanced(&self) -> bool {
        !matches!(self.status, SolveStatus::Ray { .. } | SolveStatus::Infeasible { .. })
    }
}
