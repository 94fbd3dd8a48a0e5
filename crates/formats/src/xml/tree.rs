//! A tree of elements that may come from several files.

use std::cell::RefCell;
use std::collections::HashSet;
use std::sync::Arc;

use crate::error::{FormatError, Location};

/// Elements deeper than this are refused: no real model comes near.
pub(super) const MAX_DEPTH: usize = 2000;
/// More elements than this, includes counted, are refused.
pub(super) const MAX_ELEMENTS: usize = 2_000_000;

/// An attribute with its place.
#[derive(Clone)]
pub(crate) struct Attribute {
    pub name: String,
    pub value: String,
    pub(super) line: u32,
    pub(super) column: u32,
}

#[derive(Clone)]
pub(super) struct Node {
    pub name: String,
    /// Number of the document whose conventions it is written in: 0 for the main one and its includes.
    pub origin: u32,
    pub file: Arc<str>,
    pub line: u32,
    pub column: u32,
    pub attributes: Vec<Attribute>,
    /// The text before the first child element, trimmed.
    pub text: String,
    pub parent: Option<usize>,
    pub children: Vec<usize>,
}

/// Something that a reader met, went on without, and that the report is to tell.
#[derive(Clone)]
pub(crate) struct Note {
    pub at: Location,
    pub element: String,
    pub what: String,
    pub effect: String,
    pub changes_motion: bool,
}

impl Note {
    /// A note about something that cannot change the motion.
    pub fn other(at: Location, element: &str, what: impl Into<String>, effect: impl Into<String>) -> Self {
        Self { at, element: element.to_owned(), what: what.into(), effect: effect.into(), changes_motion: false }
    }
}

/// The elements of a document. Text after child elements, comments and processing instructions are dropped.
#[derive(Clone, Default)]
pub(crate) struct Tree {
    pub(super) nodes: Vec<Node>,
    notes: RefCell<Vec<Note>>,
}

/// One element of a [`Tree`].
#[derive(Clone, Copy)]
pub(crate) struct Element<'t> {
    tree: &'t Tree,
    index: usize,
}

impl Tree {
    pub fn root(&self) -> Element<'_> {
        Element { tree: self, index: 0 }
    }

    /// The element of that index.
    pub fn element(&self, index: usize) -> Element<'_> {
        Element { tree: self, index }
    }

    /// Every element, parents before children.
    pub fn elements(&self) -> impl Iterator<Item = Element<'_>> {
        (0..self.nodes.len()).map(|index| Element { tree: self, index })
    }

    /// Replaces the element at `index` by the children of the root of `other`.
    pub fn splice(&mut self, index: usize, other: Tree) -> Result<(), FormatError> {
        let (offset, parent) = (self.nodes.len(), self.nodes[index].parent);
        let Some(parent) = parent else { return Err(self.root().invalid("cannot be the root element")) };
        self.take_notes_of(&other);
        let origin = self.nodes[index].origin;
        let roots: Vec<usize> = other.nodes[0].children.iter().map(|c| c + offset).collect();
        for mut node in other.nodes {
            node.children.iter_mut().for_each(|c| *c += offset);
            node.parent = node.parent.map(|p| p + offset);
            node.origin = origin;
            self.nodes.push(node);
        }
        roots.iter().for_each(|&root| self.nodes[root].parent = Some(parent));
        let siblings = &mut self.nodes[parent].children;
        if let Some(k) = siblings.iter().position(|&c| c == index) {
            siblings.splice(k..=k, roots);
        }
        self.check_size()
    }

    /// Notes something for the report.
    pub fn note(&self, note: Note) {
        self.notes.borrow_mut().push(note);
    }

    /// What was noted so far, each thing once (defaults are read again for every element that has them),
    /// by file and line.
    pub fn take_notes(&self) -> Vec<Note> {
        let mut known = HashSet::new();
        let mut notes = self.notes.take();
        notes.retain(|note| known.insert((note.at.clone(), note.what.clone())));
        notes.sort_by(|a, b| (&a.at.file, a.at.line, a.at.column).cmp(&(&b.at.file, b.at.line, b.at.column)));
        notes
    }

    /// Takes over what was noted in another document.
    pub(super) fn take_notes_of(&mut self, other: &Tree) {
        self.notes.get_mut().append(&mut other.notes.take());
    }

    pub fn check_size(&self) -> Result<(), FormatError> {
        if self.nodes.len() < MAX_ELEMENTS {
            return Ok(());
        }
        Err(self.root().invalid(format!("more than {MAX_ELEMENTS} elements")))
    }

    /// Whether no element is nested too deep; after files were put into each other.
    pub fn check_depth(&self) -> Result<(), FormatError> {
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

    /// Number of the document whose conventions the element is written in: 0 for the main one, others for those attached to it.
    pub fn origin(&self) -> usize {
        self.node().origin as usize
    }

    /// The element and all below it, in the order of the document.
    pub fn descendants(&self) -> Vec<Element<'t>> {
        let (mut all, mut open) = (Vec::new(), vec![*self]);
        while let Some(element) = open.pop() {
            all.push(element);
            open.extend(element.children().rev());
        }
        all
    }

    /// The parent and all above it, nearest first.
    pub fn ancestors(&self) -> impl Iterator<Item = Element<'t>> + use<'t> {
        std::iter::successors(self.parent(), Element::parent)
    }

    pub fn parent(&self) -> Option<Element<'t>> {
        self.node().parent.map(|index| Element { tree: self.tree, index })
    }

    pub fn at(&self) -> Location {
        let node = self.node();
        Location { file: node.file.clone(), line: node.line, column: node.column }
    }

    /// Notes something about the element for the report.
    pub fn note(&self, at: Location, what: impl Into<String>, effect: impl Into<String>, changes_motion: bool) {
        let (what, effect) = (what.into(), effect.into());
        self.tree.note(Note { at, element: self.name().to_owned(), what, effect, changes_motion });
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
