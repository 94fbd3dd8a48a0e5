//! Lengths, and how they change with the velocity.

use glamx::glam::DVec3;

use crate::jacobian::point_column;
use crate::kinematics::Kinematics;
use crate::model::{BodyId, Model};

/// A length with its rate's row: `l̇ = Σ gradient[k] v[dofs[k]]`. Storage that is reused.
#[derive(Debug, Default, PartialEq)]
pub struct LengthRow {
    /// The length, m or rad.
    pub length: f64,
    /// Degrees of freedom, ascending.
    pub dofs: Vec<usize>,
    /// For each of `dofs` its entry.
    pub gradient: Vec<f64>,
}

impl Clone for LengthRow {
    fn clone(&self) -> Self {
        Self { length: self.length, dofs: self.dofs.clone(), gradient: self.gradient.clone() }
    }

    /// Keeps the memory at hand.
    fn clone_from(&mut self, other: &Self) {
        self.length = other.length;
        self.dofs.clone_from(&other.dofs);
        self.gradient.clone_from(&other.gradient);
    }
}

impl LengthRow {
    /// Storage that never grows for the model.
    pub fn new(model: &Model) -> Self {
        Self { length: 0.0, dofs: Vec::with_capacity(model.nv), gradient: Vec::with_capacity(model.nv) }
    }

    /// The rate `l̇` at a velocity, `[nv]`.
    pub fn rate(&self, v: &[f64]) -> f64 {
        self.dofs.iter().zip(&self.gradient).map(|(&k, g)| g * v[k]).sum()
    }

    pub(crate) fn clear(&mut self) {
        self.length = 0.0;
        self.dofs.clear();
        self.gradient.clear();
    }

    pub(crate) fn add(&mut self, dof: usize, entry: f64) {
        match self.dofs.binary_search(&dof) {
            Ok(at) => self.gradient[at] += entry,
            Err(at) => {
                self.dofs.insert(at, dof);
                self.gradient.insert(at, entry);
            }
        }
    }

    /// Adds the row of a force and a moment (per unit of the length's) on a body at a point, whose opposites act on another body at a
    /// point of its own. World, m.
    pub(crate) fn add_force(
        &mut self,
        model: &Model,
        kinematics: &Kinematics,
        (body, point): (BodyId, DVec3),
        [force, moment]: [DVec3; 2],
        (carrier, reference): (BodyId, DVec3),
    ) {
        let (mut own, mut other) = (model.body_last_dof[body.index()], model.body_last_dof[carrier.index()]);
        let entry = |k: usize, at: DVec3| {
            force.dot(point_column(model, kinematics, k, at)) + moment.dot(kinematics.dof_angular[k])
        };
        // They come in descending order.
        let is_first = self.dofs.is_empty();
        let mut add = |k: usize, entry: f64| {
            if is_first {
                self.dofs.push(k);
                self.gradient.push(entry);
            } else {
                self.add(k, entry);
            }
        };
        // The later of two degrees of freedom cannot move both bodies; those that do cancel.
        while own != other {
            if own > other {
                own = own.and_then(|k| {
                    add(k, entry(k, point));
                    model.dof_parent[k]
                });
            } else {
                other = other.and_then(|k| {
                    add(k, -entry(k, reference));
                    model.dof_parent[k]
                });
            }
        }
        if is_first {
            self.dofs.reverse();
            self.gradient.reverse();
        }
    }

    pub(crate) fn scale(&mut self, factor: f64) {
        self.length *= factor;
        self.gradient.iter_mut().for_each(|g| *g *= factor);
    }
}
