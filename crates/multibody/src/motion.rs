//! How bodies and their velocities move with the configuration.

use std::ops::Range;

use glamx::glam::DVec3;

use crate::kinematics::Kinematics;
use crate::links::Links;
use crate::model::{BodyId, Model};
use crate::spatial::SpatialVector;

/// Displacements of bodies per unit of a degree of freedom, and the change of their velocities that goes with it, at one
/// configuration and one velocity.
#[derive(Clone, Debug)]
pub struct MotionDerivatives {
    pub(crate) links: Links,
    /// The point of the world that the vectors of each link are about, m.
    pub(crate) reference: Vec<DVec3>,
    /// `S_k` of every degree of freedom.
    pub(crate) axis: Vec<SpatialVector>,
    /// Velocity before and after each link.
    pub(crate) before: Vec<SpatialVector>,
    pub(crate) after: Vec<SpatialVector>,
}

impl MotionDerivatives {
    /// Storage for a model.
    pub fn new(model: &Model) -> Self {
        let links = Links::new(model);
        let zeros = vec![SpatialVector::ZERO; links.all.len()];
        Self {
            reference: vec![DVec3::ZERO; links.all.len()],
            axis: vec![SpatialVector::ZERO; model.nv],
            before: zeros.clone(),
            after: zeros,
            links,
        }
    }

    /// Takes a configuration and a velocity.
    ///
    /// - `kinematics`: from [`forward_kinematics_into`](crate::forward_kinematics_into) at the configuration, at any velocity
    /// - `v`: `[nv]`
    ///
    /// # Panics
    /// If a length does not fit the model.
    pub fn set(&mut self, model: &Model, kinematics: &Kinematics, v: &[f64]) {
        self.set_of(model, kinematics, v, 0..self.links.all.len());
    }

    /// [`set`](Self::set) of some links alone, with all before them on the way to the root.
    pub(crate) fn set_of(&mut self, model: &Model, kinematics: &Kinematics, v: &[f64], links: Range<usize>) {
        for (l, link) in links.clone().zip(&self.links.all[links]) {
            let reference = kinematics.pose[link.root.index()].position;
            let before = link.parent.map_or(SpatialVector::ZERO, |parent| self.after[parent]);
            let mut after = before;
            for k in link.dofs.clone() {
                let origin = kinematics.pose[model.dof_body(k).index()].position;
                let at_origin = SpatialVector { angular: kinematics.dof_angular[k], linear: kinematics.dof_linear[k] };
                self.axis[k] = at_origin.at(reference - origin);
                after += self.axis[k].scaled(v[k]);
            }
            (self.reference[l], self.before[l], self.after[l]) = (reference, before, after);
        }
    }

    /// Velocity of a body's material point at `point` in world, with its angular velocity, world axes.
    #[inline]
    pub fn velocity(&self, body: BodyId, point: DVec3) -> SpatialVector {
        match self.links.of_body[body.index()] {
            None => SpatialVector::ZERO,
            Some(l) => self.after[l].at(point - self.reference[l]),
        }
    }

    /// Rotation and displacement at `point` in world of the bodies that degree of freedom `dof` moves, per unit of it, world axes.
    #[inline]
    pub fn displacement(&self, dof: usize, point: DVec3) -> SpatialVector {
        self.axis[dof].at(point - self.reference[self.links.of_dof[dof]])
    }

    /// Derivative of the velocity of a body, told of the place `point` of the world, with respect to a degree of freedom that moves the
    /// body; `v` does not change, and the place stays.
    ///
    /// # Source
    /// All axes from the degree of freedom on are carried by it, and so is the velocity that they give: `S_k × (V − V_before)`.
    #[inline]
    pub fn velocity_slope(&self, body: BodyId, dof: usize, point: DVec3) -> SpatialVector {
        let Some(last) = self.links.of_body[body.index()] else { return SpatialVector::ZERO };
        let link = self.links.of_dof[dof];
        self.axis[dof].carry_motion(self.after[last] - self.before[link]).at(point - self.reference[link])
    }
}
