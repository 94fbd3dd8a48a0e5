//! Momentum of the whole mechanism about its centre of mass, as a linear map of the generalized velocity.

use glamx::glam::DVec3;

use crate::composite::RigidInertia;
use crate::energy::center_of_mass;
use crate::kinematics::Kinematics;
use crate::model::{BodyId, Model};
use crate::spatial::SpatialVector;

/// Centroidal momentum matrix and the storage to compute it.
#[derive(Clone, Debug)]
pub struct Centroidal {
    /// `A_G`, `[6, nv]` row by row, three angular rows (kg·m²) before three linear ones (kg·m): `h_G = A_G v`.
    pub matrix: Vec<f64>,
    /// Centre of mass of all bodies in world, m.
    pub center_of_mass: DVec3,
    /// Mass of all bodies, kg.
    pub mass: f64,
    composite: Vec<RigidInertia>,
    /// Of every body, in its own axes.
    inertia: Vec<RigidInertia>,
}

impl Centroidal {
    /// Storage for a model.
    pub fn new(model: &Model) -> Self {
        Self {
            matrix: vec![0.0; 6 * model.nv],
            center_of_mass: DVec3::ZERO,
            mass: 0.0,
            composite: vec![RigidInertia::ZERO; model.bodies.len()],
            inertia: model.bodies.iter().map(|body| RigidInertia::in_body_axes(&body.inertia)).collect(),
        }
    }

    /// `h_G = A_G v`: angular momentum about the centre of mass and linear momentum, world axes.
    ///
    /// # Panics
    /// If the length of `v` is not nv.
    pub fn momentum(&self, v: &[f64]) -> SpatialVector {
        assert_eq!(6 * v.len(), self.matrix.len(), "length must be nv");
        let row =
            |r: usize| -> f64 { self.matrix[r * v.len()..(r + 1) * v.len()].iter().zip(v).map(|(a, v)| a * v).sum() };
        SpatialVector { angular: DVec3::new(row(0), row(1), row(2)), linear: DVec3::new(row(3), row(4), row(5)) }
    }
}

/// Centroidal momentum matrix `A_G(q)`: momentum of all bodies about their common centre of mass, world axes.
///
/// Rotor inertia (armature) is not part of it.
/// - `kinematics`: from [`forward_kinematics_into`](crate::forward_kinematics_into)
/// - `out`: see [`Centroidal`]
///
/// # Panics
/// If `out` belongs to another model.
///
/// # Cost
/// O(bodies + dofs), no allocation.
///
/// # Source
/// Orin, Goswami, Lee (2013), Centroidal dynamics of a humanoid robot, Autonomous Robots 35: column k is the momentum that
/// a unit rate of degree of freedom k gives to all it carries.
pub fn centroidal_momentum_matrix_into(model: &Model, kinematics: &Kinematics, out: &mut Centroidal) {
    assert_eq!(out.matrix.len(), 6 * model.nv, "the storage belongs to another model");
    out.center_of_mass = center_of_mass(model, kinematics);
    out.mass = 0.0;
    for i in 1..model.bodies.len() {
        out.composite[i] = out.inertia[i].turned(kinematics.rotation[i]);
    }
    for i in (1..model.bodies.len()).rev() {
        let body = &model.bodies[i];
        let composite = out.composite[i];
        let arm = kinematics.pose[i].position - out.center_of_mass;
        for k in model.dofs_of(BodyId(i as u32)) {
            let (moment, force) = composite.times(kinematics.dof_angular[k], kinematics.dof_linear[k]);
            let column = SpatialVector { angular: moment + arm.cross(force), linear: force };
            for (row, x) in column.to_array().into_iter().enumerate() {
                out.matrix[row * model.nv + k] = x;
            }
        }
        match body.parent {
            BodyId::WORLD => out.mass += composite.mass,
            parent => out.composite[parent.index()].add_at(&composite, kinematics.offset[i]),
        }
    }
}

/// Jacobian of the centre of mass of all bodies, `ċ = J v`, world axes: the linear rows of the centroidal momentum matrix
/// divided by the mass.
///
/// - `centroidal`: from [`centroidal_momentum_matrix_into`]
/// - `out`: `[3, nv]` row by row; zero if there is no mass
///
/// # Panics
/// If `out` does not have `3 nv` entries.
pub fn center_of_mass_jacobian_into(centroidal: &Centroidal, out: &mut [f64]) {
    let linear = &centroidal.matrix[centroidal.matrix.len() / 2..];
    assert_eq!(out.len(), linear.len(), "the Jacobian needs 3 nv entries");
    let factor = if centroidal.mass > 0.0 { 1.0 / centroidal.mass } else { 0.0 };
    out.iter_mut().zip(linear).for_each(|(j, p)| *j = p * factor);
}
