//! `<joint>` and `<freejoint>`.

use signorini_multibody::glam::DVec3;
use signorini_multibody::{Joint, JointKind, Model, unit_vector};

use super::importer::Importer;
use super::scope::{OpenBody, Scope};
use crate::error::{FormatError, Location};
use crate::report::Reporter;
use crate::xml::{Attributes, Element};

#[derive(Clone, Copy, PartialEq, Eq)]
enum Type {
    Free,
    Ball,
    Slide,
    Hinge,
}

pub(super) fn read<'t>(
    importer: &mut Importer<'t>,
    element: Element<'t>,
    scope: &Scope<'t>,
    body: &OpenBody,
) -> Result<(), FormatError> {
    let name = scope.name(element);
    if element.is("freejoint") {
        let joint = Joint::new("", JointKind::Free);
        return importer.parts.add_joint(element, name, body.id, &body.pose, joint).map(drop);
    }
    let attributes = importer.defaults.of(element, scope.class, &["joint"])?;
    let mut joint = read_joint(importer, &attributes, scope)?;
    let range = joint.limits;
    draw_in_limits(importer, &attributes, &mut joint)?;
    if importer.limits_disabled {
        joint.limits = None;
    }
    let bounded = matches!(joint.kind, JointKind::Hinge { .. } | JointKind::Slide { .. });
    let id = importer.parts.add_joint(element, name, body.id, &body.pose, joint)?;
    if let Some(record) = importer.parts.joints.last_mut() {
        record.limits = range; // What actuators inherit.
    }
    if attributes.flag("actuatorgravcomp")?.unwrap_or(false) {
        importer.actuator_compensated.push(attributes.at("actuatorgravcomp"));
    }
    if let Some(bounds) = importer.range(&attributes, "actuatorfrcrange", "actuatorfrclimited")?.filter(|_| bounded) {
        importer.actuator_force_ranges.push((id, bounds, attributes.at("actuatorfrcrange")));
    }
    Ok(())
}

fn read_joint(importer: &mut Importer, a: &Attributes, scope: &Scope) -> Result<Joint, FormatError> {
    let types = [("free", Type::Free), ("ball", Type::Ball), ("slide", Type::Slide), ("hinge", Type::Hinge)];
    let sort = a.choice("type", &types)?.unwrap_or(Type::Hinge);
    let axis = match sort {
        Type::Hinge | Type::Slide => scope.frame.rotation * a.direction("axis")?.unwrap_or(DVec3::Z),
        _ => DVec3::Z,
    };
    let kind = match sort {
        Type::Free => JointKind::Free,
        Type::Ball => JointKind::Ball,
        Type::Slide => JointKind::Slide { axis: unit_vector(axis) },
        Type::Hinge => JointKind::Hinge { axis: unit_vector(axis) },
    };
    let unit = if sort == Type::Hinge { importer.compiler(a.element()).angle(1.0) } else { 1.0 };
    let mut joint = Joint::new("", kind);
    if sort != Type::Free {
        joint.anchor = scope.frame.transform_point(a.vec3("pos")?.unwrap_or(DVec3::ZERO));
    }
    if matches!(sort, Type::Hinge | Type::Slide) {
        joint.reference = unit * a.number_or("ref", 0.0)?;
        joint.spring_reference = unit * a.number_or("springref", 0.0)?;
    }
    joint.limits = limits(importer, a, sort, unit)?;
    joint.stiffness = stiffness(importer, a, sort)?;
    joint.damping = linear(importer, a, "damping")?;
    joint.armature = a.non_negative("armature")?.unwrap_or(0.0);
    joint.friction_loss = a.non_negative("frictionloss")?.unwrap_or(0.0);
    joint.friction_loss *= acts(importer.friction_loss_disabled);
    joint.stiffness *= acts(importer.springs_disabled);
    joint.damping *= acts(importer.dampers_disabled);
    Ok(joint)
}

