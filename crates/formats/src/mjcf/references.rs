//! Which attributes of MJCF are names of other parts.

use std::collections::HashSet;

use crate::xml::Element;

/// Sections whose elements refer to parts of bodies, each after those that it refers to.
pub(super) const REFERRING: [&str; 5] = ["tendon", "contact", "equality", "actuator", "sensor"];

/// What a name belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Sort {
    Body,
    Joint,
    Geom,
    Site,
    Camera,
    Tendon,
    Actuator,
    Asset,
    Class,
}

/// The sort of part that an element's `name` belongs to; none if nothing refers to it.
fn defined(element: Element) -> Option<Sort> {
    let section = element.parent().map_or("", |parent| parent.name());
    match (section, element.name()) {
        ("tendon", _) => Some(Sort::Tendon),
        ("actuator", _) => Some(Sort::Actuator),
        ("equality" | "contact" | "sensor" | "default", _) => None,
        (_, "body") => Some(Sort::Body),
        (_, "joint" | "freejoint") => Some(Sort::Joint),
        (_, "geom") => Some(Sort::Geom),
        (_, "site") => Some(Sort::Site),
        (_, "camera") => Some(Sort::Camera),
        _ => None,
    }
}

/// The sort of part whose name is the value of an attribute; none where it is no reference.
fn referred(element: Element, attribute: &str) -> Option<Sort> {
    let by_type = |name: &str| match element.raw(name).map(|a| a.value.trim())? {
        "body" | "xbody" => Some(Sort::Body),
        "geom" => Some(Sort::Geom),
        "site" => Some(Sort::Site),
        "camera" => Some(Sort::Camera),
        _ => None,
    };
    match attribute {
        "class" | "childclass" => Some(Sort::Class),
        "body" | "body1" | "body2" | "subtree1" | "subtree2" | "target" => Some(Sort::Body),
        "joint" | "joint1" | "joint2" | "jointinparent" => Some(Sort::Joint),
        "geom" | "geom1" | "geom2" => Some(Sort::Geom),
        "site" | "site1" | "site2" | "refsite" | "slidersite" | "cranksite" | "sidesite" => Some(Sort::Site),
        "tendon" | "tendon1" | "tendon2" => Some(Sort::Tendon),
        "actuator" => Some(Sort::Actuator),
        "camera" => Some(Sort::Camera),
        "mesh" | "hfield" | "material" | "texture" => Some(Sort::Asset),
        "objname" => by_type("objtype"),
        "refname" => by_type("reftype"),
        _ => None,
    }
}

/// What an element refers to, with the attributes: sort and name.
pub(super) fn references<'t>(element: Element<'t>) -> impl Iterator<Item = (&'t str, Sort, &'t str)> {
    let attributes = element.raw_attributes().iter();
    attributes.filter_map(move |a| Some((a.name.as_str(), referred(element, &a.name)?, a.value.trim())))
}

/// Names of parts.
#[derive(Default)]
pub(super) struct Names(HashSet<(Sort, String)>);

impl Names {
    /// Adds the name of an element, if it has one that others refer to.
    pub fn add(&mut self, element: Element) {
        if let Some(name) = element.raw("name") {
            self.add_as(element, name.value.trim());
        }
    }

    /// Adds a name that an element has.
    pub fn add_as(&mut self, element: Element, name: &str) {
        self.0.extend(defined(element).map(|sort| (sort, name.to_owned())));
    }

    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub fn has(&self, sort: Sort, name: &str) -> bool {
        self.0.contains(&(sort, name.to_owned()))
    }
}
