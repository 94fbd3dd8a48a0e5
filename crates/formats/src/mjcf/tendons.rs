//! `<tendon>`: fixed tendons.

use signorini_multibody::Tendon;

use super::importer::Importer;
use super::joints::linear;
use crate::error::FormatError;
use crate::xml::{Attributes, Element};

pub(super) fn read<'t>(importer: &mut Importer<'t>, root: Element<'t>) -> Result<(), FormatError> {
    for element in root.children_named("tendon").flat_map(|t| t.children()) {
        let made = match element.is("fixed") {
            true => {
                let read = read_fixed(importer, element);
                importer.unless_left_out(element, read)?.is_some()
            }
            false => false,
        };
        if !made && let Some(name) = element.attributes().text("name") {
            importer.left_out_tendons.insert(name);
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
    tendon.rest = rest(&a, reference)?;
    tendon.limits = importer.range(&a, "range", "limited")?;
    tendon.stiffness = linear(importer, &a, "stiffness")?;
    tendon.damping = linear(importer, &a, "damping")?;
    let name = element.raw("name").map(|n| n.value.trim().to_owned()).filter(|n| !n.is_empty());
    importer.parts.add_tendon(element, name, tendon)?;
    Ok(())
}

/// `springlength`: one length or a range; by default, where it is −1, that at which the springs of its joints
/// rest.
fn rest(a: &Attributes, reference: f64) -> Result<[f64; 2], FormatError> {
    let rest = match a.numbers("springlength")?.as_deref() {
        None => [reference; 2],
        Some(&[-1.0]) => [reference; 2],
        Some(&[length]) => [length; 2],
        Some(&[-1.0, -1.0]) => [reference; 2],
        Some(&[low, high]) if low <= high => [low, high],
        Some(_) => return Err(a.invalid("springlength", "one length, or two with the smaller first")),
    };
    Ok(rest)
}
