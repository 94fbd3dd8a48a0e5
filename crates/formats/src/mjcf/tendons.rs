//! `<tendon>`: fixed and spatial tendons.

use signorini_multibody::{Kinematics, Model, PathPart, Tendon, TendonId, forward_kinematics_into};

use super::importer::Importer;
use super::joints::{acts, linear};
use super::sensors::site;
use crate::error::FormatError;
use crate::xml::{Attributes, Element};

pub(super) fn read<'t>(importer: &mut Importer<'t>, root: Element<'t>) -> Result<(), FormatError> {
    for element in root.children_named("tendon").flat_map(|t| t.children()) {
        let read = match element.name() {
            "fixed" => read_fixed(importer, element),
            "spatial" => read_spatial(importer, element),
            // The audit of what is read says so.
            _ => {
                importer.left_out_tendons.extend(element.attributes().text("name"));
                continue;
            }
        };
        if importer.unless_left_out(element, read)?.is_none() {
            importer.left_out_tendons.extend(element.attributes().text("name"));
        }
    }
    Ok(())
}

fn read_fixed<'t>(importer: &mut Importer<'t>, element: Element<'t>) -> Result<(), FormatError> {
    let a = importer.defaults.of(element, None, &["tendon"])?;
    let mut terms = Vec::new();
    for term in element.children_named("joint") {
        let term = term.attributes();
        let name = term.required("joint", "a hinge or slide")?;
        let Some(joint) = importer.parts.joint(name) else {
            return Err(term.unknown("joint", "joint", importer.parts.joint_names()));
        };
        if joint.kind.nv() != 1 {
            return Err(term.invalid("joint", "a hinge or slide"));
        }
        let coefficient = term.number("coef")?;
        let coefficient = coefficient.ok_or_else(|| term.element().incomplete("attribute 'coef': its share"))?;
        terms.push((joint, coefficient));
    }
    if terms.is_empty() {
        return Err(element.incomplete("at least one <joint joint=\"…\" coef=\"…\"/>"));
    }
    let reference = terms.iter().map(|(joint, c)| c * joint.spring_reference).sum();
    let mut tendon = Tendon::new("", terms.iter().map(|(joint, c)| (joint.id, *c)).collect());
    tendon.rest = rest(&a)?.unwrap_or([reference; 2]);
    add(importer, element, &a, tendon).map(drop)
}

fn read_spatial<'t>(importer: &mut Importer<'t>, element: Element<'t>) -> Result<(), FormatError> {
    let a = importer.defaults.of(element, None, &["tendon"])?;
    let path = element.children().map(|part| path_part(importer, part)).collect::<Result<Vec<_>, _>>()?;
    if path.is_empty() {
        return Err(element.incomplete("at least two <site site=\"…\"/>"));
    }
    let rest = rest(&a)?;
    let id = add(importer, element, &a, Tendon::along("", path).with_rest(rest.unwrap_or_default()))?;
    if rest.is_none() {
        importer.resting_tendons.push(id);
    }
    Ok(())
}

fn path_part(importer: &Importer, part: Element) -> Result<PathPart, FormatError> {
    let a = part.attributes();
    match part.name() {
        "site" => Ok(PathPart::Site(site(importer, &a, "site")?)),
        "geom" => {
            let name = a.required("geom", "the sphere or cylinder in the way")?;
            let geom =
                importer.parts.geom(name).ok_or_else(|| a.unknown("geom", "geom", importer.parts.geom_names()))?;
            let side = if a.has("sidesite") { Some(site(importer, &a, "sidesite")?) } else { None };
            Ok(PathPart::Wrap { geom, side })
        }
        "pulley" => {
            let divisor = a.number("divisor")?.filter(|x| *x > 0.0);
            let divisor = divisor.ok_or_else(|| part.incomplete("attribute 'divisor': a positive number"))?;
            Ok(PathPart::Pulley { divisor })
        }
        _ => Err(part.invalid("expected <site>, <geom> or <pulley>".to_owned())),
    }
}

fn add<'t>(
    importer: &mut Importer<'t>,
    element: Element<'t>,
    a: &Attributes<'t>,
    mut tendon: Tendon,
) -> Result<TendonId, FormatError> {
    let range = importer.range(a, "range", "limited")?;
    tendon.limits = range.filter(|_| !importer.limits_disabled);
    tendon.stiffness = acts(importer.springs_disabled) * linear(importer, a, "stiffness")?;
    tendon.damping = acts(importer.dampers_disabled) * linear(importer, a, "damping")?;
    let name = element.raw("name").map(|n| n.value.trim().to_owned()).filter(|n| !n.is_empty());
    let id = importer.parts.add_tendon(element, name, tendon)?;
    importer.tendon_ranges.extend(range.map(|range| (id, range)));
    Ok(id)
}

/// Where springs of spatial tendons rest that the file does not give: at their lengths where the springs of the joints rest.
pub(super) fn rest_with_joints(model: &mut Model, tendons: &[TendonId]) {
    if tendons.is_empty() {
        return;
    }
    let mut q = model.reference_configuration();
    for joint in model.joints.iter().filter(|joint| joint.kind.nv() == 1) {
        q[joint.q_index] = joint.spring_reference;
    }
    let mut kinematics = Kinematics::new(model);
    forward_kinematics_into(model, &q, &vec![0.0; model.nv], &mut kinematics);
    for id in tendons {
        let length = model.tendons[id.index()].length(model, &kinematics, &q);
        model.tendons[id.index()].rest = [length; 2];
    }
}

/// `springlength`: one length or a range; nothing where it is −1, its default.
fn rest(a: &Attributes) -> Result<Option<[f64; 2]>, FormatError> {
    Ok(match a.numbers("springlength")?.as_deref() {
        None | Some(&[-1.0] | &[-1.0, -1.0]) => None,
        Some(&[length]) => Some([length; 2]),
        Some(&[low, high]) if low <= high => Some([low, high]),
        Some(_) => return Err(a.invalid("springlength", "one length, or two with the smaller first")),
    })
}
