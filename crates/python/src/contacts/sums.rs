//! Sums over the contacts of two bodies.

use pyo3::prelude::*;
use signorini::multibody::glam::DVec3;

use super::{Bodies, Contacts};
use crate::arrays::{self, Vector};
use crate::names::Key;

/// What the contacts between two bodies add up to in a step; it acts on the second of them, world axes.
#[pyclass(frozen, module = "signorini")]
pub struct ContactSum {
    /// Number of contacts.
    #[pyo3(get)]
    ncon: usize,
    /// Number of contacts with an impulse.
    #[pyo3(get)]
    closed: usize,
    impulse: DVec3,
    moment: DVec3,
    timestep: f64,
}

#[pymethods]
impl ContactSum {
    /// Sum of the impulses on the second body, (3,), N·s.
    #[getter]
    fn impulse<'py>(&self, py: Python<'py>) -> Vector<'py> {
        arrays::vector3(py, self.impulse)
    }

    /// Mean force over the step on the second body, (3,), N.
    #[getter]
    fn force<'py>(&self, py: Python<'py>) -> Vector<'py> {
        arrays::vector3(py, self.impulse / self.timestep)
    }

    /// Mean moment of these forces about the world's origin, (3,), N·m.
    #[getter]
    fn torque<'py>(&self, py: Python<'py>) -> Vector<'py> {
        arrays::vector3(py, self.moment / self.timestep)
    }

    fn __repr__(&self) -> String {
        let [x, y, z] = (self.impulse / self.timestep).to_array();
        format!(
            "<signorini.ContactSum {} contacts, {} closed, force ({x:.6}, {y:.6}, {z:.6}) N>",
            self.ncon, self.closed
        )
    }
}

#[pymethods]
impl Contacts {
    /// Sums over the contacts between two bodies, by name or index (0 or "world" is the world); they act on `body2`.
    fn between(&self, py: Python<'_>, body1: Key, body2: Key) -> PyResult<ContactSum> {
        let pair = [self.bodies.index(py, &body1)?, self.bodies.index(py, &body2)?];
        let mut sum =
            ContactSum { ncon: 0, closed: 0, impulse: DVec3::ZERO, moment: DVec3::ZERO, timestep: self.timestep };
        for contact in &self.contacts {
            let sign = match contact.bodies {
                found if found == pair => 1.0,
                [a, b] if [b, a] == pair => -1.0,
                _ => continue,
            };
            let impulse = sign * contact.impulse_world();
            sum.ncon += 1;
            sum.closed += usize::from(contact.mode != 0);
            sum.impulse += impulse;
            sum.moment += contact.point.cross(impulse);
        }
        Ok(sum)
    }
}

impl Bodies {
    fn index(&self, py: Python<'_>, key: &Key) -> PyResult<u32> {
        let names: Vec<&str> = match self {
            Self::Of(model) => model.bodies.iter().map(|body| body.name.as_str()).collect(),
            Self::Listed(names) => names.iter().map(String::as_str).collect(),
        };
        key.among(py, "body", names.iter().copied()).map(|i| i as u32)
    }
}
