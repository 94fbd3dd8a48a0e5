//! From text to a [`Tree`]. What MuJoCo's, ROS's and Gazebo's readers forgive is forgiven and noted.

use std::collections::{BTreeMap, HashSet};
use std::sync::Arc;

use quick_xml::Reader;
use quick_xml::escape::{resolve_predefined_entity, unescape};
use quick_xml::events::attributes::AttrError;
use quick_xml::events::{BytesStart, Event};

use super::tree::{Attribute, MAX_DEPTH, MAX_ELEMENTS, Node, Note, Tree};
use crate::error::{FormatError, Location};

/// Parses a document; `file` names it in messages.
///
/// # Cost
/// Linear in the length of the text.
pub(crate) fn parse(text: &str, file: &str) -> Result<Tree, FormatError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut parser = Parser::new(text, file.into());
    let mut reader = Reader::from_str(text);
    reader.config_mut().allow_dangling_amp = true;
    // An element that is left open is reported where it begins, which the reader does not know.
    reader.config_mut().check_end_names = false;
    reader.config_mut().allow_unmatched_ends = true;
    loop {
        let start = reader.buffer_position() as usize;
        match reader.read_event() {
            Ok(Event::Eof) => break,
            Ok(event) => parser.take(event, start)?,
            Err(_) if parser.is_complete() => {
                parser.characters(&text[start..], start);
                break;
            }
            Err(error) => return Err(parser.malformed(reader.error_position() as usize, error.to_string())),
        }
    }
    parser.finish()
}

struct Parser<'x> {
    text: &'x str,
    cursor: Cursor<'x>,
    file: Arc<str>,
    tree: Tree,
    /// The elements that are not closed yet, outermost first, with their names as they are written.
    open: Vec<(usize, String)>,
    /// An element beside the root, which is passed over: how many of its elements are open.
    passing_over: usize,
    /// Whether text outside of the root element was noted.
    strayed: bool,
    declared: HashSet<String>,
    /// Prefixes that were met, with the first place and element.
    met: BTreeMap<String, (Location, String)>,
}

impl<'x> Parser<'x> {
    fn new(text: &'x str, file: Arc<str>) -> Self {
        let declared = ["xml", "xmlns", "xsi"].map(str::to_owned).into();
        let cursor = Cursor::new(text);
        let (tree, open, met) = (Tree::default(), Vec::new(), BTreeMap::new());
        Self { text, cursor, file, tree, open, passing_over: 0, strayed: false, declared, met }
    }

    fn take(&mut self, event: Event<'x>, start: usize) -> Result<(), FormatError> {
        match event {
            Event::Start(tag) => self.element(&tag, start, true),
            Event::Empty(tag) => self.element(&tag, start, false),
            Event::End(tag) => self.close(tag.name().as_ref(), start),
            Event::Text(text) => {
                let text = text.xml10_content();
                self.characters(&unescape(&text).unwrap_or(std::borrow::Cow::Borrowed(&text)), start);
                Ok(())
            }
            Event::CData(data) => {
                self.characters(&data.xml10_content(), start);
                Ok(())
            }
            Event::GeneralRef(reference) => {
                let own = reference.xml10_content();
                match (reference.resolve_char_ref(), resolve_predefined_entity(&own)) {
                    (Ok(Some(character)), _) => self.characters(character.encode_utf8(&mut [0; 4]), start),
                    (_, Some(text)) => self.characters(text, start),
                    _ => self.characters(&format!("&{own};"), start),
                }
                Ok(())
            }
            Event::Decl(_) => {
                if start > 0 {
                    let at = self.location(start);
                    let effect = "it is passed over: it belongs at the very beginning of the file";
                    self.note(at, "?xml", "the XML declaration is not first", effect);
                }
                Ok(())
            }
            Event::Comment(_) | Event::PI(_) | Event::DocType(_) | Event::Eof => Ok(()),
        }
    }

    /// Whether the root element has been closed.
    fn is_complete(&self) -> bool {
        self.open.is_empty() && !self.tree.nodes.is_empty()
    }

