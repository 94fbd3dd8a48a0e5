//! `<equality>`: points that stay together, welds, coupled joints and tendons.

use signorini_multibody::glam::{DQuat, DVec3};
use signorini_multibody::{BodyId, EqualityKind, Pose, unit_rotation};

use super::importer::Importer;
use super::sensors::{site, tendon};
use crate::error::FormatError;
use crate::parts::JointRecord;
use crate::xml::{Attributes, Element};

/// Elements whose defaults apply to every constraint.
const KINDS: [&str; 1] = ["equality"];

pub(super) fn read<'t>(importer: &mut Importer<'t>, root: Element<'t>) -> Result<(), FormatError> {
    for element in root.children_named("equality").flat_map(|e| e.children()) {
        let a = importer.defaults.of(element, None, &KINDS)?;
        let kind = match element.name() {
            "connect" => connect(importer, &a),
            "weld" => weld(importer, &a),
            "joint" => coupled_joints(importer, &a),
            "tendon" => match coupled_tendons(importer, &a) {
                Ok(Err(what)) => {
                    importer.report.motion(element.at(), element.name(), what, "the constraint is left out");
                    continue;
                }
                Ok(Ok(kind)) => Ok(kind),
                Err(error) => Err(error),
            },
            _ => continue,
        };
        let Some(kind) = importer.unless_left_out(element, kind)? else { continue };
        if !a.flag("active")?.unwrap_or(true) || importer.equalities_disabled {
            continue;
        }
        if a.has("site1") && is_within_one_body(&kind) {
            let effect = "it is left out: nothing moves them against each other";
            importer.report.motion(element.at(), element.name(), "joins two sites of one body", effect);
            continue;
        }
        let name = element.raw("name").map(|n| n.value.trim().to_owned()).filter(|n| !n.is_empty());
        importer.parts.add_equality(element, name, kind)?;
    }
    Ok(())
}

fn is_within_one_body(kind: &EqualityKind) -> bool {
    match kind {
        EqualityKind::Connect { body_a, body_b, .. } | EqualityKind::Weld { body_a, body_b, .. } => body_a == body_b,
        EqualityKind::Joint { .. } | EqualityKind::Tendon { .. } => false,
    }
}

/// The frames of two sites in their bodies, which are to coincide; nothing where bodies are named instead.
fn sites(importer: &Importer, a: &Attributes) -> Result<Option<[(BodyId, Pose); 2]>, FormatError> {
    if !a.has("site1") && !a.has("site2") {
        return Ok(None);
    }
    if let Some(other) = ["body1", "body2", "anchor", "relpose"].into_iter().find(|name| a.has(name)) {
        return Err(a.invalid(other, "nothing beside 'site1' and 'site2', which say what it says"));
    }
    let frame = |attribute: &'static str| {
        let site = importer.parts.builder.site(site(importer, a, attribute)?);
        Ok(site.map_or((BodyId::WORLD, Pose::IDENTITY), |site| (site.body, site.placement)))
    };
    Ok(Some([frame("site1")?, frame("site2")?]))
}

/// The two bodies.
fn bodies(importer: &Importer, a: &Attributes) -> Result<(BodyId, BodyId), FormatError> {
    let body = |attribute: &'static str, name: &str| {
        importer.parts.body(name).ok_or_else(|| a.unknown(attribute, "body", importer.parts.body_names()))
    };
    let first = body("body1", a.required("body1", "the first body")?)?;
    let second = a.text("body2").map_or(Ok(BodyId::WORLD), |name| body("body2", name))?;
    Ok((first, second))
}

/// Two sites, or `anchor`: a point of the first body; the second body's is where it is at the reference configuration.
fn connect(importer: &Importer, a: &Attributes) -> Result<EqualityKind, FormatError> {
    if let Some([(body_a, a), (body_b, b)]) = sites(importer, a)? {
        return Ok(EqualityKind::Connect { body_a, point_a: a.position, body_b, point_b: b.position });
    }
    let (body_a, body_b) = bodies(importer, a)?;
    let anchor = a.vec3("anchor")?.ok_or_else(|| a.element().incomplete("attribute 'anchor': the point, in body1"))?;
    let [pose_a, pose_b] = [body_a, body_b].map(|body| importer.parts.builder.reference_pose(body));
    let point_b = pose_b.inverse().transform_point(pose_a.transform_point(anchor));
    Ok(EqualityKind::Connect { body_a, point_a: anchor, body_b, point_b })
}

/// Two sites, or: the point `anchor` of the second body stands at the position of `relpose` in the first, whose quaternion turns the second
/// body against the first. Where that is zero, both are as at the reference configuration.
fn weld(importer: &Importer, a: &Attributes) -> Result<EqualityKind, FormatError> {
    if let Some([(body_a, frame_a), (body_b, frame_b)]) = sites(importer, a)? {
        return Ok(EqualityKind::Weld { body_a, frame_a, body_b, frame_b });
    }
    let (body_a, body_b) = bodies(importer, a)?;
    let ([x, y, z, w, i, j, k], _) = a.overlay::<7>("relpose", [0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0])?;
    let given = DQuat::from_xyzw(i, j, k, w);
    let frame_b = Pose::from_position(a.vec3("anchor")?.unwrap_or(DVec3::ZERO));
    let frame_a = if given.length() > 0.0 {
        Pose::new(DVec3::new(x, y, z), unit_rotation(given))
    } else {
        let [pose_a, pose_b] = [body_a, body_b].map(|body| importer.parts.builder.reference_pose(body));
        pose_a.inverse() * pose_b * frame_b
    };
    Ok(EqualityKind::Weld { body_a, frame_a, body_b, frame_b })
}

/// `tendon1` follows `tendon2` by the polynomial `polycoef`, or stays at its constant; a reason if one of them is left out.
fn coupled_tendons(importer: &Importer, a: &Attributes) -> Result<Result<EqualityKind, String>, FormatError> {
    let follower = tendon(importer, a, "tendon1")?;
    let driver = match a.has("tendon2") {
        true => tendon(importer, a, "tendon2")?.map(Some),
        false => Ok(None),
    };
    let (polynomial, _) = a.overlay::<5>("polycoef", [0.0, 1.0, 0.0, 0.0, 0.0])?;
    Ok(follower.and_then(|tendon| Ok(EqualityKind::Tendon { tendon, driver: driver?, polynomial })))
}

/// `joint1` follows `joint2` by the polynomial `polycoef`, or stays at its constant.
fn coupled_joints(importer: &Importer, a: &Attributes) -> Result<EqualityKind, FormatError> {
    let joint = |attribute: &'static str, name: &str| -> Result<JointRecord, FormatError> {
        let unknown = || a.unknown(attribute, "joint", importer.parts.joint_names());
        let joint = importer.parts.joint(name).ok_or_else(unknown)?;
        if joint.kind.nv() == 1 { Ok(joint) } else { Err(a.invalid(attribute, "a hinge or slide")) }
    };
    let follower = joint("joint1", a.required("joint1", "the joint that follows")?)?;
    let driver = a.text("joint2").map(|name| joint("joint2", name)).transpose()?;
    let (polynomial, _) = a.overlay::<5>("polycoef", [0.0, 1.0, 0.0, 0.0, 0.0])?;
    Ok(EqualityKind::Joint { joint: follower.id, driver: driver.map(|d| d.id), polynomial })
}
