//! Numbers of a model that can be others in a `Data` or in a simulation of a `Batch`.

use numpy::PyArrayDyn;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use signorini::Workspace;
use signorini::multibody::{self as mb, Effect, Parameter, ParameterChange};

use crate::arrays;
use crate::batch::Batch;
use crate::data::Data;
use crate::error::{ModelError, ProblemError, simulation_error};
use crate::guard;
use crate::model::Model;
use crate::simulations::Simulations;

type Numbers<'py> = Bound<'py, PyArrayDyn<f64>>;

/// Names of all parameters with the sort of part that has them, the shape of a part's numbers, and whether a change prepares the search for
/// contacts anew.
#[pyfunction]
pub fn parameter_table() -> Vec<(&'static str, &'static str, Vec<usize>, bool)> {
    let row = |p: &Parameter| (p.name(), p.sort(), p.shape().to_vec(), p.effect() == Effect::Search);
    Parameter::ALL.iter().map(row).collect()
}

fn named(name: &str) -> PyResult<Parameter> {
    Parameter::named(name).ok_or_else(|| ProblemError::new_err(format!("there is no parameter '{name}'")))
}

/// Shape of all values: one row for each part.
fn shape(parameter: Parameter, model: &mb::Model) -> Vec<usize> {
    let rows = if parameter.is_global() { Vec::new() } else { vec![parameter.count(model)] };
    [&rows[..], parameter.shape()].concat()
}

fn values<'py>(py: Python<'py>, model: &mb::Model, name: &str) -> PyResult<Numbers<'py>> {
    let parameter = named(name)?;
    arrays::fixed(arrays::array(py, model.parameter(parameter), &shape(parameter, model))?)
}

/// All values of each parameter, row after row.
pub type Changes = Vec<(String, Vec<f64>)>;

/// The parameters of a simulation's model that were changed since it was made.
pub fn changed(workspace: &Workspace, model: &mb::Model) -> Changes {
    let mut changed: Vec<Parameter> = workspace.changed_rows().map(|row| row.parameter).collect();
    changed.dedup();
    changed.into_iter().map(|p| (p.name().to_owned(), model.parameter(p))).collect()
}

/// Hands changes on as the engine takes them.
pub fn apply(changes: Changes, change: impl FnOnce(&[ParameterChange<'_>]) -> PyResult<()>) -> PyResult<()> {
    change(&borrowed(&parsed(changes)?))
}

fn borrowed(changes: &[(Parameter, Vec<f64>)]) -> Vec<ParameterChange<'_>> {
    changes.iter().map(|(parameter, values)| (*parameter, &values[..])).collect()
}

fn parsed(changes: Changes) -> PyResult<Vec<(Parameter, Vec<f64>)>> {
    changes.into_iter().map(|(name, values)| Ok((named(&name)?, values))).collect()
}

#[pymethods]
impl Model {
    fn _parameter<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Numbers<'py>> {
        values(py, &self.inner, name)
    }

    /// Names of the parts that have a parameter, in the order of its rows; empty where they have none.
    fn _parameter_parts(&self, name: &str) -> PyResult<Vec<String>> {
        Ok(named(name)?.part_names(&self.inner).into_iter().map(str::to_owned).collect())
    }
}

#[pymethods]
impl Data {
    fn _parameter<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Numbers<'py>> {
        values(py, &self.core()?.model, name)
    }

    fn _change(&self, py: Python<'_>, changes: Changes) -> PyResult<()> {
        let changes = parsed(changes)?;
        let mut core = self.loaded(py)?;
        if core.is_recording() {
            return Err(PyRuntimeError::new_err(
                "this data is being recorded, and a recording has one model: stop the recorder, change, and record anew",
            ));
        }
        let core = &mut *core;
        guard::detached(py, || core.change(&borrowed(&changes)))?.map_err(simulation_error)?;
        self.write_all(py, core)
    }

    /// The parameters that are not those of the model, with all their values.
    fn _changed(&self) -> PyResult<Changes> {
        let core = self.core()?;
        Ok(changed(&core.workspace, &core.model))
    }
}

#[pymethods]
impl Batch {
    /// Values of a parameter in every simulation, (nsim, …).
    fn _parameter<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Numbers<'py>> {
        let parameter = named(name)?;
        let lanes = self.loaded(py)?;
        let batch = &lanes.batch;
        let all = (0..batch.len()).flat_map(|i| batch.simulation(i).model().parameter(parameter)).collect();
        let shape = [vec![batch.len()], shape(parameter, batch.model())].concat();
        arrays::fixed(arrays::array(py, all, &shape)?)
    }

    /// Changes simulations `ids`; the values of each parameter are one after the other.
    fn _change(&self, py: Python<'_>, ids: Simulations, changes: Changes) -> PyResult<()> {
        let mut lanes = self.loaded(py)?;
        let lanes = &mut *lanes;
        let changes = parsed(changes)?;
        let ids = ids.among(lanes.batch.len())?;
        for (place, &i) in ids.iter().enumerate() {
            let own = |(parameter, all): &(Parameter, Vec<f64>)| {
                let size = all.len() / ids.len();
                (*parameter, all[place * size..(place + 1) * size].to_vec())
            };
            let own: Vec<(Parameter, Vec<f64>)> = changes.iter().map(own).collect();
            lanes
                .batch
                .change(i, &borrowed(&own))
                .map_err(|error| ModelError::new_err(format!("simulation {i}: {error}")))?;
            lanes.stepped[i] = false;
        }
        Ok(())
    }
}
