//! A model with other parameters: what differs between the simulations of a batch.

use derive_setters::Setters;
use signorini_multibody::Model;
use signorini_multibody::glam::DVec3;

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
    /// The model with these differences.
    ///
    /// # Errors
    /// [`SimulationError::Setting`] naming the number that is out of its range.
    pub fn of(&self, model: &Model) -> Result<Model, SimulationError> {
        let check = |setting, found: f64, expected, ok: bool| {
            if ok && found.is_finite() { Ok(()) } else { Err(SimulationError::Setting { setting, expected, found }) }
        };
        check("variation.friction", self.friction, "finite and not negative", self.friction >= 0.0)?;
        check("variation.mass", self.mass, "finite and positive", self.mass > 0.0)?;
        let mut varied = model.clone();
        if let Some(gravity) = self.gravity {
            gravity.to_array().into_iter().try_for_each(|g| check("variation.gravity", g, "finite", true))?;
            varied.gravity = gravity;
        }
        for body in &mut varied.bodies {
            body.inertia.mass *= self.mass;
            body.inertia.rotational *= self.mass;
        }
        varied.geoms.iter_mut().for_each(|geom| geom.friction *= self.friction);
        varied.pairs.iter_mut().for_each(|pair| pair.friction *= self.friction);
        Ok(varied)
    }
}
