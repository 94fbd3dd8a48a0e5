//! A model with other parameters: what differs between the simulations of a batch.

use derive_setters::Setters;
use signorini_multibody::glam::DVec3;
use signorini_multibody::{Model, Parameter, ParameterChange};

use crate::SimulationError;

/// What differs from a model. The default is no difference.
#[derive(Clone, Copy, Debug, PartialEq, Setters)]
#[setters(prefix = "with_")]
#[non_exhaustive]
pub struct Variation {
    /// Factor on all coefficients of sliding friction; at least 0.
    pub friction: f64,
    /// Factor on the density of all bodies: on their masses and their inertia; positive.
    pub mass: f64,
    /// Gravity in world, m/s²; the model's own where it is not given.
    #[setters(into)]
    pub gravity: Option<DVec3>,
}

impl Default for Variation {
    fn default() -> Self {
        Self { friction: 1.0, mass: 1.0, gravity: None }
    }
}

impl Variation {
    /// What differs, as other values of parameters.
    ///
    /// # Errors
    /// [`SimulationError::Setting`] naming the number that is out of its range.
    pub fn changes(&self, model: &Model) -> Result<Vec<(Parameter, Vec<f64>)>, SimulationError> {
        let check = |setting, found: f64, expected, ok: bool| {
            if ok && found.is_finite() { Ok(()) } else { Err(SimulationError::Setting { setting, expected, found }) }
        };
        check("variation.friction", self.friction, "finite and not negative", self.friction >= 0.0)?;
        check("variation.mass", self.mass, "finite and positive", self.mass > 0.0)?;
        let times = |parameter: Parameter, factor: f64| {
            let mut values = model.parameter(parameter);
            values.iter_mut().for_each(|x| *x *= factor);
            (parameter, values)
        };
        // Of friction the first number of each row is that of sliding.
        let sliding = |parameter: Parameter| {
            let mut values = model.parameter(parameter);
            values.iter_mut().step_by(parameter.width()).for_each(|x| *x *= self.friction);
            (parameter, values)
        };
        let mut changes = Vec::new();
        if self.mass != 1.0 {
            changes.extend([times(Parameter::BodyMass, self.mass), times(Parameter::BodyInertia, self.mass)]);
        }
        if self.friction != 1.0 {
            changes.extend([sliding(Parameter::GeomFriction), sliding(Parameter::PairFriction)]);
        }
        if let Some(gravity) = self.gravity {
            gravity.to_array().into_iter().try_for_each(|g| check("variation.gravity", g, "finite", true))?;
            changes.push((Parameter::Gravity, gravity.to_array().to_vec()));
        }
        Ok(changes)
    }

    /// The model with these differences.
    ///
    /// # Errors
    /// [`SimulationError::Setting`] naming the number that is out of its range.
    pub fn of(&self, model: &Model) -> Result<Model, SimulationError> {
        let changes = self.changes(model)?;
        let changes: Vec<ParameterChange<'_>> = changes.iter().map(|(parameter, all)| (*parameter, &all[..])).collect();
        Ok(model.with_parameters(&changes)?)
    }
}
