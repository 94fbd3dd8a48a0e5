//! Lengths of tendons and actuators, and how they change with the velocity.

use glamx::glam::DVec3;

use crate::jacobian::point_column;
use crate::kinematics::Kinematics;
use crate::math::{read_quaternion, rotation_log};
use crate::model::{Actuator, JointKind, Model, SiteId, Tendon, Transmission};

/// A length with its rate's row: `l̇ = Σ gradient[k] v[dofs[k]]`. Storage that is reused.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LengthRow {
    /// The length, m or rad.
    pub length: f64,
    /// Degrees of freedom, ascending.
    pub dofs: Vec<usize>,
    /// For each of `dofs` its entry.
    pub gradient: Vec<f64>,
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

    fn clear(&mut self) {
        self.length = 0.0;
        self.dofs.clear();
        self.gradient.clear();
    }

    fn add(&mut self, dof: usize, entry: f64) {
        match self.dofs.binary_search(&dof) {
            Ok(at) => self.gradient[at] += entry,
            Err(at) => {
                self.dofs.insert(at, dof);
                self.gradient.insert(at, entry);
            }
        }
    }

    fn scale(&mut self, factor: f64) {
        self.length *= factor;
        self.gradient.iter_mut().for_each(|g| *g *= factor);
    }
}

/// Length of a fixed tendon, `Σ c_j q_j`, with its row.
///
/// - `q`: `[nq]`
pub fn tendon_length_into(model: &Model, q: &[f64], tendon: &Tendon, out: &mut LengthRow) {
    out.clear();
    out.length = tendon.length(model, q);
    for &(joint, coefficient) in &tendon.terms {
        out.add(model.joints[joint.index()].v_index, coefficient);
    }
}

impl Tendon {
    /// Its length at a configuration, `[nq]`, m.
    pub fn length(&self, model: &Model, q: &[f64]) -> f64 {
        self.terms.iter().map(|&(joint, c)| c * q[model.joints[joint.index()].q_index]).sum()
    }
}

/// Length of an actuator with its row, gear included ([`Transmission`] says what the lengths are).
///
/// - `kinematics`: from [`forward_kinematics_into`](crate::forward_kinematics_into) at `q`
/// - `q`: `[nq]`
///
/// # Source
/// MuJoCo's transmissions. Where a site is measured against a reference site, the row leaves out how the turning of the
/// reference moves its axes, as MuJoCo's does.
pub fn actuator_length_into(
    model: &Model,
    kinematics: &Kinematics,
    q: &[f64],
    actuator: &Actuator,
    out: &mut LengthRow,
) {
    out.clear();
    match &actuator.transmission {
        Transmission::Joint(joint) => {
            let joint = &model.joints[joint.index()];
            out.length = q[joint.q_index];
            out.add(joint.v_index, 1.0);
        }
        Transmission::JointAxes { joint, axes } => {
            let joint = &model.joints[joint.index()];
            if joint.kind == JointKind::Ball {
                let turn = rotation_log(read_quaternion(&q[joint.q_index..]));
                out.length = turn.dot(DVec3::from_slice(axes));
            }
            (0..joint.kind.nv()).for_each(|k| out.add(joint.v_index + k, axes[k]));
        }
        Transmission::Tendon(tendon) => tendon_length_into(model, q, &model.tendons[tendon.index()], out),
        Transmission::Site { site, reference, wrench } => {
            site_length_into(model, kinematics, *site, *reference, wrench, out);
        }
    }
    out.scale(actuator.gear);
}

fn site_length_into(
    model: &Model,
    kinematics: &Kinematics,
    site: SiteId,
    reference: Option<SiteId>,
    wrench: &[f64; 6],
    out: &mut LengthRow,
) {
    let pose = |id: SiteId| {
        let site = &model.sites[id.index()];
        (site.body, kinematics.pose[site.body.index()] * site.placement)
    };
    let (body, placed) = pose(site);
    let (along, about) = (DVec3::from_slice(wrench), DVec3::from_slice(&wrench[3..]));
    let axes = reference.map_or(placed, |r| pose(r).1);
    let (force, moment) = (axes.rotation * along, axes.rotation * about);
    let mut own = model.body_last_dof[body.index()];
    let mut other = None;
    if let Some((carrier, at)) = reference.map(pose) {
        let turn = rotation_log(at.rotation.conjugate() * placed.rotation);
        out.length = at.inverse().transform_point(placed.position).dot(along) + turn.dot(about);
        other = model.body_last_dof[carrier.index()];
    }
    let reference_point = axes.position;
    let entry =
        |k: usize, at: DVec3| force.dot(point_column(model, kinematics, k, at)) + moment.dot(kinematics.dof_angular[k]);
    // The later of two degrees of freedom cannot move both bodies; those that do cancel.
    while own != other {
        if own > other {
            own = own.and_then(|k| {
                out.add(k, entry(k, placed.position));
                model.dof_parent[k]
            });
        } else {
            other = other.and_then(|k| {
                out.add(k, -entry(k, reference_point));
                model.dof_parent[k]
            });
        }
    }
}
