//! `<default>`: classes of attribute values.

use std::collections::HashMap;

use crate::error::FormatError;
use crate::xml::{Attributes, Element};

/// Name of the class at the top when the file gives it none.
const MAIN: &str = "main";

struct Class<'t> {
    sections: Vec<Element<'t>>,
    /// The class around it, and how many sections that had when this one began: what it says later does not concern this one.
    parent: Option<(&'t str, usize)>,
}

/// All classes of a file.
pub(super) struct Defaults<'t> {
    classes: HashMap<&'t str, Class<'t>>,
    main: &'t str,
}

impl<'t> Defaults<'t> {
    pub fn read(root: Element<'t>) -> Result<Self, FormatError> {
        let (top, attached): (Vec<Element>, Vec<Element>) =
            root.children_named("default").partition(|section| section.origin() == 0);
        let main = top.iter().find_map(|d| d.attributes().text("class").filter(|c| !c.is_empty())).unwrap_or(MAIN);
        let mut defaults = Self { classes: HashMap::new(), main };
        let mut open: Vec<(Element<'t>, (&'t str, usize))> = Vec::new();
        for (k, section) in top.iter().enumerate() {
            open.extend(section.children_named("default").map(|d| (d, (main, k + 1))));
        }
        defaults.classes.insert(main, Class { sections: top, parent: None });
        // The defaults of attached models have tops of their own, which inherit nothing.
        for section in attached {
            let name = section.attributes().required("class", "the name of the default class")?;
            let class = defaults.classes.entry(name).or_insert(Class { sections: Vec::new(), parent: None });
            class.sections.push(section);
            let count = class.sections.len();
            open.extend(section.children_named("default").map(|d| (d, (name, count))));
        }
        while let Some((section, parent)) = open.pop() {
            let name = section.attributes().required("class", "the name of the default class")?;
            let class = Class { sections: vec![section], parent: Some(parent) };
            if let Some(first) = defaults.classes.insert(name, class) {
                let first = Box::new(first.sections.first().map_or_else(|| root.at(), |s| s.at()));
                let (at, name) = (section.at(), name.to_owned());
                return Err(FormatError::DuplicateName { at, sort: "default class", name, first });
            }
            open.extend(section.children_named("default").map(|d| (d, (name, 1))));
        }
        Ok(defaults)
    }

    /// The attributes of an element with the defaults of its class (its own `class`, else `inherited`, else the top one)
    /// for elements of any of the names `kinds`.
    pub fn of(
        &self,
        element: Element<'t>,
        inherited: Option<&'t str>,
        kinds: &[&str],
    ) -> Result<Attributes<'t>, FormatError> {
        let classes = self.classes_of(element, inherited, kinds)?;
        Ok(Attributes::new(element, classes.concat()))
    }

    /// The elements of the names `kinds` in the class of an element and in those above it, nearest class first and last element first.
    pub fn classes_of(
        &self,
        element: Element<'t>,
        inherited: Option<&'t str>,
        kinds: &[&str],
    ) -> Result<Vec<Vec<Element<'t>>>, FormatError> {
        let own = self.class_of(element, "class")?;
        let mut class = Some((own.or(inherited).unwrap_or(self.main), usize::MAX));
        let mut classes = Vec::new();
        while let Some((name, count)) = class {
            let Some(Class { sections, parent }) = self.classes.get(name) else { break };
            let elements = sections.iter().take(count).rev().flat_map(|s| s.children().rev());
            classes.push(elements.filter(|e| kinds.contains(&e.name())).collect());
            class = *parent;
        }
        Ok(classes)
    }

    /// The class an attribute (`class`, `childclass`) names, checked to exist.
    pub fn class_of(&self, element: Element<'t>, attribute: &'static str) -> Result<Option<&'t str>, FormatError> {
        let attributes = element.attributes();
        match attributes.text(attribute) {
            None | Some("") => Ok(None),
            Some(MAIN) => Ok(Some(self.main)),
            Some(name) if self.classes.contains_key(name) => Ok(Some(name)),
            Some(_) => Err(attributes.unknown(attribute, "default class", self.classes.keys().copied())),
        }
    }
}
