//! What the readers of COLLADA share.

use crate::xml::Element;

pub(super) fn child<'d>(node: Element<'d>, name: &'static str) -> Option<Element<'d>> {
    children(node, name).next()
}

pub(super) fn children<'d>(node: Element<'d>, name: &'static str) -> impl Iterator<Item = Element<'d>> {
    node.children_named(name)
}

pub(super) fn attribute<'d>(node: Element<'d>, name: &str) -> Option<&'d str> {
    node.raw(name).map(|a| a.value.as_str())
}

/// The numbers of an element's text.
pub(super) fn numbers<T: std::str::FromStr>(element: Option<Element>) -> Result<Vec<T>, String> {
    let Some(element) = element else { return Ok(Vec::new()) };
    let parsed: Result<Vec<T>, T::Err> = element.text().split_ascii_whitespace().map(str::parse).collect();
    parsed.map_err(|_| format!("line {}: <{}> holds something that is not a number", line(element), element.name()))
}

pub(super) fn line(node: Element) -> u32 {
    node.at().line
}
