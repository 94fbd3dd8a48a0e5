//! Lengths of actuators.

use glamx::glam::DVec3;

use crate::kinematics::Kinematics;
use crate::length::LengthRow;
use crate::math::{read_quaternion, rotation_log};
use crate::model::{Actuator, BodyId, JointKind, Model, SiteId, Transmission};
use crate::tendon::tendon_length_into;

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
        Transmission::Tendon(tendon) => tendon_length_into(model, kinematics, q, &model.tendons[tendon.index()], out),
        Transmission::Site { site, reference, wrench } => {
            site_length_into(model, kinematics, *site, *reference, wrench, out);
        }
        Transmission::Body { .. } => {}
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
    let wrench = [along, about].map(|x| axes.rotation * x);
    let mut carrier = BodyId::WORLD;
    if let Some((body, at)) = reference.map(pose) {
        let turn = rotation_log(at.rotation.conjugate() * placed.rotation);
        out.length = at.inverse().transform_point(placed.position).dot(along) + turn.dot(about);
        carrier = body;
    }
    out.add_force(model, kinematics, (body, placed.position), wrench, (carrier, axes.position));
}
