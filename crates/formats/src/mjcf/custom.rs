//! `<custom>`: what MJCF has no element for, under names that begin with `signorini:`.
//!
//! - `<numeric name="signorini:restitution" data="0.6"/>`: coefficient of restitution of all geoms;
//! - `<numeric name="signorini:restitution:ball" data="0.9"/>`: of the geom `ball`.

use std::collections::HashMap;

use super::Importer;
use crate::error::FormatError;
use crate::xml::{Attributes, Element};

const RESTITUTION: &str = "signorini:restitution";

/// Coefficients of restitution.
#[derive(Default)]
pub(super) struct Restitution<'t> {
    /// Of geoms without one of their own.
    common: f64,
    own: HashMap<&'t str, (f64, Attributes<'t>)>,
}

impl<'t> Restitution<'t> {
    pub fn read(root: Element<'t>) -> Result<Self, FormatError> {
        let mut restitution = Self::default();
        let numbers = root.children_named("custom").flat_map(|c| c.children_named("numeric"));
        for element in numbers {
            let a = element.attributes();
            let Some(rest) = a.text("name").and_then(|name| name.trim().strip_prefix(RESTITUTION)) else { continue };
            let value = match a.numbers("data")?.as_deref() {
                Some([e]) if (0.0..=1.0).contains(e) => *e,
                _ => return Err(a.invalid("data", "one number between 0 and 1")),
            };
            match rest.strip_prefix(':') {
                None if rest.is_empty() => restitution.common = value,
                Some(geom) => drop(restitution.own.insert(geom, (value, a))),
                None => return Err(a.invalid("name", "signorini:restitution or signorini:restitution:GEOM")),
            }
        }
        Ok(restitution)
    }

    /// Of a geom.
    pub fn of(&self, geom: Option<&str>) -> f64 {
        geom.and_then(|name| self.own.get(name)).map_or(self.common, |(e, _)| *e)
    }
}

/// Refuses coefficients of geoms that are not there.
pub(super) fn check(importer: &Importer) -> Result<(), FormatError> {
    for (geom, (_, a)) in &importer.restitution.own {
        if importer.parts.geom(geom).is_none() {
            return Err(a.invalid("name", "the name of a geom after 'signorini:restitution:'"));
        }
    }
    Ok(())
}
