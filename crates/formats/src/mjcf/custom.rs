//! `<custom>`: what MJCF has no element for, under names that begin with `signorini:`.
//!
//! - `<numeric name="signorini:restitution" data="0.6"/>`: coefficient of restitution of all geoms;
//! - `<numeric name="signorini:restitution:ball" data="0.9"/>`: of the geom `ball`;
//! - `<numeric name="signorini:grain:blade" data="0.05 1"/>`: factors of the friction of the geom `blade` along its x axis and across
//!   it;
//! - `<numeric name="signorini:speed:wheel" data="1"/>`: the actuator `wheel`, a `<velocity>` with a force range, holds its speed
//!   exactly until the range ends.

use std::collections::HashMap;

use signorini_multibody::{Actuator, ActuatorKind};

use super::importer::Importer;
use crate::error::FormatError;
use crate::xml::{Attributes, Element};

const GRAIN: &str = "signorini:grain";
const SPEED: &str = "signorini:speed";

/// The grain of geoms, by name.
pub(super) fn grains<'t>(root: Element<'t>) -> Result<HashMap<&'t str, ([f64; 2], Attributes<'t>)>, FormatError> {
    let mut grains = HashMap::new();
    for element in root.children_named("custom").flat_map(|c| c.children_named("numeric")) {
        let a = element.attributes();
        let Some(rest) = a.text("name").and_then(|name| name.trim().strip_prefix(GRAIN)) else { continue };
        let Some(geom) = rest.strip_prefix(':') else { return Err(a.invalid("name", "signorini:grain:GEOM")) };
        match a.numbers("data")?.as_deref() {
            Some(&[along, across]) if along > 0.0 && across > 0.0 => drop(grains.insert(geom, ([along, across], a))),
            _ => return Err(a.invalid("data", "two positive numbers: along and across the grain")),
        }
    }
    Ok(grains)
}

/// The actuators that shall hold their speed exactly, by name.
pub(super) fn speed_servos<'t>(root: Element<'t>) -> Result<HashMap<&'t str, Attributes<'t>>, FormatError> {
    let mut servos = HashMap::new();
    for element in root.children_named("custom").flat_map(|c| c.children_named("numeric")) {
        let a = element.attributes();
        let Some(rest) = a.text("name").and_then(|name| name.trim().strip_prefix(SPEED)) else { continue };
        let Some(actuator) = rest.strip_prefix(':') else {
            return Err(a.invalid("name", "signorini:speed:ACTUATOR"));
        };
        match a.numbers("data")?.as_deref() {
            Some([1.0]) => drop(servos.insert(actuator, a)),
            Some([0.0]) => {}
            _ => return Err(a.invalid("data", "1, or 0 for a servo with its gain")),
        }
    }
    Ok(servos)
}

/// Makes a servo of speed of an actuator that shall be one.
pub(super) fn hold_speed(
    importer: &mut Importer,
    actuator: &mut Actuator,
    name: Option<&str>,
) -> Result<(), FormatError> {
    let Some(a) = name.and_then(|name| importer.speed_servos.remove(name)) else { return Ok(()) };
    if !matches!(actuator.kind, ActuatorKind::Velocity { .. }) || actuator.force_range.is_none() {
        return Err(a.invalid("name", "the name of a <velocity> with a 'forcerange' after 'signorini:speed:'"));
    }
    actuator.kind = ActuatorKind::Speed;
    Ok(())
}

/// Refuses servos of speed that are not there; after all actuators.
pub(super) fn check_speed_servos(importer: &Importer) -> Result<(), FormatError> {
    match importer.speed_servos.values().next() {
        None => Ok(()),
        Some(a) => Err(a.invalid("name", "the name of an actuator after 'signorini:speed:'")),
    }
}

/// Refuses coefficients and grains of geoms that are not there.
pub(super) fn check(importer: &Importer) -> Result<(), FormatError> {
    let missing = |geom: &str| importer.parts.geom(geom).is_none();
    if let Some(a) = importer.restitution.given_to(missing) {
        return Err(a.invalid("name", "the name of a geom after 'signorini:restitution:'"));
    }
    match importer.grains.iter().find(|(geom, _)| missing(geom)) {
        None => Ok(()),
        Some((_, (_, a))) => Err(a.invalid("name", "the name of a geom after 'signorini:grain:'")),
    }
}
