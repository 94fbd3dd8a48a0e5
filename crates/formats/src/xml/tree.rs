//! A tree of elements that may come from several files.

use std::sync::Arc;

use crate::error::{FormatError, Location};
use crate::xml::Attributes;

/// Elements deeper than this are refused: no real model comes near.
const MAX_DEPTH: usize = 2000;
/// More elements than this, includes counted, are refused.
const MAX_ELEMENTS: usize = 2_000_000;

/// An attribute with its place.
pub(crate) struct Attribute {
    pub name: String,
    pub value: String,
    line: u32,
    column: u32,
}

struct Node {
    name: String,
    file: Arc<str>,
    line: u32,
    column: u32,
    attributes: Vec<Attribute>,
    /// The text before the first child element, trimmed.
    text: String,
    children: Vec<usize>,
}

/// The elements of a document. Text after child elements, comments and processing instructions are dropped.
pub(crate) struct Tree {
    nodes: Vec<Node>,
}

/// One element of a [`Tree`].
#[derive(Clone, Copy)]
pub(crate) struct Element<'t> {
    tree: &'t Tree,
    index: usize,
}

/// Parses a document; `file` names it in messages.
pub(crate) fn parse(text: &str, file: &str) -> Result<Tree, FormatError> {
    let file: Arc<str> = file.into();
    let options = roxmltree::ParsingOptions { nodes_limit: MAX_ELEMENTS as u32 * 4, ..Default::default() };
    let document = roxmltree::Document::parse_with_options(text, options).map_err(|error| {
        let at = Location { file: file.clone(), line: error.pos().row, column: error.pos().col };
        FormatError::MalformedXml { at, reason: error.to_string() }
    })?;
    let lines = LineStarts::new(text);
    let mut tree = Tree { nodes: Vec::new() };
    let mut indices = vec![usize::MAX; document.descendants().count()];
    for node in document.descendants().filter(|n| n.is_element()) {
        let (line, column) = lines.position(text, node.range().start);
        let at = Location { file: file.clone(), line, column };
        tree.check_size(&at)?;
        let attributes = node.attributes().map(|a| {
            let (line, column) = lines.position(text, a.range().start);
            Attribute { name: a.name().to_owned(), value: a.value().to_owned(), line, column }
        });
        let index = tree.nodes.len();
        tree.nodes.push(Node {
            name: node.tag_name().name().to_owned(),
            file: file.clone(),
            line,
            column,
            attributes: attributes.collect(),
            text: node.text().unwrap_or_default().trim().to_owned(),
            children: Vec::new(),
        });
        indices[node.id().get_usize()] = index;
        if let Some(parent) = node.parent_element() {
            tree.nodes[indices[parent.id().get_usize()]].children.push(index);
        }
    }
    tree.check_depth()?;
    Ok(tree)
}

impl Tree {
    pub fn root(&self) -> Element<'_> {
        Element { tree: self, index: 0 }
    }

    /// Every element, parents before children.
    pub fn elements(&self) -> impl Iterator<Item = Element<'_>> {
        (0..self.nodes.len()).map(|index| Element { tree: self, index })
    }

    /// Replaces the element at `index` by the children of the root of `other`.
    pub fn splice(&mut self, index: usize, other: Tree) -> Result<(), FormatError> {
        let offset = self.nodes.len();
        let roots: Vec<usize> = other.nodes[0].children.iter().map(|c| c + offset).collect();
        for mut node in other.nodes {
            node.children.iter_mut().for_each(|c| *c += offset);
            self.nodes.push(node);
        }
        for node in &mut self.nodes[..offset] {
            if let Some(k) = node.children.iter().position(|&c| c == index) {
                node.children.splice(k..=k, roots);
                break;
            }
        }
        let at = self.root().at();
        self.check_size(&at)?;
        self.check_depth()
    }

    fn check_size(&self, at: &Location) -> Result<(), FormatError> {
        if self.nodes.len() < MAX_ELEMENTS {
            return Ok(());
        }
        let reason = format!("more than {MAX_ELEMENTS} elements");
        Err(FormatError::InvalidElement { at: at.clone(), element: self.nodes[0].name.clone(), reason })
    }

    fn check_depth(&self) -> Result<(), FormatError> {
        let mut level = vec![self.root()];
        for _ in 0..MAX_DEPTH {
            level = level.iter().flat_map(|e| e.children()).collect();
            if level.is_empty() {
                return Ok(());
            }
        }
        Err(level[0].invalid(format!("nested more than {MAX_DEPTH} deep")))
    }
}

impl<'t> Element<'t> {
    pub fn name(&self) -> &'t str {
        &self.node().name
    }

    pub fn is(&self, name: &str) -> bool {
        self.name() == name
    }

    pub fn index(&self) -> usize {
        self.index
    }

    pub fn at(&self) -> Location {
        let node = self.node();
        Location { file: node.file.clone(), line: node.line, column: node.column }
    }

    pub fn location_of(&self, attribute: &Attribute) -> Location {
        Location { file: self.node().file.clone(), line: attribute.line, column: attribute.column }
    }

    pub fn children(&self) -> impl DoubleEndedIterator<Item = Element<'t>> + use<'t> {
        let tree = self.tree;
        self.node().children.iter().map(move |&index| Element { tree, index })
    }

    pub fn children_named(&self, name: &'t str) -> impl DoubleEndedIterator<Item = Element<'t>> + use<'t> {
        self.children().filter(move |c| c.is(name))
    }

    pub fn child(&self, name: &'t str) -> Option<Element<'t>> {
        self.children_named(name).next()
    }

    /// The text of the element, trimmed.
    pub fn text(&self) -> &'t str {
        &self.node().text
    }

    pub fn raw_attributes(&self) -> &'t [Attribute] {
        &self.node().attributes
    }

    pub fn raw(&self, name: &str) -> Option<&'t Attribute> {
        self.raw_attributes().iter().find(|a| a.name == name)
    }

    /// The element's own attributes, for typed reading.
    pub fn attributes(&self) -> Attributes<'t> {
        Attributes::new(*self, Vec::new())
    }

    pub fn invalid(&self, reason: impl Into<String>) -> FormatError {
        FormatError::InvalidElement { at: self.at(), element: self.name().to_owned(), reason: reason.into() }
    }

    pub fn incomplete(&self, missing: impl Into<std::borrow::Cow<'static, str>>) -> FormatError {
        FormatError::Incomplete { at: self.at(), element: self.name().to_owned(), missing: missing.into() }
    }

    fn node(&self) -> &'t Node {
        &self.tree.nodes[self.index]
    }
}

/// Byte offsets at which lines start, to turn an offset into line and column in logarithmic time.
struct LineStarts(Vec<usize>);

impl LineStarts {
    fn new(text: &str) -> Self {
        let ends = text.bytes().enumerate().filter(|(_, b)| *b == b'\n').map(|(i, _)| i + 1);
        Self(std::iter::once(0).chain(ends).collect())
    }

    fn position(&self, text: &str, offset: usize) -> (u32, u32) {
        let line = self.0.partition_point(|&start| start <= offset).max(1);
        let column = text.get(self.0[line - 1]..offset).map_or(0, |s| s.chars().count()) + 1;
        (line as u32, column as u32)
    }
}
