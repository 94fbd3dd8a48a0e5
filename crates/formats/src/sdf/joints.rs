//! `<joint>`: the joints of the tree.

use signorini_multibody::glam::DVec3;
use signorini_multibody::{BodyId, Joint, JointKind, Pose};

use super::frames::Frames;
use super::importer::Importer;
use super::tree::{Edge, Placed};
use super::values;
use crate::error::FormatError;
use crate::parts::limits_between;
use crate::xml::{Element, infinity};

/// Adds the joint that moves a body, if its type has any freedom. `here`: the body in world.
pub(super) fn add<'t>(
    importer: &mut Importer,
    frames: &Frames<'t>,
    edge: &Edge<'t>,
    placed: &Placed,
    body: BodyId,
    here: &Pose,
) -> Result<(), FormatError> {
    let element = edge.element;
    let sort = element.attributes().required("type", "revolute, continuous, prismatic, ball, universal or fixed")?;
    let reversed = edge.child != Some(placed.link);
    let name = frames.label(edge.entity).to_owned();
    let to_body = frames.pose(placed.link).inverse();
    let anchor = (to_body * frames.pose(edge.entity)).position;
    let axes: &[&'static str] = match sort {
        "fixed" => return Ok(()),
        "ball" => {
            let joint = ball(importer, element)?.with_anchor(anchor);
            return importer.parts.add_joint(element, Some(name), body, here, joint).map(drop);
        }
        "revolute" | "continuous" | "prismatic" => &["axis"],
        "universal" | "revolute2" => &["axis", "axis2"],
        // Drake has planar ones.
        "screw" | "planar" => {
            let what = format!("of type '{sort}' is not supported");
            importer.report.motion(element.at(), "joint", what, "its links are welded together");
            return Ok(());
        }
        _ => return Err(element.invalid(format!("type '{sort}' is not one of SDF's"))),
    };
    // The first axis is fixed to the parent, the second to the child; seen from the other side they change places.
    let ordered: Vec<&'static str> = if reversed { axes.iter().rev().copied().collect() } else { axes.to_vec() };
    for axis_name in ordered {
        let axis = element.child(axis_name);
        if axis.is_none() && !has_default(importer, element, axis_name) {
            continue;
        }
        let direction = to_body.rotation * direction(importer, frames, edge, axis)?;
        let direction = if reversed { -direction } else { direction }.normalize();
        let kind = match sort {
            "prismatic" => JointKind::Slide { axis: direction },
            _ => JointKind::Hinge { axis: direction },
        };
        let mut joint = Joint::new("", kind).with_anchor(anchor);
        if let Some(axis) = axis.filter(|_| sort != "continuous") {
            joint.limits = limits(axis)?;
        }
        if let Some(dynamics) = axis.and_then(|axis| axis.child("dynamics")) {
            read_dynamics(dynamics, &mut joint)?;
        }
        let own = if axis_name == "axis2" { format!("{name}_2") } else { name.clone() };
        importer.parts.add_joint(element, Some(own), body, here, joint)?;
    }
    Ok(())
}

/// A ball joint, with the damping and friction of its axis. Limits of it are reported.
fn ball(importer: &mut Importer, element: Element) -> Result<Joint, FormatError> {
    let mut joint = Joint::new("", JointKind::Ball);
    let Some(axis) = element.child("axis") else { return Ok(joint) };
    if let Some(dynamics) = axis.child("dynamics") {
        joint.damping = values::non_negative(dynamics, "damping")?.unwrap_or(0.0);
        joint.friction_loss = values::non_negative(dynamics, "friction")?.unwrap_or(0.0);
    }
    if let Some(limit) = axis.child("limit").filter(|_| limits(axis).is_ok_and(|limits| limits.is_some())) {
        let effect = "it is left out: the joint turns in all directions";
        importer.report.motion(limit.at(), "limit", "belongs to a ball joint", effect);
    }
    Ok(joint)
}

/// Whether an axis that is not there is the default's, as is reported: that of a second one would be the first one's, and two hinges
/// about one axis are no mechanism.
fn has_default(importer: &mut Importer, joint: Element, axis_name: &str) -> bool {
    let is_first = axis_name == "axis";
    let effect = if is_first { "it is the z axis of the joint, as SDFormat's default" } else { "it has one axis" };
    importer.report.motion(joint.at(), "joint", format!("has no <{axis_name}>"), effect);
    is_first
}

/// The axis in world. `expressed_in` names its frame since 1.7; before, the joint's frame or, where
/// it is said and up to 1.4 always, the model's. The joint's z axis where there is none.
pub(super) fn direction<'t>(
    importer: &Importer,
    frames: &Frames<'t>,
    edge: &Edge<'t>,
    axis: Option<Element<'t>>,
) -> Result<DVec3, FormatError> {
    let Some(axis) = axis else { return Ok(frames.pose(edge.entity).rotation * DVec3::Z) };
    let xyz = values::direction(axis, "xyz", DVec3::Z)?;
    let scope = &frames.entities[edge.entity].scope;
    let in_model = importer.version_at(axis) <= 4 || values::flag(axis, "use_parent_model_frame")?.unwrap_or(false);
    let default = if in_model { frames.model_pose(edge.entity) } else { frames.pose(edge.entity) };
    let expressed = axis.child("xyz").and_then(|xyz| xyz.attributes().text("expressed_in"));
    Ok(frames.named_pose(axis, scope, expressed, default)?.rotation * xyz)
}

fn limits(axis: Element) -> Result<Option<[f64; 2]>, FormatError> {
    let Some(limit) = axis.child("limit") else { return Ok(None) };
    let open = |name| limit.child(name).is_some_and(|end| infinity(end.text()).is_some());
    let read = |name, none| if open(name) { Ok(none) } else { Ok(values::number(limit, name)?.unwrap_or(none)) };
    let (lower, upper): (f64, f64) = (read("lower", f64::NEG_INFINITY)?, read("upper", f64::INFINITY)?);
    if lower > upper {
        return Err(limit.invalid(format!("the upper limit {upper} is below the lower one {lower}")));
    }
    Ok(limits_between(lower, upper))
}

fn read_dynamics(dynamics: Element, joint: &mut Joint) -> Result<(), FormatError> {
    joint.damping = values::non_negative(dynamics, "damping")?.unwrap_or(0.0);
    joint.stiffness = values::non_negative(dynamics, "spring_stiffness")?.unwrap_or(0.0);
    joint.spring_reference = values::number(dynamics, "spring_reference")?.unwrap_or(0.0);
    joint.friction_loss = values::non_negative(dynamics, "friction")?.unwrap_or(0.0);
    Ok(())
}
