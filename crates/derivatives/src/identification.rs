//! Parameters of a model from recorded motions.
//!
//! The unknowns `θ` minimise
//!
//! ```text
//! Σ ρ(‖W_j (q_sim(θ) ⊖ q_rec)_j‖) + ½ Σ ((θ − θ₀)/σ₀)² ,
//! ```
//!
//! over the translations and rotations of all joints `j`, at all samples of all windows of the recordings, each simulated from its first sample, by Levenberg and Marquardt's method: the slopes of
//! the trajectories are products of the [derivatives of their steps](crate::StepDerivatives). Contact makes the objective rough, so that
//! no step is taken that does not lower the objective itself. Where a step has no derivative, its slopes are differences of the step
//! itself, and the report counts such steps.

mod check;
mod draws;
mod fit;
mod rollout;
mod search;

use signorini_multibody::{Input, Model, State};
use signorini_simulation::{Settings, SimulationError};

use crate::parameter::Direction;

pub use search::identify;

/// A motion that was recorded at equal intervals.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub struct Recording {
    /// Its samples: configurations and, at the beginning of windows, velocities.
    pub states: Vec<State>,
    /// The input during each interval, one less than samples; empty for none at all.
    pub inputs: Vec<Input>,
}

impl Recording {
    /// Samples without input.
    pub fn new(states: Vec<State>) -> Self {
        Self { states, inputs: Vec::new() }
    }

    /// The same with the input during each interval.
    #[must_use]
    pub fn with_inputs(mut self, inputs: Vec<Input>) -> Self {
        self.inputs = inputs;
        self
    }
}

/// A number that is looked for.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Unknown {
    /// Its name in reports.
    pub name: String,
    /// What it is in the model: its value is that of the first parameter, and the others change with it in proportion to their shares.
    pub direction: Direction,
    /// Least and largest value; where its numbers have a narrower range, that.
    pub bounds: [f64; 2],
    /// What is known of it before: a value and its standard deviation.
    pub prior: Option<[f64; 2]>,
}

impl Unknown {
    /// A number without bounds or prior.
    pub fn new(name: impl Into<String>, direction: Direction) -> Self {
        Self { name: name.into(), direction, bounds: [f64::NEG_INFINITY, f64::INFINITY], prior: None }
    }

    /// Keeps it between two values.
    #[must_use]
    pub fn with_bounds(mut self, bounds: [f64; 2]) -> Self {
        self.bounds = bounds;
        self
    }

    /// Says what is known of it before.
    #[must_use]
    pub fn with_prior(mut self, value: f64, deviation: f64) -> Self {
        self.prior = Some([value, deviation]);
        self
    }

    /// Its value in a model; none where the model has no such number.
    pub fn value(&self, model: &Model) -> Option<f64> {
        self.direction.first()?.0.value(model)
    }

    /// The direction per unit of the unknown.
    pub(crate) fn unit(&self) -> Direction {
        let first = self.direction.first().map_or(1.0, |(_, weight)| *weight);
        self.direction.iter().map(|&(parameter, weight)| (parameter, weight / first)).collect()
    }

    /// The same with bounds between which none of its numbers leaves its [range](crate::ScalarParameter::range).
    pub(crate) fn within_range(&self, model: &Model) -> Self {
        let mut own = self.clone();
        let Some(now) = self.value(model) else { return own };
        for (parameter, weight) in self.unit().into_iter().filter(|(_, weight)| *weight != 0.0) {
            let Some(value) = parameter.value(model) else { continue };
            let [mut lower, mut upper] = parameter.range().map(|end| now + (end - value) / weight);
            if weight < 0.0 {
                (lower, upper) = (upper, lower);
            }
            // The value at hand is one of them, whatever rounding says.
            own.bounds = [own.bounds[0].max(lower.min(now)), own.bounds[1].min(upper.max(now))];
        }
        own
    }

    /// Gives a model another value of it, as [`ScalarParameter::set`](crate::ScalarParameter::set) does; `false` where the model has no such number.
    pub fn set(&self, model: &mut Model, value: f64) -> bool {
        let Some(now) = self.value(model) else { return false };
        self.unit().into_iter().all(|(parameter, weight)| {
            let old = parameter.value(model);
            old.is_some_and(|old| parameter.set(model, old + weight * (value - now)))
        })
    }
}

