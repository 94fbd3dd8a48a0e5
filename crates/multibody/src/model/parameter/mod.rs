//! Numbers of a model that can change without building it anew.

mod numbers;
mod table;

pub use table::{Effect, Parameter};

use super::check::{check_inertia, number};
use super::check_sensing::check_relations;
use super::{Model, ModelError};

/// Other values of a parameter: all of them, in the order of the model.
pub type ParameterChange<'a> = (Parameter, &'a [f64]);

/// The numbers of one part that differ between two models of the same structure.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ChangedRow {
    /// Which numbers.
    pub parameter: Parameter,
    /// Index of the part.
    pub index: usize,
    /// Its numbers, `[parameter.width()]`.
    pub values: Vec<f64>,
}

impl ChangedRow {
    /// Other numbers of part `index`.
    pub fn new(parameter: Parameter, index: usize, values: Vec<f64>) -> Self {
        Self { parameter, index, values }
    }
}

impl Model {
    /// All values of a parameter, `[parts, width]` row after row.
    pub fn parameter(&self, parameter: Parameter) -> Vec<f64> {
        let (count, width) = (parameter.count(self), parameter.width());
        let mut values = vec![0.0; count * width];
        (0..count).for_each(|i| parameter.read(self, i, &mut values[i * width..(i + 1) * width]));
        values
    }

    /// A model with other values of some parameters, checked as [`ModelBuilder::build`](super::ModelBuilder::build) checks. Meshes are shared
    /// with this one. What the loader or builder made of the old values (relative poses of welds, keyframes, inertia of shapes) stays.
    ///
    /// - `changes`: all values of each parameter; quaternions are made unit, a range that is (−∞, ∞) is none
    ///
    /// # Errors
    /// [`ModelError::WrongLength`], [`ModelError::FixedParameter`] for a number that this part has not, and what is out of its range as when
    /// the model was built, with the part.
    pub fn with_parameters(&self, changes: &[ParameterChange<'_>]) -> Result<Self, ModelError> {
        let mut model = self.clone();
        for &(parameter, values) in changes {
            let (count, width) = (parameter.count(self), parameter.width());
            if values.len() != count * width {
                let (part, found) = (format!("model '{}'", self.name), values.len());
                return Err(ModelError::WrongLength { part, list: parameter.name(), expected: count * width, found });
            }
            for i in 0..count {
                model.set_row(parameter, i, &values[i * width..(i + 1) * width])?;
            }
        }
        model.check_numbers()?;
        Ok(model)
    }

    /// As [`with_parameters`](Self::with_parameters), with the numbers of single parts.
    ///
    /// # Errors
    /// The same, and [`ModelError::UnknownPart`].
    pub fn with_rows(&self, rows: &[ChangedRow]) -> Result<Self, ModelError> {
        let mut model = self.clone();
        for ChangedRow { parameter, index, values } in rows {
            let part = || format!("a change of {}", parameter.name());
            let (count, expected) = (parameter.count(self), parameter.width());
            if *index >= count {
                return Err(ModelError::UnknownPart { part: part(), sort: "row", index: *index, count });
            }
            if values.len() != expected {
                let (list, found) = (parameter.name(), values.len());
                return Err(ModelError::WrongLength { part: part(), list, expected, found });
            }
            model.set_row(*parameter, *index, values)?;
        }
        model.check_numbers()?;
        Ok(model)
    }

    /// Rows of a parameter in which another model of the same structure has other bits.
    pub fn rows_unlike(&self, other: &Self, parameter: Parameter) -> Vec<ChangedRow> {
        let width = parameter.width();
        let (mut own, mut others) = (vec![0.0; width], vec![0.0; width]);
        let mut rows = Vec::new();
        for i in 0..parameter.count(self).min(parameter.count(other)) {
            parameter.read(self, i, &mut own);
            parameter.read(other, i, &mut others);
            if !same_bits(&own, &others) {
                rows.push(ChangedRow::new(parameter, i, own.clone()));
            }
        }
        rows
    }

    /// Writes what is new in a row: numbers that stay keep their bits.
    fn set_row(&mut self, parameter: Parameter, i: usize, values: &[f64]) -> Result<(), ModelError> {
        let mut before = [0.0; Parameter::WIDEST];
        let before = &mut before[..values.len()];
        parameter.read(self, i, before);
        if same_bits(before, values) {
            return Ok(());
        }
        if let Some(found) = values.iter().find(|x| x.is_nan()) {
            let part = parameter.part_name(self, i);
            return Err(ModelError::InvalidNumber {
                part,
                quantity: parameter.name(),
                expected: "a number",
                found: *found,
            });
        }
        parameter.write(self, i, values).map_err(|reason| ModelError::FixedParameter {
            part: parameter.part_name(self, i),
            parameter: parameter.name(),
            reason,
        })
    }

    /// Checks the numbers of a model whose fields were changed, as [`ModelBuilder::build`](super::ModelBuilder::build) checks them.
    ///
    /// # Errors
    /// The first [`ModelError`] met: the part, the number, and its range.
    pub fn check_numbers(&self) -> Result<(), ModelError> {
        let part = || format!("model '{}'", self.name);
        number(part, "time step", "positive and finite", self.timestep, |x| x > 0.0)?;
        self.gravity.to_array().iter().try_for_each(|&g| number(part, "gravity", "finite", g, |_| true))?;
        self.bodies.iter().try_for_each(check_inertia)?;
        check_relations(self)
    }
}

fn same_bits(a: &[f64], b: &[f64]) -> bool {
    a.iter().zip(b).all(|(x, y)| x.to_bits() == y.to_bits())
}