    fn element(&mut self, tag: &BytesStart<'x>, start: usize, has_content: bool) -> Result<(), FormatError> {
        let at = self.location(start);
        let written = tag.name().as_ref().to_owned();
        if self.passing_over > 0 || self.is_complete() {
            if self.passing_over == 0 {
                let effect = "it is left out: a file has one root element; put both into one";
                self.note(at, &written, "is a second root element", effect);
            }
            self.passing_over += usize::from(has_content);
            return Ok(());
        }
        if self.open.len() >= MAX_DEPTH {
            let reason = format!("nested more than {MAX_DEPTH} deep");
            return Err(FormatError::InvalidElement { at, element: written, reason });
        }
        if self.tree.nodes.len() >= MAX_ELEMENTS {
            let reason = format!("more than {MAX_ELEMENTS} elements");
            return Err(FormatError::InvalidElement { at, element: written, reason });
        }
        let name = self.local(&written, &at, &written);
        let attributes = self.attributes(tag, &name, start)?;
        let index = self.tree.nodes.len();
        let parent = self.open.last().map(|(parent, _)| *parent);
        if let Some(parent) = parent {
            self.tree.nodes[parent].children.push(index);
        }
        let Location { file, line, column } = at;
        let (text, children) = (String::new(), Vec::new());
        self.tree.nodes.push(Node { name, origin: 0, file, line, column, attributes, text, parent, children });
        if has_content {
            self.open.push((index, written));
        }
        Ok(())
    }

    fn attributes(&mut self, tag: &BytesStart<'x>, element: &str, start: usize) -> Result<Vec<Attribute>, FormatError> {
        let mut attributes: Vec<Attribute> = Vec::new();
        let mut list = tag.attributes();
        list.with_checks(false);
        if let Some(Err(AttrError::UnquotedValue(_))) = list.clone().find(Result::is_err) {
            let at = self.location(start);
            self.note(
                at,
                element,
                "has a value that is not in quotes",
                "it is read to the next space: put it in quotes",
            );
            list = tag.html_attributes();
            list.with_checks(false);
        }
        for attribute in list {
            let attribute = attribute.map_err(|error| self.bad_attribute(start, &error))?;
            let key: &str = attribute.key.as_ref();
            // The key is a piece of the text, so that its place can be told from its address.
            let offset =
                (key.as_ptr() as usize).wrapping_sub(self.text.as_ptr() as usize).clamp(start, self.text.len());
            let at = self.location(offset);
            if key == "xmlns" || key.starts_with("xsi:") {
                continue;
            }
            if let Some(prefix) = key.strip_prefix("xmlns:") {
                self.declared.insert(prefix.to_owned());
                continue;
            }
            let name = self.local(key, &at, element);
            if attributes.iter().any(|other| other.name == name) {
                let effect = "the first one counts: keep one";
                self.note(at, element, &format!("'{name}' is given twice"), effect);
                continue;
            }
            let value = match unescape(&attribute.value) {
                Ok(value) => value.into_owned(),
                Err(_) => {
                    self.note(
                        at.clone(),
                        element,
                        &format!("'{name}' has '&' and no entity"),
                        "it is kept: write '&amp;'",
                    );
                    attribute.value.clone().into_owned()
                }
            };
            attributes.push(Attribute { name, value, line: at.line, column: at.column });
        }
        Ok(attributes)
    }

    /// The name without its prefix, which is remembered.
    fn local(&mut self, written: &str, at: &Location, element: &str) -> String {
        let Some((prefix, name)) = written.split_once(':') else { return written.to_owned() };
        if !self.met.contains_key(prefix) {
            self.met.insert(prefix.to_owned(), (at.clone(), element.to_owned()));
        }
        name.to_owned()
    }

    fn close(&mut self, written: &str, start: usize) -> Result<(), FormatError> {
        if self.passing_over > 0 {
            self.passing_over -= 1;
            return Ok(());
        }
        match self.open.pop() {
            Some((_, open)) if open == written.trim_end() => Ok(()),
            Some((index, open)) => {
                let opened = self.tree.nodes[index].line;
                let reason =
                    format!("</{written}> where </{open}> is expected, which closes the <{open}> of line {opened}");
                Err(self.malformed(start, reason))
            }
            None => {
                let at = self.location(start);
                self.note(at, written, "is closed and was not open", "the closing tag is passed over: remove it");
                Ok(())
            }
        }
    }