fn limits(importer: &mut Importer, a: &Attributes, sort: Type, unit: f64) -> Result<Option<[f64; 2]>, FormatError> {
    // What a default says about limits does not concern a free joint.
    if sort == Type::Free {
        return Ok(None);
    }
    if sort == Type::Ball && !a.has("range") && a.text("limited") == Some("true") {
        let effect = "the joint turns without limit: give it a range";
        importer.report.motion(a.at("limited"), "joint", "a limited ball joint without a range", effect);
        return Ok(None);
    }
    let Some(range) = importer.range(a, "range", "limited")? else { return Ok(None) };
    match sort {
        Type::Free => Ok(None),
        Type::Ball => ball_limits(importer, a, range),
        Type::Slide | Type::Hinge => Ok(Some(range.map(|x| unit * x))),
    }
}

/// Factor of a coefficient that a flag may switch off.
pub(super) fn acts(disabled: bool) -> f64 {
    f64::from(!disabled)
}

/// Reports joints whose gravity compensation is to be a force of actuators, where there is any.
pub(super) fn report_compensation(model: &Model, joints: &[Location], report: &mut Reporter) {
    if model.bodies.iter().all(|body| body.gravity_compensation == 0.0) {
        return;
    }
    for at in joints {
        let effect = "it acts beside the actuators: no bound of theirs cuts it, and it acts where there are none";
        report.motion(at.clone(), "joint", "gravity compensation by actuators is not supported", effect);
    }
}

/// `margin`: the limits act that much before their range ends, as in MuJoCo, where the force begins there.
fn draw_in_limits(importer: &mut Importer, a: &Attributes, joint: &mut Joint) -> Result<(), FormatError> {
    let given = a.non_negative("margin")?.unwrap_or(0.0);
    let (Some([low, high]), true) = (joint.limits, given > 0.0) else { return Ok(()) };
    let drawn_in = match joint.kind {
        JointKind::Ball => [0.0, high - given],
        _ => [low + given, high - given],
    };
    if drawn_in[0] < drawn_in[1] {
        joint.limits = Some(drawn_in);
    } else {
        let effect = "the limits act where they are: give a margin below half of the range";
        importer.report.motion(a.at("margin"), "joint", "the margin leaves nothing of the range", effect);
    }
    Ok(())
}

/// The largest angle of a ball joint, after a 0; it has no effect from half a turn on.
fn ball_limits(importer: &Importer, a: &Attributes, range: [f64; 2]) -> Result<Option<[f64; 2]>, FormatError> {
    let [lower, upper] = range.map(|x| importer.compiler(a.element()).angle(x));
    if lower != 0.0 {
        return Err(a.invalid("range", "0 first, then the largest angle of the ball joint"));
    }
    Ok((upper < std::f64::consts::PI).then_some([lower, upper]))
}

fn stiffness(importer: &mut Importer, a: &Attributes, sort: Type) -> Result<f64, FormatError> {
    let stiffness = linear(importer, a, "stiffness")?;
    if stiffness > 0.0 && matches!(sort, Type::Ball | Type::Free) {
        let what = "stiffness of a ball or free joint is not supported";
        importer.report.motion(a.at("stiffness"), "joint", what, "the joint has no spring");
        return Ok(0.0);
    }
    Ok(stiffness)
}

/// The first of up to three polynomial coefficients.
pub(super) fn linear(importer: &mut Importer, a: &Attributes, name: &'static str) -> Result<f64, FormatError> {
    let ([first, second, third], _) = a.overlay::<3>(name, [0.0; 3])?;
    if second != 0.0 || third != 0.0 {
        let what = format!("second and third coefficient of '{name}' are not supported");
        importer.report.motion(a.at(name), a.element().name(), what, "the force is linear");
    }
    if first < 0.0 {
        let what = format!("a negative '{name}', which gives energy, is not supported");
        importer.report.motion(a.at(name), a.element().name(), what, format!("there is no {name}"));
    }
    Ok(first.max(0.0))
}
