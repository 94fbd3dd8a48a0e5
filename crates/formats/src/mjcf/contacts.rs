//! `<contact>`: pairs with a friction of their own, and pairs of bodies that never touch.

use std::collections::HashSet;

use signorini_multibody::{BodyId, GeomId, GeomPair, SpinResistance};

use super::importer::Importer;
use crate::error::FormatError;
use crate::xml::{Attributes, Element};

/// Of a pair that does not say its own: sliding along two directions, spinning and rolling in m (MuJoCo's default).
const FRICTION: [f64; 5] = [1.0, 1.0, 0.005, 0.0001, 0.0001];

pub(super) fn read<'t>(importer: &mut Importer<'t>, root: Element<'t>) -> Result<(), FormatError> {
    for element in root.children_named("contact").flat_map(|c| c.children()) {
        match element.name() {
            "pair" => {
                let read = read_pair(importer, element);
                importer.unless_left_out(element, read)?;
            }
            "exclude" => {
                let a = element.attributes();
                let bodies = body(importer, &a, "body1").and_then(|first| Ok((first, body(importer, &a, "body2")?)));
                if let Some((first, second)) = importer.unless_left_out(element, bodies)? {
                    importer.parts.builder.exclude(first, second);
                }
            }
            _ => {}
        }
    }
    Ok(())
}

/// The names in all pairs.
pub(super) fn paired_geoms<'t>(root: Element<'t>) -> HashSet<&'t str> {
    let pairs = root.children_named("contact").flat_map(|c| c.children_named("pair"));
    pairs.flat_map(|p| ["geom1", "geom2"].map(|end| p.attributes().text(end))).flatten().collect()
}

/// Names of geoms whose contacts or distances sensors measure.
pub(super) fn measured_geoms<'t>(root: Element<'t>) -> HashSet<&'t str> {
    let sensors = root.children_named("sensor").flat_map(|s| s.children());
    sensors.flat_map(|s| ["geom1", "geom2"].map(|end| s.attributes().text(end))).flatten().collect()
}

/// A pair says all of its contact itself; what its geoms say does not count (MuJoCo 4, `contact/pair`).
fn read_pair<'t>(importer: &mut Importer<'t>, element: Element<'t>) -> Result<(), FormatError> {
    let a = importer.defaults.of(element, None, &["pair"])?;
    let (geom_a, geom_b) = (geom(importer, &a, "geom1")?, geom(importer, &a, "geom2")?);
    let ([slide_x, slide_y, spinning_friction, roll_x, roll_y], _) = a.overlay::<5>("friction", FRICTION)?;
    if slide_x < 0.0 || spinning_friction < 0.0 || roll_x < 0.0 {
        return Err(a.invalid("friction", "numbers that are not negative"));
    }
    if slide_x != slide_y {
        let effect = "the first of the two sliding coefficients counts in all directions";
        importer.report.motion(a.at("friction"), "pair", "anisotropic friction is not supported", effect);
    }
    if roll_x != roll_y {
        let effect = "the first of the two rolling coefficients counts in all directions";
        importer.report.motion(a.at("friction"), "pair", "anisotropic rolling friction is not supported", effect);
    }
    let (frictional, spin_resistance) = importer.condim(&a)?.unwrap_or((true, SpinResistance::None));
    let friction = if frictional { slide_x } else { 0.0 };
    if !importer.contacts_disabled {
        importer.parts.builder.add_pair(
            GeomPair::new(geom_a, geom_b, friction)
                .with_spin_resistance(spin_resistance)
                .with_spinning_friction(spinning_friction)
                .with_rolling_friction(roll_x)
                .with_margin(a.non_negative("margin")?.unwrap_or(0.0)),
        );
    }
    Ok(())
}

fn body(importer: &Importer, a: &Attributes, attribute: &'static str) -> Result<BodyId, FormatError> {
    let name = a.required(attribute, "the name of a body")?;
    importer.parts.body(name).ok_or_else(|| a.unknown(attribute, "body", importer.parts.body_names()))
}

fn geom(importer: &Importer, a: &Attributes, attribute: &'static str) -> Result<GeomId, FormatError> {
    let name = a.required(attribute, "the name of a geom")?;
    importer.parts.geom(name).ok_or_else(|| a.unknown(attribute, "geom", importer.parts.geom_names()))
}