/// How parameters are looked for.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct IdentificationSettings {
    /// Time between two samples, s.
    pub interval: f64,
    /// Steps of the simulation between two samples.
    pub substeps: usize,
    /// Samples after which a window ends and the next one begins at the recorded state; the whole recording where it is 0. Errors of recorded
    /// velocities are errors of short windows, chaos is one of long ones.
    pub window: usize,
    /// What differences of configurations are multiplied by, `[nv]`; 1 where it is empty.
    pub weights: Vec<f64>,
    /// The difference of a joint's translation or rotation at a sample from which on it counts by its size and not by its square; 0 for
    /// squares alone. In units of the weighted differences.
    pub outlier: f64,
    /// Whether recordings count the same, however long they are; otherwise samples do.
    pub equal_recordings: bool,
    /// Places within the bounds at which the objective is looked at before the method begins at the best of them and of the model's own
    /// values: contact makes objectives with many valleys. Needs bounds that are finite.
    pub starts: usize,
    /// Sets of recordings to be drawn from those at hand and fitted, for the covariance; none where it is below 2. What slopes tell of the spread is
    /// too little where trajectories are chaotic: their slopes are then those of single trajectories, and the objective is rough.
    pub draws: usize,
    /// Steps of the method at most.
    pub iterations: usize,
    /// The method ends where a step lowers the objective by less than this part of it.
    pub tolerance: f64,
}

impl IdentificationSettings {
    /// Samples `interval` seconds apart, one step for each, whole recordings, squares.
    pub fn new(interval: f64) -> Self {
        Self {
            interval,
            substeps: 1,
            window: 0,
            weights: Vec::new(),
            outlier: 0.0,
            equal_recordings: false,
            starts: 0,
            draws: 0,
            iterations: 30,
            tolerance: 1e-4,
        }
    }
}

/// What is known while parameters are looked for.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct IdentificationProgress {
    /// Steps of the method so far.
    pub iteration: usize,
    /// The objective, per sample, or per recording where these count the same.
    pub objective: f64,
    /// The unknowns.
    pub values: Vec<f64>,
}

/// What was found.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Identification {
    /// The unknowns, in their order.
    pub values: Vec<f64>,
    /// Their covariance, `[n, n]` row by row: what another set of recordings of the same kind would change, from the spread of the
    /// recordings' gradients (`H⁻¹ Σ g gᵀ H⁻¹`), or from the residuals' size where there are few recordings; from
    /// [drawn sets](IdentificationSettings::draws) where these were asked for. Infinite on the diagonal for what the data leave open.
    pub covariance: Vec<f64>,
    /// Whether the data determine each unknown: it moves the trajectories, and no others undo what it does.
    pub determined: Vec<bool>,
    /// Those that ended at a bound.
    pub at_bound: Vec<bool>,
    /// The objective at the values of the model given and at the end, per sample, or per recording where these count the same.
    pub objective: [f64; 2],
    /// Root of the mean square of the weighted differences at the end.
    pub deviation: f64,
    /// Steps of the method that were tried.
    pub iterations: usize,
    /// Whether it ended because nothing more was to be gained.
    pub converged: bool,
    /// Steps of the simulation that were differentiated, and those of them that had no derivative.
    pub steps: [usize; 2],
    /// The model with the values found.
    pub model: Model,
}

/// Why parameters cannot be looked for.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IdentificationError {
    /// An unknown is no number of the model.
    #[error("unknown '{0}' is no number of the model")]
    NoSuchNumber(String),
    /// An unknown begins outside its bounds.
    #[error("unknown '{name}' is {value} at the beginning, outside its bounds {lower} to {upper}")]
    OutsideBounds {
        /// Its name.
        name: String,
        /// Its value.
        value: f64,
        /// The lower bound.
        lower: f64,
        /// The upper bound.
        upper: f64,
    },
    /// Recordings or settings do not fit.
    #[error("{0}")]
    Malformed(String),
    /// A step failed.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
}

/// What all rollouts have in common.
#[derive(Clone, Copy)]
pub(crate) struct Task<'a> {
    pub settings: &'a Settings,
    pub asked: &'a IdentificationSettings,
    pub unknowns: &'a [Unknown],
}
