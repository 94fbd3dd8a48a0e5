//! What the simulations of a batch go on from, as Python keeps it in a pickle.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use signorini::Snapshot;

use super::Batch;
use crate::error::simulation_error;
use crate::parameters::{Changes, apply, changed};

/// The bytes of a snapshot, and the parameters that are not those of the model.
type Saved<Bytes> = (Bytes, Changes);

#[pymethods]
impl Batch {
    /// Everything that decides how each simulation goes on.
    fn _save<'py>(&self, py: Python<'py>) -> PyResult<Vec<Saved<Bound<'py, PyBytes>>>> {
        let lanes = self.loaded(py)?;
        let saved = (0..self.count).map(|i| {
            let simulation = lanes.batch.simulation(i);
            let changes = changed(simulation.workspace(), simulation.model());
            (PyBytes::new(py, &simulation.save().to_bytes()), changes)
        });
        Ok(saved.collect())
    }

    /// Lets every simulation go on from what a batch of the same model saved.
    fn _restore(&self, py: Python<'_>, saved: Vec<Saved<Vec<u8>>>) -> PyResult<()> {
        let mut lanes = self.lock()?;
        let batch = &mut lanes.batch;
        if saved.len() != batch.len() {
            let message = format!("{} simulations were saved, the batch has {}", saved.len(), batch.len());
            return Err(PyValueError::new_err(message));
        }
        for (i, (bytes, changes)) in saved.into_iter().enumerate() {
            let snapshot = Snapshot::from_bytes(&bytes).map_err(simulation_error)?;
            apply(changes, |changes| batch.change(i, changes).map_err(simulation_error))?;
            batch.restore(i, &snapshot).map_err(simulation_error)?;
            self.views.publish_input(py, batch, i)?;
        }
        self.views.publish(py, batch)
    }
}
