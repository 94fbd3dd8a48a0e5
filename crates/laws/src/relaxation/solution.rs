//! What a convex relaxation ends with.

use signorini_contact::certificate::{Certificate, certify};
use signorini_contact::projection::Cones;
use signorini_contact::recovery::recover_into;
use signorini_contact::{ContactProblem, ContactSolution, UnsupportedFriction};

use super::residuals::RelaxationCertificate;
use crate::SelfStress;

/// How a relaxation ended.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum RelaxationStatus {
    /// Every residual of the [`RelaxationCertificate`] is within the tolerance.
    #[default]
    Solved,
    /// The best point found; its residuals exceed the tolerance.
    Inaccurate,
    /// No velocity satisfies all rows. The proof (Farkas 1902): impulses `y` of the friction cones with `Jᵀy = 0` that would
    /// do work against the gaps, `Σ y_N φ/Δt + Σ y_B Θ/Δt < 0`.
    Inconsistent {
        /// The impulses; their largest entry has size 1.
        proof: SelfStress,
    },
    /// The relaxation has no rows for friction that the problem has; nothing was solved.
    Unsupported(UnsupportedFriction),
}

/// What a relaxation took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct RelaxationReport {
    /// Groups of coupled bodies.
    pub groups: u32,
    /// Proximal iterations.
    pub iterations: u32,
    /// LU factorisations.
    pub factorizations: u32,
}

/// The solution of the convex relaxation of a contact problem. Not a solution of the contact laws where anything slides.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct RelaxedSolution {
    /// Next velocity of the relaxed model, `[nv]`, m/s or rad/s.
    pub velocity: Vec<f64>,
    /// Impulses (normal, tangent 1, tangent 2), `[nc]`, N·s.
    pub impulse: Vec<[f64; 3]>,
    /// Multipliers of the relaxed rows, `[m]`, N·s: `λ_N = Σ_k α_k` and `λ_T = μ Σ_k α_k d_k` for each contact with
    /// directions. These are not the `α` of the LCP.
    pub alpha: Vec<f64>,
    /// Impulses of the bilateral rows, `[nb]`, N·s or N·m·s.
    pub bilateral: Vec<f64>,
    /// How the solve ended.
    pub status: RelaxationStatus,
    /// Residuals of the relaxed model, computed from the data.
    pub certificate: RelaxationCertificate,
    /// What was done.
    pub report: RelaxationReport,
}

impl RelaxedSolution {
    /// The residuals of the true contact laws (formulation §8) of these velocity and impulses. `signorini` shows the
    /// relaxation's artefact: for a sliding contact it is `min(g λ_N, μ ‖c_T‖)` relative to `max|b|`. Infinite for a problem
    /// with friction groups.
    pub fn contact_laws(&self, problem: &ContactProblem) -> Certificate {
        let mut claimed = ContactSolution::default();
        claimed.prepare(problem);
        let sizes_fit = self.velocity.len() == problem.nv() && self.impulse.len() == problem.contact_count();
        if !sizes_fit || problem.check_without_groups().is_err() {
            return Certificate::everything_violated();
        }
        let mut cones = Cones::default();
        cones.prepare(problem);
        claimed.velocity.clone_from(&self.velocity);
        claimed.impulse.clone_from(&self.impulse);
        claimed.bilateral.clone_from(&self.bilateral);
        recover_into(problem, &cones, problem.velocity_scale(), &mut claimed);
        certify(problem, &claimed)
    }

    /// Zero impulses of the right sizes, and a fresh report.
    pub(super) fn prepare(&mut self, problem: &ContactProblem) {
        self.velocity.clone_from(&problem.free_velocity);
        self.impulse.clear();
        self.impulse.resize(problem.contact_count(), [0.0; 3]);
        self.alpha.clear();
        self.alpha.resize(problem.direction_count(), 0.0);
        self.bilateral.clear();
        self.bilateral.resize(problem.bilateral_violation.len(), 0.0);
        self.status = RelaxationStatus::Solved;
        self.report = RelaxationReport::default();
    }
}
