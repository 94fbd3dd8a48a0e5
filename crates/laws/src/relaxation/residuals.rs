//! The residuals of the relaxed model.

/// Residuals of the relaxed model. Each is 0 for an exact solution and relative to the data's own scales (formulation §8), so
/// that it does not change with the units of mass, length or time. It says nothing about the contact laws.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct RelaxationCertificate {
    /// The claimed velocity against the one that the multipliers give: the momentum balance of each kinematic tree by its own
    /// measure, as the contact laws have it, and the velocities of the contact rows.
    pub momentum: f64,
    /// Natural map of the relaxed rows: `|min(g α_k, c_N + φ/Δt + μ d_kᵀc_T)|`, for contacts without directions
    /// `|min(g λ_N, c_N + φ/Δt)|`, at the worse of both velocities.
    pub natural_map: f64,
    /// Distance of the impulses from what the multipliers say: `λ_N = Σ α_k`, `λ_T = μ Σ α_k d_k`.
    pub impulses: f64,
    /// Bilateral rows `∇Θ v⁺ + Θ/Δt`, at the worse of both velocities.
    pub bilateral: f64,
}

impl RelaxationCertificate {
    /// The largest residual; NaN counts as infinite.
    pub fn worst(&self) -> f64 {
        let all = [self.momentum, self.natural_map, self.impulses, self.bilateral];
        all.into_iter().fold(0.0, |worst, r| if r.is_nan() { f64::INFINITY } else { r.max(worst) })
    }

    /// Whether every law of the relaxed model holds within `tolerance`.
    pub fn holds(&self, tolerance: f64) -> bool {
        self.worst() <= tolerance
    }
}
