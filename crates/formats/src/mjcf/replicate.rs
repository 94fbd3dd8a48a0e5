//! What refers to parts inside `<replicate>` is replicated with them.

use super::order::Arrivals;
use super::references::{Names, REFERRING, Sort, references};
use crate::error::FormatError;
use crate::xml::{Element, Tree};

/// More copies than this are refused.
const MOST: i64 = 100_000;

/// The suffixes of the copies that a `<replicate>` makes.
pub(super) fn suffixes(element: Element) -> Result<Vec<String>, FormatError> {
    let a = element.attributes();
    let count = match a.integer("count")? {
        Some(n) if (0..=MOST).contains(&n) => n as usize,
        _ => return Err(a.invalid("count", format!("a number of copies, 0 to {MOST}"))),
    };
    let (separator, digits) = (a.text("sep").unwrap_or_default(), count.to_string().len());
    Ok((0..count).map(|k| format!("{separator}{k:0digits$}")).collect())
}

/// Replaces every tendon, constraint, actuator or sensor that refers to a part of a `<replicate>` by one for each copy.
pub(super) fn expand_references(tree: &mut Tree, arrivals: &mut Arrivals) -> Result<(), FormatError> {
    let worlds = tree.root().children_named("worldbody");
    let replicates: Vec<usize> = worlds.flat_map(innermost_first).map(|e| e.index()).collect();
    for index in replicates {
        let suffixes = suffixes(tree.element(index))?;
        let mut names = Names::default();
        for element in tree.element(index).descendants() {
            for name in inner_names(element, tree.element(index))? {
                names.add_as(element, &name);
            }
        }
        if names.is_empty() {
            continue;
        }
        for section in REFERRING {
            if let Some(copies) = replicate_in(tree, section, &suffixes, &mut names) {
                arrivals.add(copies, index);
            }
        }
        tree.check_size()?;
    }
    Ok(())
}

/// All `<replicate>`s below an element in the order of the document, but each after those in it, whose suffixes come first in a name.
fn innermost_first(element: Element<'_>) -> Vec<Element<'_>> {
    let all = element.descendants();
    let inside = |outer: &Element| outer.descendants().len();
    let mut ends: Vec<(usize, usize, Element)> = all
        .iter()
        .enumerate()
        .filter(|(_, e)| e.is("replicate"))
        .map(|(k, e)| (k + inside(e), usize::MAX - k, *e))
        .collect();
    ends.sort_by_key(|&(end, start, _)| (end, start));
    ends.into_iter().map(|(_, _, e)| e).collect()
}

/// The names that a part has inside `outer`: with the suffixes of the `<replicate>`s between them.
fn inner_names(element: Element, outer: Element) -> Result<Vec<String>, FormatError> {
    let Some(name) = element.raw("name").map(|a| a.value.trim().to_owned()) else { return Ok(Vec::new()) };
    let mut names = vec![name];
    for above in element.ancestors().take_while(|e| e.index() != outer.index()).filter(|e| e.is("replicate")) {
        let suffixes = suffixes(above)?;
        names = names.iter().flat_map(|name| suffixes.iter().map(move |suffix| format!("{name}{suffix}"))).collect();
    }
    Ok(names)
}

/// Replaces the elements of the sections of a name that refer to `names` by copies with suffixes: one copy of all of them after the other, in
/// a section of their own, which is returned if there are any. Their own names become some that can be referred to.
fn replicate_in(tree: &mut Tree, name: &str, suffixes: &[String], names: &mut Names) -> Option<usize> {
    let sections: Vec<usize> = tree.root().children().filter(|e| e.is(name)).map(|e| e.index()).collect();
    let refers = |e: &Element| {
        let parts = e.descendants();
        parts.iter().any(|part| references(*part).any(|(_, sort, name)| names.has(sort, name)))
    };
    let all = sections.iter().flat_map(|&section| tree.element(section).children());
    let referring: Vec<usize> = all.filter(refers).map(|e| e.index()).collect();
    if referring.is_empty() {
        return None;
    }
    for section in sections {
        tree.retain_children(section, |e| !referring.contains(&e.index()));
    }
    referring.iter().for_each(|&child| names.add(tree.element(child)));
    let copies = tree.add_child(0, name);
    for suffix in suffixes {
        for &child in &referring {
            let copy = tree.copy(child);
            for part in tree.element(copy).descendants().iter().map(|e| e.index()).collect::<Vec<_>>() {
                for (attribute, value) in suffixed(tree.element(part), suffix, names) {
                    tree.set_attribute(part, &attribute, &value);
                }
            }
            tree.adopt(copies, copy);
        }
    }
    Some(copies)
}

/// The attributes that get the suffix: the name, and references to parts that are replicated.
fn suffixed(element: Element, suffix: &str, names: &Names) -> Vec<(String, String)> {
    let own = element.raw("name").map(|a| ("name".to_owned(), format!("{}{suffix}", a.value.trim())));
    let others = references(element)
        .filter(|(_, sort, name)| !matches!(sort, Sort::Asset | Sort::Class) && names.has(*sort, name))
        .map(|(attribute, _, name)| (attribute.to_owned(), format!("{name}{suffix}")));
    own.into_iter().chain(others).collect()
}
