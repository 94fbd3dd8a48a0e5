//! Whether recordings, unknowns and settings fit each other.

use signorini_multibody::Model;

use super::{IdentificationError, Recording, Task, Unknown};

/// # Errors
/// What does not fit.
pub(super) fn check(model: &Model, recordings: &[Recording], task: &Task) -> Result<(), IdentificationError> {
    for unknown in task.unknowns {
        let Some(value) = unknown.value(model).filter(|_| unknown.set(&mut model.clone(), 1.0)) else {
            return Err(IdentificationError::NoSuchNumber(unknown.name.clone()));
        };
        let [lower, upper] = unknown.bounds;
        if !(lower <= value && value <= upper) {
            return Err(IdentificationError::OutsideBounds { name: unknown.name.clone(), value, lower, upper });
        }
    }
    let malformed = |text: String| Err(IdentificationError::Malformed(text));
    for unknown in task.unknowns {
        let Some([value, deviation]) = unknown.prior else { continue };
        if !(value.is_finite() && deviation > 0.0 && deviation.is_finite()) {
            return malformed(format!(
                "unknown '{}' has the prior {value} ± {deviation}: it takes a finite value and a deviation that is positive and finite",
                unknown.name
            ));
        }
    }
    let asked = task.asked;
    let is_open = |unknown: &&Unknown| unknown.bounds.iter().any(|bound| !bound.is_finite());
    if let Some(unknown) = task.unknowns.iter().filter(|_| asked.starts > 0).find(is_open) {
        return malformed(format!("unknown '{}' needs finite bounds for several starts", unknown.name));
    }
    if task.unknowns.is_empty() || recordings.iter().all(|recording| recording.states.len() < 2) {
        return malformed("nothing to identify: it takes an unknown and a recording of two samples".into());
    }
    if !(asked.interval > 0.0 && asked.interval.is_finite()) || asked.substeps == 0 {
        return malformed("the interval must be positive and finite, and there must be a substep".into());
    }
    if !asked.weights.is_empty() && asked.weights.len() != model.nv {
        return malformed(format!("{} weights are given for {} degrees of freedom", asked.weights.len(), model.nv));
    }
    for (i, recording) in recordings.iter().enumerate() {
        if let Some(k) = recording.states.iter().position(|s| s.check(model).is_err()) {
            return malformed(format!(
                "recording {i}, sample {k}: it does not fit the model, or has a number that is not finite"
            ));
        }
        if !recording.inputs.is_empty() && recording.inputs.len() + 1 != recording.states.len() {
            return malformed(format!(
                "recording {i} has {} samples and {} inputs: one for every interval is needed",
                recording.states.len(),
                recording.inputs.len()
            ));
        }
    }
    Ok(())
}
