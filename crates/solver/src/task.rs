//! What is asked of the stages: an island of a problem, and how exactly it is to be solved.

use signorini_contact::ContactProblem;
use signorini_contact::projection::Cones;

use crate::islands::Island;
use crate::residual::RESIDUALS;
use crate::settings::SolverSettings;

/// What is tuned by the size of an island.
pub(crate) struct Tuning {
    /// Contacts and groups from which it is large: a path from modes that are far from the solution's would wander, sweeps would take
    /// long, and a residual may be mostly rounding.
    pub large: usize,
    /// ... and from which a factorisation costs more than the few mode changes of a path.
    pub costly: usize,
    /// Where the certificate asks for more than `accept`, a small island has to come down to this part of it, a large one to that.
    pub closely: [f64; 2],
    /// Proximal iterations after which a start that is still far was not near: where a mode changes, a few.
    pub short_iterations: u32,
    /// An accepted residual from which a body that creeps counts as at rest.
    pub rough: f64,
}

/// Chosen by: `contact_lcp --directions 8 --no-growth`, `random_steps --seeds 0..30000`, 21 November 2026; `costly` by
/// `sim S4_pile100 S4_pile300`, 22 November 2026.
pub(crate) const SIZES: Tuning =
    Tuning { large: 64, costly: 512, closely: [0.1, 0.3], short_iterations: 4, rough: 1e-6 };

/// How much is tried for a solution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Patience {
    /// Everything.
    #[default]
    Full,
    /// No second looks and no Lemke's method: enough for most problems that have a solution, and short where there may be none.
    Brief,
    /// A few iterations from the start, and more where they come close, with a path of Lemke's method for what then still lacks a little: enough where a
    /// solution is near.
    Short,
}

impl Patience {
    /// The first look at islands.
    pub(crate) fn first_look(self) -> Look {
        match self {
            Self::Full => Look::First,
            Self::Brief => Look::Only,
            Self::Short => Look::Short,
        }
    }
}

/// How often an island has been looked at, and how much is tried for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Look {
    /// From the start that the caller gave.
    First,
    /// The same without Lemke's method.
    Only,
    /// The same with few iterations and no other start; where that comes near, with one path of Lemke's method.
    Short,
    /// The same for a part of an island whose other rows are held.
    Part,
    /// From what was found, because the certificate did not hold with it.
    Second,
}

/// An island of a problem, to be solved.
#[derive(Clone, Copy)]
pub(crate) struct Task<'a> {
    pub problem: &'a ContactProblem,
    pub cones: &'a Cones,
    pub island: &'a Island,
    pub settings: &'a SolverSettings,
    pub look: Look,
    /// Whether it begins at a start that the caller gave.
    pub is_warm: bool,
    /// Whether that start solves it but for a few contacts.
    pub is_nearly_solved: bool,
}

impl Task<'_> {
    /// Whether the island has many contacts and groups.
    pub fn is_large(&self) -> bool {
        self.island.units.len() >= SIZES.large
    }

    /// Whether it has so many that a factorisation costs more than a few mode changes.
    pub fn is_costly(&self) -> bool {
        self.island.units.len() >= SIZES.costly
    }

    /// Whether factorisations are to be spared: where they cost more than a few mode changes, and where a start leaves few modes to change.
    /// A cold start is solved to the last digits: the next steps begin there.
    pub fn spares_factorizations(&self) -> bool {
        self.is_costly() || self.is_warm
    }

    /// Whether so many proximal iterations are all that are made where they have come down to a residual: what is close to a solution has one.
    pub fn is_short_of(&self, iterations: u32, residual: f64) -> bool {
        self.look == Look::Short && iterations >= SIZES.short_iterations && residual > self.accept().max(RESIDUALS.far)
    }

    /// The residual with which the island counts as solved.
    pub fn accept(&self) -> f64 {
        match self.look {
            Look::First | Look::Only | Look::Short | Look::Part => self.settings.accept(),
            Look::Second => accepted_closely(self.island.units.len(), self.settings),
        }
    }

    /// How many sweeps the island may have, where they are counted and it has nothing else to come: large islands, in a first look.
    pub fn budget(&self) -> Option<u32> {
        self.settings.budget.filter(|_| !matches!(self.look, Look::Part | Look::Second))
    }

    /// Whether what is accepted does not tell rest from motion: nothing is worth more digits than were asked for.
    pub fn is_rough(&self) -> bool {
        self.settings.accept() > SIZES.rough
    }
}

/// The residual that islands with so many contacts and groups have to reach after a solution that the certificate did not accept.
pub(crate) fn accepted_closely(units: usize, settings: &SolverSettings) -> f64 {
    SIZES.closely[usize::from(units >= SIZES.large)] * settings.accept()
}