    fn characters(&mut self, text: &str, start: usize) {
        if self.passing_over > 0 {
            return;
        }
        match self.open.last() {
            Some(&(index, _)) => {
                let node = &mut self.tree.nodes[index];
                if node.children.is_empty() {
                    node.text.push_str(text);
                }
            }
            None if text.trim().is_empty() || self.strayed => {}
            None => {
                self.strayed = true;
                let skipped = text.len() - text.trim_start().len();
                let at = self.location(start + skipped);
                let word = text.split_whitespace().next().unwrap_or_default();
                let word: String = word.chars().take(40).collect();
                let what = format!("text outside of the root element ('{word}')");
                self.note(at, "?", &what, "it is passed over: remove it, or make it a comment");
            }
        }
    }

    fn finish(mut self) -> Result<Tree, FormatError> {
        if let Some((index, open)) = self.open.last() {
            let Node { file, line, column, .. } = &self.tree.nodes[*index];
            let at = Location { file: file.clone(), line: *line, column: *column };
            return Err(FormatError::MalformedXml { at, reason: format!("<{open}> is not closed") });
        }
        if self.tree.nodes.is_empty() {
            let at = Location { file: self.file, line: 1, column: 1 };
            return Err(FormatError::MalformedXml { at, reason: "there is no element".into() });
        }
        for node in &mut self.tree.nodes {
            let text = node.text.trim();
            if text.len() != node.text.len() {
                node.text = text.to_owned();
            }
        }
        let undeclared: Vec<_> = self.met.iter().filter(|(prefix, _)| !self.declared.contains(*prefix)).collect();
        for (prefix, (at, element)) in undeclared {
            let what = format!("the namespace prefix '{prefix}' is not declared");
            let effect = format!("the name after it counts: write xmlns:{prefix}=\"…\" into the root element");
            self.tree.note(Note::other(at.clone(), element, what, effect));
        }
        Ok(self.tree)
    }

    fn note(&self, at: Location, element: &str, what: &str, effect: &str) {
        self.tree.note(Note::other(at, element, what, effect));
    }

    fn bad_attribute(&mut self, start: usize, error: &AttrError) -> FormatError {
        // Positions are relative to the name of the tag, which begins after '<'.
        let (within, reason) = match *error {
            AttrError::ExpectedEq(k) => (k, "an attribute without '=' and a value"),
            AttrError::ExpectedValue(k) => (k, "an attribute without a value"),
            AttrError::UnquotedValue(k) => (k, "a value that is not in quotes"),
            AttrError::ExpectedQuote(k, _) => (k, "a value whose quote is not closed"),
            AttrError::Duplicated(k, _) => (k, "an attribute that is given twice"),
        };
        self.malformed(start + 1 + within, reason.to_owned())
    }

    fn malformed(&mut self, offset: usize, reason: String) -> FormatError {
        FormatError::MalformedXml { at: self.location(offset), reason }
    }

    fn location(&mut self, offset: usize) -> Location {
        let (line, column) = self.cursor.position(offset);
        Location { file: self.file.clone(), line, column }
    }
}

/// Turns offsets into lines and columns. Offsets that grow cost no more than one walk over the text.
struct Cursor<'x> {
    text: &'x str,
    offset: usize,
    line: u32,
    column: u32,
}

impl<'x> Cursor<'x> {
    fn new(text: &'x str) -> Self {
        Self { text, offset: 0, line: 1, column: 1 }
    }

    /// Line and column of an offset, from 1, columns in characters.
    fn position(&mut self, offset: usize) -> (u32, u32) {
        if offset < self.offset {
            *self = Self::new(self.text);
        }
        let bytes = self.text.as_bytes();
        for &byte in &bytes[self.offset..offset.min(bytes.len())] {
            if byte == b'\n' {
                (self.line, self.column) = (self.line + 1, 1);
            } else if byte & 0xC0 != 0x80 {
                self.column += 1; // The first byte of a character.
            }
        }
        self.offset = offset.min(bytes.len());
        (self.line, self.column)
    }
}
