//! Parameters that were changed before a run, into the header of its recording and out of it again.

use std::sync::Arc;

use signorini_multibody::{ChangedRow, Model, Parameter};
use signorini_recording::{Header, RecordedChange};

use crate::SimulationError;
use crate::workspace::Workspace;

/// Changed rows as a recording's header has them.
pub(crate) fn recorded_changes(workspace: &Workspace) -> Vec<RecordedChange> {
    let recorded = |row: ChangedRow| RecordedChange {
        parameter: row.parameter.name().to_owned(),
        index: row.index,
        values: row.values.iter().map(|x| x.is_finite().then_some(*x)).collect(),
    };
    workspace.changed_rows().map(recorded).collect()
}

/// The model of a recording: the compiled one with the numbers that were changed before the run.
///
/// - `model`: as its file says
///
/// # Errors
/// [`SimulationError::Recording`] for a parameter that this version does not know, [`SimulationError::Model`] where a change does not fit
/// the model.
pub fn recorded_model(model: impl Into<Arc<Model>>, header: &Header) -> Result<Arc<Model>, SimulationError> {
    let model = model.into();
    if header.changes.is_empty() || model.content_hash() == header.model_hash {
        return Ok(model);
    }
    let reason =
        "its run had parameters that this version of signorini does not know; check it with the version that made it";
    let row = |change: &RecordedChange| {
        let parameter = Parameter::named(&change.parameter).ok_or(SimulationError::Recording { reason })?;
        // What is not finite are the ends of ranges: none at all.
        let end = |(k, x): (usize, &Option<f64>)| x.unwrap_or([f64::NEG_INFINITY, f64::INFINITY][k.min(1)]);
        let values = change.values.iter().enumerate().map(end).collect();
        Ok(ChangedRow::new(parameter, change.index, values))
    };
    let rows = header.changes.iter().map(row).collect::<Result<Vec<_>, SimulationError>>()?;
    Ok(Arc::new(model.with_rows(&rows)?))
}
