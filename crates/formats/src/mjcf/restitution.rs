//! Coefficients of restitution, which MJCF has no element for ([`custom`](super::custom)).

use std::collections::HashMap;

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

    /// Where the coefficient of a geom is given whose name is one of these.
    pub fn given_to(&self, named: impl Fn(&str) -> bool) -> Option<&Attributes<'t>> {
        self.own.iter().find(|(geom, _)| named(geom)).map(|(_, (_, a))| a)
    }
}
