//! Settings of the solver for the circular cone.

use derive_setters::Setters;
use signorini_contact::ProblemError;

/// Settings of the solver for the circular cone. Tolerances are relative to the data's velocity scale.
#[derive(Clone, Debug, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct ConeSettings {
    /// A solution is `Solved` when every residual of the certificate is at most this. Default 1e-9; range (0, 1).
    pub tolerance: f64,
    /// Newton's iterations stop at this residual. Default 1e-12; range (0, 1).
    pub polish: f64,
    /// ε of the proximal term, relative to each contact's Delassus block. Default 1e-3; range (0, 1).
    pub proximal_weight: f64,
    /// ε is lowered to this where the iterations converge slowly. Default 1e-10; range (0, 1).
    pub smallest_proximal_weight: f64,
    /// Proximal iterations from one start, at most. Default 60; at least 1.
    pub max_proximal_iterations: u32,
    /// Newton steps on one proximal problem, at most. Default 12; at least 1.
    pub max_newton_iterations: u32,
    /// Proximal problems that Newton's steps leave unsolved, or that do not lower the residual, from one start. Default 6.
    pub max_failures: u32,
    /// Rounds of direction refinement before Newton's method is tried again. Default 8.
    pub refinement_rounds: u32,
    /// Sweeps over all contacts before Newton's method is tried again. Default 300.
    pub sweeps: u32,
    /// How often sweeps and Newton's method take turns. Default 4.
    pub sweep_rounds: u32,
}

impl Default for ConeSettings {
    fn default() -> Self {
        Self {
            tolerance: 1e-9,
            polish: 1e-12,
            proximal_weight: 1e-3,
            smallest_proximal_weight: 1e-10,
            max_proximal_iterations: 60,
            max_newton_iterations: 12,
            max_failures: 6,
            refinement_rounds: 8,
            sweeps: 300,
            sweep_rounds: 4,
        }
    }
}

impl ConeSettings {
    /// The same for another [`tolerance`](Self::tolerance), with [`polish`](Self::polish) no larger than it.
    pub fn for_tolerance(self, tolerance: f64) -> Self {
        Self { tolerance, polish: self.polish.min(tolerance), ..self }
    }

    /// Checks the ranges.
    ///
    /// # Errors
    /// [`ProblemError::Number`] naming the setting.
    pub fn validate(&self) -> Result<(), ProblemError> {
        for (array, value) in [
            ("tolerance", self.tolerance),
            ("polish", self.polish),
            ("proximal_weight", self.proximal_weight),
            ("smallest_proximal_weight", self.smallest_proximal_weight),
        ] {
            if !(value > 0.0 && value < 1.0) {
                return Err(ProblemError::Number { array, index: 0, value, expected: "between 0 and 1" });
            }
        }
        for (array, value) in [
            ("max_proximal_iterations", self.max_proximal_iterations),
            ("max_newton_iterations", self.max_newton_iterations),
        ] {
            if value == 0 {
                return Err(ProblemError::Number { array, index: 0, value: 0.0, expected: "at least 1" });
            }
        }
        Ok(())
    }
}
