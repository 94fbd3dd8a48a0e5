//! Settings of a verdict.

use derive_setters::Setters;
use signorini_simulation::{Settings, SimulationError};

use crate::attraction::Attraction;

/// Settings of a verdict.
#[derive(Clone, Debug, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct StabilitySettings {
    /// Gap up to which shapes and limits touch, m or rad. Default 1e-6.
    pub contact_tolerance: f64,
    /// A proof holds when its residuals are at most this, and a solution is one when its certificate is. Default 1e-9; in (0, 1).
    pub tolerance: f64,
    /// The same of a balance, whose loads differ from those of the data by this part at most. Default 1e-11; in (0, 1).
    pub balance_tolerance: f64,
    /// Loads that are perturbed in the search for a moving solution; one where there are more than 1000 contacts. Default 8.
    pub perturbations: u32,
    /// Contacts at most with which moving solutions are searched for; with more, forces that need friction earn `stands` without a search.
    /// Default 3000.
    pub search_contacts: usize,
    /// Linear programs that the complete enumeration of modes may take, at most; 0 for none. Default 1000.
    pub enumeration_programs: usize,
    /// Rows of the complementarity problem at most that modes are enumerated of. Default 240.
    pub enumeration_rows: usize,
    /// What holds bodies together where they touch. Default nothing.
    pub attraction: Vec<Attraction>,
    /// How contact problems are made of a model: friction directions, time step.
    pub simulation: Settings,
}

impl StabilitySettings {
    /// Checks the ranges of the tolerances.
    ///
    /// # Errors
    /// [`SimulationError::Setting`].
    pub fn validate(&self) -> Result<(), SimulationError> {
        let check = |setting, found: f64, expected, ok: bool| {
            if ok { Ok(()) } else { Err(SimulationError::Setting { setting, expected, found }) }
        };
        let touching = self.contact_tolerance;
        check("contact_tolerance", touching, "finite and not negative", touching >= 0.0 && touching.is_finite())?;
        let tolerances = [("tolerance", self.tolerance), ("balance_tolerance", self.balance_tolerance)];
        tolerances.into_iter().try_for_each(|(name, x)| check(name, x, "in (0, 1)", x > 0.0 && x < 1.0))
    }
}

impl Default for StabilitySettings {
    fn default() -> Self {
        Self {
            contact_tolerance: 1e-6,
            tolerance: 1e-9,
            balance_tolerance: 1e-11,
            perturbations: 8,
            search_contacts: 3000,
            enumeration_programs: 1000,
            enumeration_rows: 240,
            attraction: Vec::new(),
            simulation: Settings::default(),
        }
    }
}
