//! `<equality>`: points that stay together, welds, and coupled joints.

use signorini_multibody::glam::{DQuat, DVec3};
use signorini_multibody::{BodyId, EqualityKind, Pose};

use super::Importer;
use crate::error::FormatError;
use crate::parts::JointRecord;
use crate::xml::{Attributes, Element};

/// Elements whose defaults apply to every constraint.
const KINDS: [&str; 1] = ["equality"];

pub(super) fn read<'t>(importer: &mut Importer<'t>, root: Element<'t>) -> Result<(), FormatError> {
    for element in root.children_named("equality").flat_map(|e| e.children()) {
        let a = importer.defaults.of(element, None, &KINDS)?;
        let kind = match element.name() {
            "connect" => connect(importer, &a)?,
            "weld" => weld(importer, &a)?,
            "joint" => coupled_joints(importer, &a)?,
            _ => continue,
        };
        let (Some(kind), true) = (kind, a.flag("active")?.unwrap_or(true) && !importer.equalities_disabled) else {
            continue;
        };
        let name = element.raw("name").map(|n| n.value.trim().to_owned()).filter(|n| !n.is_empty());
        importer.parts.add_equality(element, name, kind)?;
    }
    Ok(())
}

/// The two bodies; none, with a warning, where sites are given instead.
fn bodies(importer: &mut Importer, a: &Attributes) -> Result<Option<(BodyId, BodyId)>, FormatError> {
    if a.has("site1") || a.has("site2") {
        let what = "between sites is not supported";
        let element = a.element();
        importer.report.motion(element.at(), element.name(), what, "the constraint is left out");
        return Ok(None);
    }
    let body = |attribute: &'static str, name: &str| {
        importer.parts.body(name).ok_or_else(|| a.unknown(attribute, "body", importer.parts.body_names()))
    };
    let first = body("body1", a.required("body1", "the first body")?)?;
    let second = a.text("body2").map_or(Ok(BodyId::WORLD), |name| body("body2", name))?;
    Ok(Some((first, second)))
}

/// `anchor` is a point of the first body; the second body's is where it is at the reference configuration.
fn connect(importer: &mut Importer, a: &Attributes) -> Result<Option<EqualityKind>, FormatError> {
    let Some((body_a, body_b)) = bodies(importer, a)? else { return Ok(None) };
    let anchor = a.vec3("anchor")?.ok_or_else(|| a.element().incomplete("attribute 'anchor': the point, in body1"))?;
    let [pose_a, pose_b] = [body_a, body_b].map(|body| importer.parts.builder.reference_pose(body));
    let point_b = pose_b.inverse().transform_point(pose_a.transform_point(anchor));
    Ok(Some(EqualityKind::Connect { body_a, point_a: anchor, body_b, point_b }))
}

/// The frame of the second body stands at `anchor` in it; `relpose` is the second body in the first, as at the reference
/// configuration where its quaternion is zero.
fn weld(importer: &mut Importer, a: &Attributes) -> Result<Option<EqualityKind>, FormatError> {
    let Some((body_a, body_b)) = bodies(importer, a)? else { return Ok(None) };
    let ([x, y, z, w, i, j, k], _) = a.overlay::<7>("relpose", [0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0])?;
    let given = DQuat::from_xyzw(i, j, k, w);
    let relative = if given.length() > 0.0 {
        Pose::new(DVec3::new(x, y, z), given.normalize())
    } else {
        let [pose_a, pose_b] = [body_a, body_b].map(|body| importer.parts.builder.reference_pose(body));
        pose_a.inverse() * pose_b
    };
    let frame_b = Pose::from_position(a.vec3("anchor")?.unwrap_or(DVec3::ZERO));
    Ok(Some(EqualityKind::Weld { body_a, frame_a: relative * frame_b, body_b, frame_b }))
}

/// `joint1` follows `joint2` by the polynomial `polycoef`, or stays at its constant.
fn coupled_joints(importer: &mut Importer, a: &Attributes) -> Result<Option<EqualityKind>, FormatError> {
    let joint = |attribute: &'static str, name: &str| -> Result<JointRecord, FormatError> {
        let unknown = || a.unknown(attribute, "joint", importer.parts.joint_names());
        let joint = importer.parts.joint(name).ok_or_else(unknown)?;
        if joint.kind.nv() == 1 { Ok(joint) } else { Err(a.invalid(attribute, "a hinge or slide")) }
    };
    let follower = joint("joint1", a.required("joint1", "the joint that follows")?)?;
    let driver = a.text("joint2").map(|name| joint("joint2", name)).transpose()?;
    let (polynomial, _) = a.overlay::<5>("polycoef", [0.0, 1.0, 0.0, 0.0, 0.0])?;
    Ok(Some(EqualityKind::Joint { joint: follower.id, driver: driver.map(|d| d.id), polynomial }))
}
