//! What is asked of a settling, and what it tells.

use derive_setters::Setters;

use crate::SimulationError;
use crate::report::StepReport;

/// How a state is brought to rest.
#[derive(Clone, Debug, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct SettleSettings {
    /// Steps at most. Default 2000.
    pub max_steps: u32,
    /// Δt of these steps, s, or `None` for four times that of the simulation. What falls freely falls by `g Δt²` in a step; that
    /// should be some percent of a body's size.
    #[setters(into)]
    pub timestep: Option<f64>,
    /// Part of its velocity that a step takes over from the one before, in [0, 1). With 0 bodies fall and slide as through honey,
    /// with 0.9 and more they bounce and swing for long. Default 0.5.
    pub momentum: f64,
}

impl Default for SettleSettings {
    fn default() -> Self {
        Self { max_steps: 2000, timestep: None, momentum: 0.5 }
    }
}

impl SettleSettings {
    pub(super) fn validate(&self) -> Result<(), SimulationError> {
        let check = |setting, found: f64, expected, ok: bool| {
            if ok { Ok(()) } else { Err(SimulationError::Setting { setting, expected, found }) }
        };
        if let Some(dt) = self.timestep {
            check("settle.timestep", dt, "positive and finite", dt > 0.0 && dt.is_finite())?;
        }
        check("settle.momentum", self.momentum, "in [0, 1)", (0.0..1.0).contains(&self.momentum))
    }
}

/// How a state was brought to rest.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct SettleReport {
    /// Steps towards rest; 0 where the state rested.
    pub steps: u32,
    /// Factorisations in them, and in the look whether the state rested; 0 where it did.
    pub factorizations: u64,
    /// The ordinary step that ended where it began.
    pub at_rest: StepReport,
    /// The largest entry of the velocity before and after it, m/s or rad/s: zero, or rounding of at most 1e-12 of the velocity scale where springs
    /// or servos hold a load.
    pub speed: f64,
}

/// How far a state is from rest; see [`Simulation::settle_while`](crate::Simulation::settle_while).
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct SettleProgress {
    /// Steps made; 0 while it is looked whether the start rests.
    pub steps: u32,
    /// Factorisations made.
    pub factorizations: u64,
    /// The largest entry of the last step's velocity, relative to the velocity scale.
    pub speed: f64,
    /// By how much contacts gave way in it, relative to the velocity scale.
    pub slack: f64,
}
