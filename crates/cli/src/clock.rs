//! Simulated times as numbers of steps.

use crate::error::CliError;

/// Whole numbers up to here are doubles: so many steps are counted one by one, and each of them changes the time.
const MOST_STEPS: f64 = 2.0 / f64::EPSILON;

/// The number of time steps that is nearest to a span of time, s; negative for a negative one.
///
/// # Errors
/// [`CliError::TooLong`], naming the option.
pub fn steps(option: &'static str, span: f64, timestep: f64) -> Result<f64, CliError> {
    let steps = (span / timestep).round();
    if steps > MOST_STEPS {
        return Err(CliError::TooLong { option, time: span, timestep, end: MOST_STEPS * timestep });
    }
    Ok(steps)
}
