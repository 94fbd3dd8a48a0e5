//! From recordings to parameters: checks, the fit, and the covariance of what it finds.

use signorini_multibody::Model;
use signorini_simulation::Settings;

use super::check::check;
use super::draws::drawn_covariance;
use super::fit::Fit;
use super::{
    Identification, IdentificationError, IdentificationProgress, IdentificationSettings, Recording, Task, Unknown,
};

/// Looks for parameters of a model that make it move as recorded.
///
/// - `settings`: of the simulation; Δt is the samples' interval over the substeps
/// - `unknowns`: begin at their values in `model`, and stay where a model may have them
/// - `progress`: called after every step of the method, which it ends with `false`
///
/// # Errors
/// [`IdentificationError`] for unknowns that the model does not have, bounds that exclude their beginning, recordings that do not fit, and
/// settings of the simulation out of range.
///
/// # Source
/// J. Nocedal, S. Wright, *Numerical Optimization* (2006), chapter 10; P. Huber, *Robust Statistics* (1981); the covariance:
/// H. White, *Maximum likelihood estimation of misspecified models*, Econometrica 50 (1982).
pub fn identify(
    model: &Model,
    settings: &Settings,
    recordings: &[Recording],
    unknowns: &[Unknown],
    asked: &IdentificationSettings,
    mut progress: impl FnMut(&IdentificationProgress) -> bool,
) -> Result<Identification, IdentificationError> {
    check(model, recordings, &Task { settings, asked, unknowns })?;
    let unknowns: Vec<Unknown> = unknowns.iter().map(|unknown| unknown.within_range(model)).collect();
    let task = Task { settings, asked, unknowns: &unknowns };
    let values = unknowns.iter().map(|unknown| unknown.value(model).unwrap_or_default()).collect();
    let counts = vec![1; recordings.len()];
    let mut fit = Fit { task, recordings, model: model.clone(), values, counts, tried: 0 };
    let first = fit.start()?;
    let end = fit.search(&mut progress)?;
    let mut found = fit.result(first, &end);
    if asked.draws > 1 {
        found.covariance = drawn_covariance(&fit, &found)?;
    }
    Ok(found)
}
